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
use write::{KIND_BATCH_NORM, KIND_CONV, KIND_HEAD};

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
pub(crate) mod tests {
    use super::*;
    use crate::network::interchange::header;
    use crate::scenario::Scenario;

    fn weighted(outputs: usize, inputs: usize, seed: i32) -> QuantizedLayer {
        let o = outputs as i32;
        QuantizedLayer {
            in_scale: 0.5,
            out_scale: 0.25 + seed as f32,
            in_zero: -128,
            out_zero: seed as i8,
            act_min: -128,
            act_max: 100,
            multipliers: (0..o).map(|i| (1 << 30) + 977 * i + seed).collect(),
            biases: (0..o).map(|i| 1000 * (i - 2) - seed).collect(),
            shifts: (0..o).map(|i| (i % 9 - 5) as i8).collect(),
            weights: (0..outputs * inputs).map(|i| (i as i32 * 37 + seed) as i8).collect(),
        }
    }

    pub(crate) fn network() -> QuantizedNetwork {
        let block = |s: i32| Block {
            affine: weighted(4, 1, s),
            conv1: weighted(4, 36, s + 1),
            conv2: weighted(4, 36, s + 2),
            add: Add {
                in1_scale: 1.5,
                in2_scale: 2.5,
                out_scale: 3.5,
                in1_zero: -1,
                in2_zero: -2,
                out_zero: -3,
                act_min: -128,
                act_max: 127,
                multipliers: [1 << 30, (1 << 30) + 1, i32::MAX],
                shifts: [-1, 0, -19],
            },
        };
        QuantizedNetwork {
            preprocessing: header(&Scenario::default(), 200),
            classes: ["standing", "child-walking", "adult-pacing"].map(String::from).to_vec(),
            stem_stride: 2,
            stem: weighted(4, 9, 3),
            blocks: vec![block(10), block(20)],
            head: weighted(3, 4, 30),
        }
    }

