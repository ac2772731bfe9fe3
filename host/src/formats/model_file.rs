//! The model file: an int8 network with everything the radar module needs to use it, as bytes.
//!
//! Little endian: a header of 64 bytes, class names of 24 bytes, the layers in the order they run (stem; per block
//! affine, conv1, conv2, add; head), an ed25519 signature if the header says so, and a CRC-32 (IEEE 802.3) of all that.
//! `sdp3_core::dsn::model` reads it.

use crate::error::Invalid;
use crate::scenario::Scenario;
use sdp3_core::config::RadarConfig;
use sdp3_core::dsn::Model;

mod check;
mod read;
pub(crate) mod rescale;
pub(crate) mod signature;
mod summary;
mod words;
mod write;
pub use check::ModelFileError;
pub(in crate::formats) use read::header_and_names;
pub use summary::{ModelCheck, Shown, Summary};
use words::sweep_words;
pub(in crate::formats) use write::closed;
pub use write::with_graph;

/// What makes the int8 networks of a folder.
pub(crate) const QUANTIZE_FIRST: &str = "`sdp3 run` or `sdp3 quantize` with the same --out makes it";

/// Where a folder has the int8 network of so many sensing slots.
pub(crate) fn name(sensing_slots: u32) -> String {
    format!("models/dsn-{sensing_slots}.sdp3")
}

/// Version of the format written.
pub const VERSION: u16 = 1;
/// Bytes of the header.
pub const HEADER_BYTES: usize = 64;
/// Bytes of a class name, zero padded.
pub const NAME_BYTES: usize = 24;
/// Where the header holds the radar's configuration: eight bytes, zeros for the paper's.
pub const RADAR_AT: usize = 48;
const KIND_CONV: u8 = 1;
const KIND_BATCH_NORM: u8 = 2;
const KIND_ADD: u8 = 3;
const KIND_HEAD: u8 = 4;
/// Doppler rows of every image.
pub const ROWS: u16 = 64;

/// How raw slots become the network's image; the radar module takes all of it from the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preprocessing {
    /// The sensor's samples.
    pub radar: RadarConfig,
    /// Sensing slots per recording, `N_s`.
    pub sensing_slots: u16,
    /// First singular component kept, 1 to 8; 0: decided per recording.
    pub first_kept: u8,
    /// Last singular component kept, `first_kept..=8`, at least 1.
    pub last_kept: u8,
    /// Kaiser window's length in sensing slots, 2 to 256.
    pub window_len: u16,
    /// Sensing slots between two frames, `1..=window_len`.
    pub hop: u16,
    /// FFT bins added into one row: 1, 2 or 4.
    pub bins_per_row: u8,
    /// Dynamic range in 1/64 octave of power, 1 to 4095 (1063 is 50 dB).
    pub range: u16,
    /// Kaiser window's beta, 0 to 40.
    pub kaiser_beta: f32,
    /// Carrier frequency in kHz (for people; no arithmetic depends on it).
    pub carrier_khz: u32,
    /// Time between two sensing slots in microseconds (for people; no arithmetic depends on it).
    pub slow_time_us: u32,
}

impl Preprocessing {
    /// STFT frames of a recording: `(N_s - window) / hop + 1`, or 0 where the window does not fit.
    pub fn frames(&self) -> u16 {
        match self.sensing_slots.checked_sub(self.window_len) {
            Some(rest) if self.hop > 0 => (rest / self.hop).saturating_add(1),
            _ => 0,
        }
    }
}

/// A layer with int8 weights: `q_out = clamp(requantize(bias + sum (q_in - in_zp) w, multiplier, shift) + out_zp)`.
///
/// `O` output channels; weights `[O][3][3][I]` of a convolution, `[O][I]` of the head, `[O]` of an affine layer.
#[derive(Debug, Clone, PartialEq)]
pub struct QuantizedLayer {
    /// Real size of one step of the input.
    pub in_scale: f32,
    /// Real size of one step of the output.
    pub out_scale: f32,
    /// Input value that stands for zero.
    pub in_zero: i8,
    /// Output value that stands for zero.
    pub out_zero: i8,
    /// Smallest output.
    pub act_min: i8,
    /// Largest output.
    pub act_max: i8,
    /// Q31 multipliers `[O]`, 2^30..2^31-1 or 0.
    pub multipliers: Vec<i32>,
    /// Biases `[O]` in steps of the accumulator.
    pub biases: Vec<i32>,
    /// Shifts `[O]`, -31 to 7; positive is to the left.
    pub shifts: Vec<i8>,
    /// Weights.
    pub weights: Vec<i8>,
}

