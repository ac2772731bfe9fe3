//! The model file: weights, quantisation and preprocessing of one network, checked once and read in place.
//!
//! Layout (little-endian): 64-byte header, class names of 24 bytes, layers in the order stem, per block (affine,
//! conv, conv, add), head, and the CRC-32 (IEEE 802.3) of everything before it. See `docs` of [`Model::parse`].

use super::add::Add;
use super::affine::Affine;
use super::conv::{Conv, MAX_CHANNELS};
use super::head::{Head, MAX_CLASSES};
use crate::clutter::Kept;
use crate::fixed::requantize;
use crate::frame::ROWS;
use crate::front_end::Preprocessing;
use heapless::Vec;

/// First bytes of a model file.
pub const MAGIC: [u8; 4] = *b"SDP3";
/// Version of the layout.
pub const VERSION: u16 = 1;
/// Bytes of the header.
pub const HEADER_LEN: usize = 64;
/// Bytes of a class name, zero-padded UTF-8.
pub const NAME_LEN: usize = 24;
/// Most residual blocks.
pub const MAX_BLOCKS: usize = 8;

/// Why a byte string is not a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ModelError {
    /// It ends before its content does: bytes needed, bytes there.
    Truncated {
        /// Bytes the content needs.
        need: usize,
        /// Bytes there are.
        have: usize,
    },
    /// It does not begin with `SDP3`.
    Magic,
    /// The layout's version is not the one this crate reads.
    Version {
        /// The version found.
        found: u16,
    },
    /// The length in the header is not the length of the byte string.
    Length {
        /// The length in the header.
        stated: usize,
        /// The length of the byte string.
        have: usize,
    },
    /// The checksum does not match: the file is damaged.
    Checksum {
        /// The checksum in the file.
        stated: u32,
        /// The checksum of the content.
        computed: u32,
    },
    /// A field has a value outside its legal range.
    Field {
        /// Name of the field.
        name: &'static str,
        /// Its value.
        value: i64,
    },
    /// The content is longer or shorter than the layers need.
    Layers {
        /// Bytes the layers need.
        need: usize,
        /// Bytes there are.
        have: usize,
    },
}

impl core::fmt::Display for ModelError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match *self {
            ModelError::Truncated { need, have } => {
                write!(f, "truncated: it needs at least {need} bytes and has {have}")
            }
            ModelError::Magic => write!(f, "not a model: it does not begin with \"SDP3\""),
            ModelError::Version { found } => {
                write!(f, "version {found}; this program reads version {VERSION}")
            }
            ModelError::Length { stated, have } => {
                write!(f, "truncated or extended: its header says {stated} bytes, it has {have}")
            }
            ModelError::Checksum { stated, computed } => {
                write!(f, "damaged: its checksum is {stated:08x}, its content's {computed:08x}")
            }
            ModelError::Field { name, value } => write!(f, "field {name} has the illegal value {value}"),
            ModelError::Layers { need, have } => {
                write!(f, "its layers need {need} bytes, it has {have}")
            }
        }
    }
}

impl core::error::Error for ModelError {}

/// Weights, biases and multipliers of a layer with one set per output channel, read in place.
#[derive(Debug, Clone, Copy)]
pub struct Channelwise<'m> {
    pub(super) in_zp: i8,
    pub(super) out_zp: i8,
    pub(super) act_min: i8,
    pub(super) act_max: i8,
    pub(super) channels: usize,
    multipliers: &'m [u8],
    biases: &'m [u8],
    shifts: &'m [u8],
    pub(super) weights: &'m [u8],
}

impl Channelwise<'_> {
    /// Bias of output channel `o`.
    pub(super) fn bias(&self, o: usize) -> i32 {
        read_i32(self.biases, o)
    }

    /// Multiplier and shift of output channel `o`.
    pub(super) fn scale(&self, o: usize) -> (i32, i8) {
        (read_i32(self.multipliers, o), self.shifts.get(o).map_or(0, |&s| s as i8))
    }

    /// Requantises an accumulator of output channel `o`.
    pub(super) fn requantize(&self, o: usize, accumulator: i32) -> i32 {
        let (multiplier, shift) = self.scale(o);
        requantize(accumulator, multiplier, shift)
    }
}

