//! The model file: weights, quantisation and preprocessing of one network, checked once and read in place.
//!
//! [`super::format`] says where everything lies.

mod error;
mod reader;
#[cfg(feature = "signature")]
mod signature;

use super::add::Add;
use super::batch_norm::BatchNormRelu;
use super::conv::{Conv, MAX_CHANNELS};
pub use super::format::{
    HEADER_LEN, KEY_LEN, MAGIC, MAX_BLOCKS, NAME_LEN, REVISION_AT, SIGNATURE_AT, SIGNATURE_LEN, VERSION,
};
use super::head::{Head, MAX_CLASSES};
use super::shape::Shape;
use crate::dims::ROWS;
use crate::signal::clutter::SvdRange;
use crate::signal::front_end::Preprocessing;
pub use error::ModelError;
use heapless::Vec;
use reader::{Reader, check};

/// One residual block.
#[derive(Debug, Clone, Copy)]
pub struct Block<'m> {
    pub(in crate::dsn) affine: BatchNormRelu<'m>,
    pub(in crate::dsn) conv: [Conv<'m>; 2],
    pub(in crate::dsn) add: Add,
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
    revision: u32,
    signed: bool,
    names: &'m [u8],
    pub(in crate::dsn) stem: Conv<'m>,
    pub(in crate::dsn) blocks: Vec<Block<'m>, MAX_BLOCKS>,
    pub(in crate::dsn) head: Head<'m>,
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

/// A byte string whose envelope is whole: magic, version, length, checksum.
struct Envelope<'m> {
    /// Header, names and layers: what a signature signs.
    content: &'m [u8],
    /// The signature, if the header says there is one.
    signature: Option<&'m [u8; SIGNATURE_LEN]>,
}

impl<'m> Envelope<'m> {
    fn open(bytes: &'m [u8]) -> Result<Self, ModelError> {
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
        match bytes.get(SIGNATURE_AT) {
            Some(0) => Ok(Envelope { content, signature: None }),
            Some(1) => match content.split_last_chunk::<SIGNATURE_LEN>() {
                Some((content, signature)) if content.len() >= HEADER_LEN => {
                    Ok(Envelope { content, signature: Some(signature) })
                }
                _ => Err(ModelError::Truncated { need: HEADER_LEN + SIGNATURE_LEN + 4, have }),
            },
            other => {
                Err(ModelError::Field { name: "signature", value: i64::from(other.copied().unwrap_or(0)) })
            }
        }
    }
}

impl<'m> Model<'m> {
    /// Checks a byte string and returns views into it; nothing is copied but the header's numbers.
    ///
    /// A signature is not looked at: see `Model::parse_signed`, feature `signature`.
    ///
    /// # Errors
    ///
    /// Every defect has its [`ModelError`]; a truncated or altered file never passes its length and checksum.
    pub fn parse(bytes: &'m [u8]) -> Result<Self, ModelError> {
        Self::content(&Envelope::open(bytes)?)
    }

    fn content(envelope: &Envelope<'m>) -> Result<Self, ModelError> {
        let content = envelope.content;
        let mut r = Reader { bytes: content, total: content.len() };
        r.take(12)?;
        let sensing_slots = r.u16()?;
        let kept = SvdRange { first: r.u8()?, last: r.u8()? };
        let (window, hop, rows) = (r.u16()?, r.u16()?, r.u16()?);
        let (bins_per_row, stem_stride) = (r.u8()?, r.u8()?);
        let (range, frames) = (r.u16()?, r.u16()?);
        let beta = f32::from_le_bytes(r.array()?);
        let (channels, blocks, classes, _signature) = (r.u8()?, r.u8()?, r.u8()?, r.u8()?);
        let (carrier_khz, interval_us, revision) = (r.u32()?, r.u32()?, r.u32()?);
        let radar = crate::config::RadarConfig::from_bytes(r.array()?).is_some();
        let zeros = r.take(8)?;
        check("radar", 0, radar)?;

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
        check("reserved", 0, zeros.iter().all(|&z| z == 0))?;
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
                affine: BatchNormRelu { layer: affine },
                conv: [first, second].map(|layer| Conv { layer, inputs: c, stride: 1 }),
                add: r.add()?,
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
            revision,
            signed: envelope.signature.is_some(),
            names,
            stem,
            blocks: parsed,
            head,
        })
    }

    /// What its memory is sized by.
    pub fn shape(&self) -> Shape {
        Shape {
            sensing_slots: self.sensing_slots(),
            frames: self.frames(),
            channels: self.channels(),
            stem_stride: self.stem_stride(),
        }
    }

    /// Its revision, which only grows; 0 if nobody counted.
    pub fn revision(&self) -> u32 {
        self.revision
    }

    /// Whether it carries a signature (which only `Model::parse_signed` looks at).
    pub fn is_signed(&self) -> bool {
        self.signed
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