/// The addition that closes a residual block: `x + t`.
#[derive(Debug, Clone, PartialEq)]
pub struct Add {
    /// Real size of one step of the skip.
    pub in1_scale: f32,
    /// Real size of one step of the branch.
    pub in2_scale: f32,
    /// Real size of one step of the sum.
    pub out_scale: f32,
    /// Skip's value for zero.
    pub in1_zero: i8,
    /// Branch's value for zero.
    pub in2_zero: i8,
    /// Sum's value for zero.
    pub out_zero: i8,
    /// Smallest output.
    pub act_min: i8,
    /// Largest output.
    pub act_max: i8,
    /// Multipliers of skip, branch and sum.
    pub multipliers: [i32; 3],
    /// Shifts of skip, branch and sum.
    pub shifts: [i8; 3],
}

/// A residual block.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// First batch normalisation and ReLU, per channel.
    pub affine: QuantizedLayer,
    /// First convolution, with the second batch normalisation and ReLU folded in.
    pub conv1: QuantizedLayer,
    /// Second convolution.
    pub conv2: QuantizedLayer,
    /// Addition of the skip.
    pub add: Add,
}

/// An int8 deep spectrogram network with its preprocessing: the content of a model file.
#[derive(Debug, Clone, PartialEq)]
pub struct QuantizedNetwork {
    /// From raw slots to the image.
    pub preprocessing: Preprocessing,
    /// Class names, in the order of the logits.
    pub classes: Vec<String>,
    /// Stride of the input convolution, 1 or 2.
    pub stem_stride: u8,
    /// Input convolution, 1 -> C.
    pub stem: QuantizedLayer,
    /// Residual blocks.
    pub blocks: Vec<Block>,
    /// Classifier, C -> classes.
    pub head: QuantizedLayer,
}

/// Refuses a model for another radar than the scenario's, or for another N_s.
///
/// # Errors
/// What the radar module's parser finds wrong, or what differs.
pub fn check_use(bytes: &[u8], scenario: &Scenario, sensing_slots: u32) -> Result<(), ModelFileError> {
    let model = Model::parse(bytes)?;
    let field =
        |field: &str, value: String, legal: String| Err(Invalid::new(field, value, legal).at("model").into());
    let (found, radar) = (model.radar(), scenario.radar.config());
    if found != radar {
        return field(
            "radar",
            sweep_words(&found),
            format!("{}, as the scenario has it", sweep_words(&radar)),
        );
    }
    let found = model.sensing_slots();
    if found != sensing_slots as usize {
        return field(
            "sensing_slots",
            found.to_string(),
            format!("{sensing_slots}, as the file's name says"),
        );
    }
    Ok(())
}

impl QuantizedNetwork {
    /// Channels of every convolution.
    pub fn channels(&self) -> usize {
        self.stem.biases.len()
    }

    /// Number of weights and biases.
    pub fn parameters(&self) -> usize {
        self.weighted().iter().map(|(_, _, _, layer)| layer.weights.len() + layer.biases.len()).sum()
    }

    /// The layers that have weights, in order: name, kind, inputs per output, layer.
    fn weighted(&self) -> Vec<(String, u8, usize, &QuantizedLayer)> {
        let c = self.channels();
        let mut all = vec![("stem".to_string(), KIND_CONV, 9, &self.stem)];
        for (b, block) in self.blocks.iter().enumerate() {
            all.push((format!("block {b} affine"), KIND_BATCH_NORM, 1, &block.affine));
            all.push((format!("block {b} conv1"), KIND_CONV, 9 * c, &block.conv1));
            all.push((format!("block {b} conv2"), KIND_CONV, 9 * c, &block.conv2));
        }
        all.push(("head".to_string(), KIND_HEAD, c, &self.head));
        all
    }
}

#[cfg(test)]
pub(crate) mod tests;
