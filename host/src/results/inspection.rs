//! What a recording holds, and what it was recognised as.

use schemars::JsonSchema;
use serde::Serialize;

/// Format and axes of a recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct About {
    /// Its format.
    pub format: String,
    /// What its axes are, and its numbers.
    pub axes: String,
    /// Lengths of the axes.
    pub shape: Vec<usize>,
    /// What a radar module's configuration says.
    pub sensor: Option<Sensor>,
}

impl About {
    /// Of a file without a radar module's configuration.
    pub fn new(format: &str, axes: impl Into<String>, shape: Vec<usize>) -> Self {
        About { format: format.to_owned(), axes: axes.into(), shape, sensor: None }
    }
}

/// What a module's configuration says of its chirps.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Sensor {
    /// Make of the module.
    pub name: String,
    /// Frequency in Hz at the first sample of a chirp.
    pub carrier_hz: f64,
    /// Bandwidth in Hz swept while samples are taken.
    pub bandwidth_hz: f64,
    /// Sampling rate in Hz.
    pub sample_rate_hz: f64,
    /// Samples of a chirp.
    pub samples: u32,
    /// Whether a sample is I and Q.
    pub complex: bool,
    /// Bits of the converter.
    pub converter_bits: u8,
    /// Receive antennas.
    pub antennas: u32,
    /// Chirps of a frame.
    pub chirps: u32,
    /// Mask of the transmit antennas of each chirp in its order, repeated through the frame.
    pub transmitters: Vec<u32>,
    /// Time from chirp to chirp in s.
    pub chirp_s: f64,
    /// Time from frame to frame in s.
    pub frame_s: f64,
}

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
    pub antenna: Option<u32>,
    /// Chirp of every frame that was taken, from 1, or `all`; of a radar module's chirps only.
    pub chirp: Option<String>,
    /// The scenario in TOML that has this sensor as its radar.
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
    /// Early exits; absent: every window used all its slots.
    pub early_exits: Option<UsedExits>,
    /// Recording by recording.
    pub recordings: Vec<ClassifiedRecording>,
}

/// Early exits that windows were classified with.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct UsedExits {
    /// The folder with their models.
    pub folder: String,
    /// Sensing slots after which they classify, ascending.
    pub sensing_slots: Vec<u32>,
    /// Confidence that stops; above 1 none does.
    pub threshold: f64,
    /// Whether `sdp3 early-exits` fitted their weights; else an exit's confidence is its network's own softmax.
    pub fitted: bool,
    /// Mean number of slots that a window used.
    pub mean_slots_used: f64,
}

/// What the module's supervision of samples says of a recording's slots.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct SampleSupervision {
    /// Slots that the module would not use: it would begin the window again.
    pub faulty_slots: u32,
    /// Fault by fault, in the order of their first slots.
    pub faults: Vec<SampleFaults>,
}

/// Slots with one kind of fault.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SampleFaults {
    /// Kind of the fault: silent, stuck, saturated or offset.
    pub fault: String,
    /// How many slots have it.
    pub slots: u32,
    /// Number of the first.
    pub first_slot: u32,
    /// What is wrong with the first.
    pub first: String,
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
    /// What the supervision of samples says of it; absent: it did not look.
    pub supervision: Option<SampleSupervision>,
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
    /// Slots after which it was classified: all of the window's, or those of an early exit.
    pub slots_used: u32,
    /// How many of these slots the module would not use; absent: the supervision of samples did not look.
    pub faulty_slots: Option<u32>,
    /// The most probable class, or `unknown` below the least confidence.
    pub class: String,
    /// Probability of the most probable class by softmax, 0 to 1; with early exits, of the evidence of all exits so far.
    pub confidence: f64,
    /// The logits of the network that classified, int8.
    pub logits: Vec<i8>,
}