    /// A second reading of the format, field by field, that shares nothing with the writer.
    struct Reader<'a>(&'a [u8], usize);

    impl Reader<'_> {
        fn take<const N: usize>(&mut self) -> [u8; N] {
            self.1 += N;
            self.0[self.1 - N..self.1].try_into().unwrap()
        }
        fn i8(&mut self) -> i8 {
            i8::from_le_bytes(self.take())
        }
        fn u16(&mut self) -> u16 {
            u16::from_le_bytes(self.take())
        }
        fn u32(&mut self) -> u32 {
            u32::from_le_bytes(self.take())
        }
        fn f32(&mut self) -> f32 {
            f32::from_le_bytes(self.take())
        }
        fn i32s(&mut self, n: usize) -> Vec<i32> {
            (0..n).map(|_| i32::from_le_bytes(self.take())).collect()
        }
        fn i8s(&mut self, n: usize) -> Vec<i8> {
            let values = (0..n).map(|_| self.i8()).collect();
            for _ in n..n.next_multiple_of(4) {
                assert_eq!(self.i8(), 0);
            }
            values
        }
        fn weighted(&mut self, kind: i8, outputs: usize, inputs: usize) -> QuantizedLayer {
            assert_eq!(self.i8(), kind);
            let [in_zero, out_zero, act_min, act_max] = [self.i8(), self.i8(), self.i8(), self.i8()];
            assert_eq!(self.take::<3>(), [0; 3]);
            QuantizedLayer {
                in_zero,
                out_zero,
                act_min,
                act_max,
                in_scale: self.f32(),
                out_scale: self.f32(),
                multipliers: self.i32s(outputs),
                biases: self.i32s(outputs),
                shifts: self.i8s(outputs),
                weights: self.i8s(outputs * inputs),
            }
        }
        fn add(&mut self) -> Add {
            assert_eq!(self.i8(), 3);
            let [in1_zero, out_zero, act_min, act_max, in2_zero] =
                [self.i8(), self.i8(), self.i8(), self.i8(), self.i8()];
            assert_eq!(self.take::<2>(), [0; 2]);
            let [in1_scale, in2_scale, out_scale] = [self.f32(), self.f32(), self.f32()];
            let multipliers = self.i32s(3).try_into().unwrap();
            let shifts = self.i8s(3).try_into().unwrap();
            Add {
                in1_scale,
                in2_scale,
                out_scale,
                in1_zero,
                in2_zero,
                out_zero,
                act_min,
                act_max,
                multipliers,
                shifts,
            }
        }
    }

    /// Bit by bit, as IEEE 802.3 defines it.
    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0u32, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |c, _| (c >> 1) ^ (0xEDB8_8320 & (0u32.wrapping_sub(c & 1))))
        })
    }

    #[test]
    fn an_independent_reading_returns_the_network() {
        let network = network();
        let bytes = network.to_bytes().unwrap();
        let mut r = Reader(&bytes, 0);
        assert_eq!(&r.take::<4>(), b"SDP3");
        assert_eq!((r.u16(), r.u16(), r.u32()), (1, 64, bytes.len() as u32));
        let sensing_slots = r.u16();
        let [first_kept, last_kept] = r.take();
        let (window_len, hop) = (r.u16(), r.u16());
        assert_eq!(r.u16(), 64);
        let [bins_per_row, stem_stride] = r.take();
        let range = r.u16();
        assert_eq!(r.u16(), 10, "frames of 200 slots");
        let kaiser_beta = r.f32();
        assert_eq!(r.take::<4>(), [4, 2, 3, 0]);
        let (carrier_khz, slow_time_us) = (r.u32(), r.u32());
        assert_eq!(r.take::<20>(), [0; 20]);
        let preprocessing = Preprocessing {
            radar: RadarConfig::PAPER,
            sensing_slots,
            first_kept,
            last_kept,
            window_len,
            hop,
            bins_per_row,
            range,
            kaiser_beta,
            carrier_khz,
            slow_time_us,
        };
        let names = (0..3).map(|_| String::from_utf8(r.take::<24>().to_vec()).unwrap());
        let classes = names.map(|n| n.trim_end_matches('\0').to_string()).collect();
        let stem = r.weighted(1, 4, 9);
        let blocks = (0..2)
            .map(|_| Block {
                affine: r.weighted(2, 4, 1),
                conv1: r.weighted(1, 4, 36),
                conv2: r.weighted(1, 4, 36),
                add: r.add(),
            })
            .collect();
        let head = r.weighted(4, 3, 4);
        assert_eq!(r.u32(), crc32(&bytes[..bytes.len() - 4]));
        assert_eq!(r.1, bytes.len());
        assert_eq!(QuantizedNetwork { preprocessing, classes, stem_stride, stem, blocks, head }, network);
    }

    #[test]
    fn the_checksum_is_the_published_one() {
        // "Check" value of CRC-32/ISO-HDLC in the catalogue of parametrised CRC algorithms.
        assert_eq!(crc32fast::hash(b"123456789"), 0xCBF4_3926);
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn the_description_speaks_of_every_layer() {
        let text = network().describe();
        for part in ["200 sensing slots", "3.5 GHz", "64 x 10", "40.0 dB", "block 1 conv2", "head"] {
            assert!(text.contains(part), "{part} missing in {text}");
        }
    }

    #[test]
    fn a_model_belongs_to_a_radar_and_a_number_of_slots() {
        let paper = Scenario::default();
        let bytes = network().to_bytes().unwrap();
        assert_eq!(bytes[RADAR_AT..RADAR_AT + 16], [0; 16], "the paper's radar leaves no trace");
        check_use(&bytes, &paper, 200).unwrap();
        let refused = |bytes: &[u8], scenario: &Scenario, slots| {
            check_use(bytes, scenario, slots).unwrap_err().to_string()
        };
        assert!(refused(&bytes, &paper, 300).contains("sensing_slots is 200, must be 300"));
        let bgt60 = crate::scenario::builtin::named("bgt60".as_ref()).unwrap().scenario();
        let error = refused(&bytes, &bgt60, 200);
        assert!(
            error.contains("1000 complex samples") && error.contains("must be 128 real samples of 12 bits"),
            "{error}"
        );
        let mut other = network();
        other.preprocessing.radar = bgt60.radar.config();
        let bytes = other.to_bytes().unwrap();
        check_use(&bytes, &bgt60, 200).unwrap();
        assert_eq!(QuantizedNetwork::from_bytes(&bytes).unwrap(), other);
        assert!(other.describe().contains("8 x 4 range bins from bin 6 on"), "{}", other.describe());
        other.preprocessing.radar.samples = 63;
        assert!(other.to_bytes().unwrap_err().to_string().contains("radar is RadarConfig"));
    }
}