/// The `index`-th little-endian i32; 0 beyond the end (the parser has checked that there is none).
fn read_i32(bytes: &[u8], index: usize) -> i32 {
    match bytes.get(index * 4..).and_then(|rest| rest.first_chunk::<4>()) {
        Some(word) => i32::from_le_bytes(*word),
        None => 0,
    }
}

/// One residual block.
#[derive(Debug, Clone, Copy)]
pub struct Block<'m> {
    pub(super) affine: Affine<'m>,
    pub(super) conv: [Conv<'m>; 2],
    pub(super) add: Add,
}

/// A checked model: views into the byte string it was parsed from.
#[derive(Debug, Clone)]
pub struct Model<'m> {
    sensing_slots: u16,
    frames: u16,
    preprocessing: Preprocessing,
    channels: u8,
    classes: u8,
    stem_stride: u8,
    carrier_khz: u32,
    interval_us: u32,
    names: &'m [u8],
    pub(super) stem: Conv<'m>,
    pub(super) blocks: Vec<Block<'m>, MAX_BLOCKS>,
    pub(super) head: Head<'m>,
}

/// CRC-32 (IEEE 802.3): reflected, polynomial 0xEDB88320, initial value and final xor 0xFFFFFFFF.
pub fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
        }
    }
    !crc
}

/// Reads fields one after the other; running out is an error, never a panic.
struct Reader<'m> {
    bytes: &'m [u8],
    total: usize,
}

impl<'m> Reader<'m> {
    fn take(&mut self, length: usize) -> Result<&'m [u8], ModelError> {
        let at = self.total - self.bytes.len();
        let have = self.total;
        let (head, tail) =
            self.bytes.split_at_checked(length).ok_or(ModelError::Layers { need: at + length, have })?;
        self.bytes = tail;
        Ok(head)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], ModelError> {
        let have = self.total;
        self.take(N)?.first_chunk::<N>().copied().ok_or(ModelError::Layers { need: N, have })
    }

    fn u8(&mut self) -> Result<u8, ModelError> {
        Ok(u8::from_le_bytes(self.array()?))
    }

    fn i8(&mut self) -> Result<i8, ModelError> {
        Ok(i8::from_le_bytes(self.array()?))
    }

    fn u16(&mut self) -> Result<u16, ModelError> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    fn u32(&mut self) -> Result<u32, ModelError> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn i32(&mut self) -> Result<i32, ModelError> {
        Ok(i32::from_le_bytes(self.array()?))
    }

    fn scale(&mut self, name: &'static str) -> Result<f32, ModelError> {
        let scale = f32::from_le_bytes(self.array()?);
        if scale.is_finite() && scale > 0.0 {
            Ok(scale)
        } else {
            Err(ModelError::Field { name, value: i64::from(scale.to_bits()) })
        }
    }

    /// Zero points and activation range that begin every layer: `[in, out, min, max, in2]`.
    fn layer(&mut self, kind: u8) -> Result<[i8; 5], ModelError> {
        let found = self.u8()?;
        check("layer.kind", i64::from(found), found == kind)?;
        let values = [self.i8()?, self.i8()?, self.i8()?, self.i8()?, self.i8()?];
        let [_, _, low, high, _] = values;
        check("layer.act_min", i64::from(low), low <= high)?;
        let reserved = self.u16()?;
        check("layer.reserved", i64::from(reserved), reserved == 0)?;
        Ok(values)
    }

    /// The body of a layer with per-channel quantisation and `taps` weights per channel; also its output scale.
    fn channelwise(
        &mut self,
        kind: u8,
        channels: usize,
        taps: usize,
    ) -> Result<(Channelwise<'m>, f32), ModelError> {
        let [in_zp, out_zp, act_min, act_max, _] = self.layer(kind)?;
        self.scale("layer.in_scale")?;
        let scale = self.scale("layer.out_scale")?;
        let multipliers = self.take(4 * channels)?;
        let biases = self.take(4 * channels)?;
        let shifts = self.take(channels.next_multiple_of(4))?;
        let weights = self.take((channels * taps).next_multiple_of(4))?;
        let weights = weights.get(..channels * taps).unwrap_or(weights);
        for o in 0..channels {
            multiplier("layer.multiplier", read_i32(multipliers, o))?;
        }
        for &s in shifts {
            shift("layer.shift", s as i8)?;
        }
        let layer =
            Channelwise { in_zp, out_zp, act_min, act_max, channels, multipliers, biases, shifts, weights };
        Ok((layer, scale))
    }
}

