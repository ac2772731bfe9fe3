//! Networks of a run, tested again.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The int8 networks of a run, tested on recordings simulated again; nothing is trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Retested {
    /// AR(1) coefficient rho of the room channel in these recordings.
    pub rho: f64,
    /// N_s by N_s.
    pub accuracy: Vec<RetestedAccuracy>,
}

/// How many of the recordings a network recognised.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RetestedAccuracy {
    /// Sensing slots of a recording, N_s.
    pub sensing_slots: u32,
    /// Recordings recognised by the int8 network.
    pub recognised: u32,
    /// Recordings tested.
    pub tested: u32,
    /// Their share, 0 to 1.
    pub int8: f64,
}
