//! A scenario: everything a run depends on besides its seed, read from TOML and validated once.
//!
//! Units are in the field names (`_m`, `_s`, `_hz`, `_db`, `_w`, `_deg`). Unknown keys are refused. Defaults are
//! the paper's section VI where it gives a value.

mod annotated;
pub mod budget;
pub mod builtin;
mod channel;
mod check;
mod communication;
mod defaults;
mod error;
mod front_end;
mod learning;
mod overrides;
mod people;
mod preset;
mod radar;
mod read;
mod room;
mod rules;
mod schema;

pub use channel::{
    Advance, ArMode, Channel, Clusters, Doppler, Environment, Interior, Model, Polarisation, Tgn,
};
pub use communication::Communication;
pub use error::ScenarioError;
pub use front_end::{Effects, Spectrum};
pub use learning::{Learning, Optimizer, Schedule};
pub use overrides::Override;
pub use people::{Class, Other, Target};
pub use radar::{AntennaPattern, Dechirp, Format, FrontEnd, Radar};
pub use read::syntax_message;
pub use room::{Furniture, Material, Room, Surface};
pub use rules::Rule;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Speed of light in m/s.
pub const SPEED_OF_LIGHT: f64 = 299_792_458.0;

/// Everything a run depends on besides its seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// Name shown in results.
    pub name: String,
    /// The room's walls.
    pub room: Room,
    /// The monostatic radar.
    pub radar: Radar,
    /// The time frame shared by sensing and communication.
    pub frame: Frame,
    /// The channel model.
    pub channel: Channel,
    /// The person sensed.
    pub target: Target,
    /// From slow time to the network's image.
    pub spectrogram: SpectrogramSettings,
    /// How networks are trained and tested.
    pub learning: Learning,
    /// The communication side.
    pub communication: Communication,
    /// Zones of the accuracy-throughput region and the operating point in it.
    pub optimizer: OperatingRule,
}

/// Time frame: slots, period, spacing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Frame {
    /// Slot duration T_s in s.
    pub slot_s: f64,
    /// Slots in a scheduling period, N.
    pub period_slots: u32,
    /// Communication slots between two sensing slots, N_m.
    pub spacing_slots: u32,
    /// The numbers of sensing slots N_s that are studied, ascending.
    pub sensing_slots: Vec<u32>,
}

/// From slow time to the network's image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SpectrogramSettings {
    /// First singular component kept, the paper's d; 1 keeps the clutter; 0: decided per recording, components with a static slow-time signal
    /// are dropped.
    pub first_kept: u8,
    /// Last singular component kept (of 8).
    pub last_kept: u8,
    /// Kaiser window length N_w in sensing slots.
    pub window: u16,
    /// Kaiser window's beta. The paper has 10; 4 resolves slow bodies better and gains 4 points of accuracy at N_s = 200.
    pub beta: f32,
    /// Sensing slots between two frames.
    pub hop: u16,
    /// FFT bins averaged into one of the 64 rows: 1, 2 or 4.
    pub bins_per_row: u8,
    /// Dynamic range in dB; weaker is black.
    pub range_db: f64,
}

/// Zones and operating point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OperatingRule {
    /// Weight of normalised accuracy in the operating point's weighted sum (throughput has the rest).
    pub accuracy_weight: f64,
    /// Case (1-based) of the operating point that the scheduler takes.
    pub case: u32,
    /// A point is saturated where the smaller normalised marginal rate is below this share of the larger.
    pub zone_ratio: f64,
}