fn check(name: &'static str, value: i64, legal: bool) -> Result<(), ModelError> {
    if legal { Ok(()) } else { Err(ModelError::Field { name, value }) }
}

fn multiplier(name: &'static str, value: i32) -> Result<(), ModelError> {
    check(name, i64::from(value), value == 0 || value >= 1 << 30)
}

fn shift(name: &'static str, value: i8) -> Result<(), ModelError> {
    check(name, i64::from(value), (-31..=7).contains(&value))
}

impl<'m> Model<'m> {
    /// Checks a byte string and returns views into it; nothing is copied but the header's numbers.
    ///
    /// # Errors
    ///
    /// Every defect has its [`ModelError`]; a truncated or altered file never passes its length and checksum.
    pub fn parse(bytes: &'m [u8]) -> Result<Self, ModelError> {
        let have = bytes.len();
        if have < HEADER_LEN + 4 {
            return Err(ModelError::Truncated { need: HEADER_LEN + 4, have });
        }
        let mut header = Reader { bytes, total: have };
        if header.array::<4>()? != MAGIC {
            return Err(ModelError::Magic);
        }
        let found = header.u16()?;
        if found != VERSION {
            return Err(ModelError::Version { found });
        }
        let header_len = header.u16()?;
        check("header_len", i64::from(header_len), usize::from(header_len) == HEADER_LEN)?;
        let stated = header.u32()? as usize;
        if stated != have {
            return Err(ModelError::Length { stated, have });
        }
        let Some((content, checksum)) = bytes.split_last_chunk::<4>() else {
            return Err(ModelError::Truncated { need: HEADER_LEN + 4, have });
        };
        let (stated, computed) = (u32::from_le_bytes(*checksum), crc32(content));
        if stated != computed {
            return Err(ModelError::Checksum { stated, computed });
        }
        Self::content(content)
    }

    fn content(content: &'m [u8]) -> Result<Self, ModelError> {
        let mut r = Reader { bytes: content, total: content.len() };
        r.take(12)?;
        let sensing_slots = r.u16()?;
        let kept = Kept { first: r.u8()?, last: r.u8()? };
        let (window, hop, rows) = (r.u16()?, r.u16()?, r.u16()?);
        let (bins_per_row, stem_stride) = (r.u8()?, r.u8()?);
        let (range, frames) = (r.u16()?, r.u16()?);
        let beta = f32::from_le_bytes(r.array()?);
        let (channels, blocks, classes, reserved) = (r.u8()?, r.u8()?, r.u8()?, r.u8()?);
        let (carrier_khz, interval_us) = (r.u32()?, r.u32()?);
        let zeros = r.take(20)?;

        check("first_kept", i64::from(kept.first), (1..=8).contains(&kept.first))?;
        check("last_kept", i64::from(kept.last), (kept.first..=8).contains(&kept.last))?;
        check("window_len", i64::from(window), (2..=256).contains(&window))?;
        check("hop", i64::from(hop), (1..=window).contains(&hop))?;
        check("rows", i64::from(rows), usize::from(rows) == ROWS)?;
        check("bins_per_row", i64::from(bins_per_row), matches!(bins_per_row, 1 | 2 | 4))?;
        check("stem_stride", i64::from(stem_stride), matches!(stem_stride, 1 | 2))?;
        check("range", i64::from(range), (1..=4095).contains(&range))?;
        check("kaiser_beta", i64::from(beta.to_bits()), (0.0..=40.0).contains(&beta))?;
        let legal = usize::from(channels) <= MAX_CHANNELS && channels >= 4 && channels % 4 == 0;
        check("channels", i64::from(channels), legal)?;
        check("blocks", i64::from(blocks), (1..=MAX_BLOCKS).contains(&usize::from(blocks)))?;
        check("classes", i64::from(classes), (2..=MAX_CLASSES).contains(&usize::from(classes)))?;
        check("reserved", i64::from(reserved), reserved == 0 && zeros.iter().all(|&z| z == 0))?;
        let preprocessing = Preprocessing { kept, window, beta, hop, bins_per_row, range };
        let expected = preprocessing.frames(usize::from(sensing_slots));
        check("frames", i64::from(frames), usize::from(frames) == expected)?;
        // the stem and its pooling must leave at least one column
        let columns = usize::from(frames).div_ceil(usize::from(stem_stride)) / 2;
        check("sensing_slots", i64::from(sensing_slots), columns > 0)?;

        let names = r.take(usize::from(classes) * NAME_LEN)?;
        for name in names.chunks_exact(NAME_LEN) {
            let text = core::str::from_utf8(name).map(|s| s.trim_end_matches('\0')).unwrap_or("");
            check("class_name", 0, !text.is_empty() && !text.contains('\0'))?;
        }

        let c = usize::from(channels);
        let (stem, _) = r.channelwise(1, c, 9)?;
        let stem = Conv { layer: stem, inputs: 1, stride: usize::from(stem_stride) };
        let mut parsed = Vec::new();
        for _ in 0..blocks {
            let (affine, _) = r.channelwise(2, c, 1)?;
            let (first, _) = r.channelwise(1, c, 9 * c)?;
            let (second, _) = r.channelwise(1, c, 9 * c)?;
            let block = Block {
                affine: Affine { layer: affine },
                conv: [first, second].map(|layer| Conv { layer, inputs: c, stride: 1 }),
                add: Self::add(&mut r)?,
            };
            if parsed.push(block).is_err() {
                return Err(ModelError::Field { name: "blocks", value: i64::from(blocks) });
            }
        }
        let (layer, scale) = r.channelwise(4, usize::from(classes), c)?;
        let head = Head { layer, inputs: c, scale };
        if !r.bytes.is_empty() {
            return Err(ModelError::Layers { need: content.len() - r.bytes.len(), have: content.len() });
        }
        Ok(Model {
            sensing_slots,
            frames,
            preprocessing,
            channels,
            classes,
            stem_stride,
            carrier_khz,
            interval_us,
            names,
            stem,
            blocks: parsed,
            head,
        })
    }

