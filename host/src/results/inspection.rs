//! What a recording holds, and what it was recognised as.

use crate::recordings::About;
use schemars::JsonSchema;
use serde::Serialize;

/// A recording that was read, and its pictures.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Inspection {
    /// The file or folder.
    pub file: String,
    /// Its format, axes and sensor.
    #[serde(flatten)]
    pub about: About,
    /// Rate of the samples of slow time in Hz.
    pub rate_hz: f64,
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// Length in s.
    pub seconds: f64,
    /// Mean power in dB: of integers against full scale, else of the numbers as they are.
    pub power_db: f64,
    /// SHA-256 of the samples taken: int16 of slots, else f64, complex ones as two, little-endian.
    pub samples_sha256: String,
    /// Receive antenna that was taken, from 1; of a radar module's chirps only.
    pub antenna: u32,
    /// Chirp of every frame that was taken, from 1, or `all`; of a radar module's chirps only.
    pub chirp: String,
    /// The scenario in TOML whose radar is this sensor.
    pub scenario: Option<String>,
    /// Why no scenario matches the sensor, or the scenario is not of these slots.
    pub scenario_problem: Option<String>,
    /// Names of the figures, without extensions.
    pub figures: Vec<String>,
}

/// Recordings classified by a model.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Classified {
    /// The model file.
    pub model: String,
    /// Slots of a window.
    pub sensing_slots: u32,
    /// Its classes, in the order of the logits.
    pub classes: Vec<String>,
    /// Recording by recording.
    pub recordings: Vec<ClassifiedRecording>,
}

/// A recording's windows.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ClassifiedRecording {
    /// The file or folder.
    pub file: String,
    /// Its format.
    pub format: String,
    /// Its slots.
    pub slots: u32,
    /// Window by window.
    pub windows: Vec<ClassifiedWindow>,
}

/// What a window was recognised as.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ClassifiedWindow {
    /// Number of its first slot.
    pub first_slot: u32,
    /// Time of its first slot in s.
    pub start_s: f64,
    /// The most probable class, or `unknown` below the least confidence.
    pub class: String,
    /// Probability of the most probable class by softmax, 0 to 1.
    pub confidence: f64,
    /// The network's logits, int8.
    pub logits: Vec<i8>,
}
