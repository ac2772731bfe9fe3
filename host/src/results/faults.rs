//! What faults on purpose became.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Faults of one kind.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct FaultRow {
    /// What was done.
    pub kind: String,
    /// How often.
    pub injected: u64,
    /// Told exactly once, by their name.
    pub detected: u64,
    /// Followed by a whole period as wanted; samples and models: not used.
    pub recovered: u64,
    /// Not told.
    pub silent: u64,
    /// Promises broken on the way.
    pub broken: u64,
}

/// Spoiled samples in recordings, and what they cost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpoiledRow {
    /// What was done.
    pub kind: String,
    /// Recordings.
    pub recordings: u32,
    /// Share of the slots that the guarded station asked for that it was done to.
    pub slots: f64,
    /// Share of those that the guard refused.
    pub refused: f64,
    /// Share of recordings recognised if nothing looks at samples.
    pub unguarded: f64,
    /// Share of recordings recognised by the guarded station.
    pub guarded: f64,
    /// Share of recordings without a verdict from it: too few slots were left.
    pub without_verdict: f64,
}

/// A table of faults, and what of it firmware must find too.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FaultTable {
    /// Faults.
    pub events: u64,
    /// The first so many of them.
    pub events_of_part: u64,
    /// Digest of their outcomes, in hexadecimal: firmware finds the same.
    pub digest_of_part: String,
    /// By kind.
    pub rows: Vec<FaultRow>,
}

/// A fault campaign: what `sdp3 schedule --faults` finds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Faults {
    /// Seed of the first part.
    pub seed: u64,
    /// Against schedule, model and samples, each by itself.
    pub guards: FaultTable,
    /// Against recordings on their way through the whole chain.
    pub recordings: FaultTable,
    /// Share of untouched recordings recognised.
    pub accuracy: f64,
    /// What spoiled samples cost.
    pub spoiled: Vec<SpoiledRow>,
    /// Whether no fault of schedule, model or recording was silent and no promise broke.
    pub held: bool,
}