    fn add(r: &mut Reader<'m>) -> Result<Add, ModelError> {
        let [in_zp, out_zp, act_min, act_max, in2_zp] = r.layer(3)?;
        r.scale("add.in1_scale")?;
        r.scale("add.in2_scale")?;
        r.scale("add.out_scale")?;
        let add = Add {
            zero: [in_zp, in2_zp],
            out_zp,
            act_min,
            act_max,
            multiplier: [r.i32()?, r.i32()?],
            out_multiplier: r.i32()?,
            shift: [r.i8()?, r.i8()?],
            out_shift: r.i8()?,
        };
        let reserved = r.u8()?;
        check("add.reserved", i64::from(reserved), reserved == 0)?;
        for value in add.multiplier.into_iter().chain([add.out_multiplier]) {
            multiplier("add.multiplier", value)?;
        }
        for value in add.shift.into_iter().chain([add.out_shift]) {
            shift("add.shift", value)?;
        }
        Ok(add)
    }

    /// Sensing slots of a recording, N_s.
    pub fn sensing_slots(&self) -> usize {
        usize::from(self.sensing_slots)
    }

    /// Frames of its image.
    pub fn frames(&self) -> usize {
        usize::from(self.frames)
    }

    /// How its images are made.
    pub fn preprocessing(&self) -> Preprocessing {
        self.preprocessing
    }

    /// Channels of every convolution.
    pub fn channels(&self) -> usize {
        usize::from(self.channels)
    }

    /// Residual blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Classes it tells apart.
    pub fn classes(&self) -> usize {
        usize::from(self.classes)
    }

    /// Stride of the input convolution.
    pub fn stem_stride(&self) -> usize {
        usize::from(self.stem_stride)
    }

    /// Carrier frequency it was trained at, in kHz.
    pub fn carrier_khz(&self) -> u32 {
        self.carrier_khz
    }

    /// Interval of the sensing slots it was trained at, in microseconds.
    pub fn interval_us(&self) -> u32 {
        self.interval_us
    }

    /// What one step of a logit is worth, in nat.
    pub fn logit_scale(&self) -> f32 {
        self.head.scale
    }

    /// Name of a class, empty if there is no such class.
    pub fn class_name(&self, class: usize) -> &'m str {
        let name = self.names.chunks_exact(NAME_LEN).nth(class).unwrap_or(&[]);
        core::str::from_utf8(name).map(|s| s.trim_end_matches('\0')).unwrap_or("")
    }
}
