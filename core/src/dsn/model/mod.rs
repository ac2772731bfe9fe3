//! The model file: weights, quantisation and preprocessing of one network, checked once and read in place.
//!
//! [`super::format`] says where everything lies.

pub(crate) mod error;
mod layers;
#[cfg(feature = "signature")]
mod signature;

use super::conv::MAX_CHANNELS;
pub use super::format::{
    ARENA_AT, HEADER_LEN, KEY_LEN, MAGIC, MAX_BLOCKS, NAME_LEN, REVISION_AT, SIGNATURE_AT, SIGNATURE_LEN,
    VERSION,
};
use super::head::MAX_CLASSES;
use super::shape::Shape;
use crate::config::RadarConfig;
pub use crate::crc32::crc32;
use crate::dims::ROWS;
#[cfg(feature = "graph")]
use crate::graph::Graph;
use crate::signal::clutter::{GRAM_SLOTS, SvdRange};
use crate::signal::front_end::Preprocessing;
pub use error::ModelError;
use error::check;
pub use layers::Block;

/// A checked model: the byte string it was parsed from and the numbers of its header. Layers are views, made on demand.
#[derive(Debug, Clone, Copy)]
pub struct Model<'m> {
    content: &'m [u8],
    sensing_slots: u16,
    frames: u16,
    preprocessing: Preprocessing,
    radar: RadarConfig,
    channels: u8,
    blocks: u8,
    classes: u8,
    stem_stride: u8,
    carrier_khz: u32,
    interval_us: u32,
    revision: u32,
    signed: bool,
    arena: u32,
    #[cfg(feature = "graph")]
    graph: Option<Graph<'m>>,
}

/// A byte string with a valid envelope: magic, version, length, checksum.
struct Envelope<'m> {
    /// Header, names and layers: what a signature signs.
    content: &'m [u8],
    /// The signature, if the header says there is one.
    signature: Option<&'m [u8; SIGNATURE_LEN]>,
}

impl<'m> Envelope<'m> {
    fn open(bytes: &'m [u8]) -> Result<Self, ModelError> {
        let have = bytes.len();
        let truncated = |need| ModelError::Truncated { need, have };
        let (content, checksum) = bytes.split_last_chunk().ok_or(truncated(HEADER_LEN + 4))?;
        let header = content.first_chunk::<HEADER_LEN>().ok_or(truncated(HEADER_LEN + 4))?;
        let [m0, m1, m2, m3, v0, v1, h0, h1, l0, l1, l2, l3, ..] = *header;
        if [m0, m1, m2, m3] != MAGIC {
            return Err(ModelError::Magic);
        }
        let found = u16::from_le_bytes([v0, v1]);
        if found != VERSION {
            return Err(ModelError::Version { found });
        }
        let header_len = u16::from_le_bytes([h0, h1]);
        check("header_len", i64::from(header_len), usize::from(header_len) == HEADER_LEN)?;
        let stated = u32::from_le_bytes([l0, l1, l2, l3]) as usize;
        if stated != have {
            return Err(ModelError::Length { stated, have });
        }
        let (stated, computed) = (u32::from_le_bytes(*checksum), crc32(content));
        if stated != computed {
            return Err(ModelError::Checksum { stated, computed });
        }
        match header[SIGNATURE_AT] {
            0 => Ok(Envelope { content, signature: None }),
            1 => match content.split_last_chunk() {
                Some((content, signature)) if content.len() >= HEADER_LEN => {
                    Ok(Envelope { content, signature: Some(signature) })
                }
                _ => Err(truncated(HEADER_LEN + SIGNATURE_LEN + 4)),
            },
            other => Err(ModelError::Field { name: "signature", value: i64::from(other) }),
        }
    }
}

impl<'m> Model<'m> {
    /// Checks a byte string; nothing is copied but the header's numbers. Everything that can be wrong with a model is found here.
    ///
    /// A signature is not looked at: see `Model::parse_signed`, feature `signature`. Cost: some ten instructions a byte.
    ///
    /// # Errors
    ///
    /// Every defect has its [`ModelError`]; a truncated or altered file never passes its length and checksum.
    pub fn parse(bytes: &'m [u8]) -> Result<Self, ModelError> {
        Self::content(&Envelope::open(bytes)?)
    }

    fn content(envelope: &Envelope<'m>) -> Result<Self, ModelError> {
        let content = envelope.content;
        let Some(header) = content.first_chunk::<HEADER_LEN>() else {
            return Err(ModelError::Truncated { need: HEADER_LEN + 4, have: content.len() });
        };
        let byte = |at: usize| header[at];
        let two = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
        let four = |at: usize| [header[at], header[at + 1], header[at + 2], header[at + 3]];
        let preprocessing = Preprocessing {
            kept: SvdRange { first: byte(14), last: byte(15) },
            window: two(16),
            beta: f32::from_le_bytes(four(28)),
            hop: two(18),
            bins_per_row: byte(22),
            range: two(24),
        };
        let radar = [48, 49, 50, 51, 52, 53, 54, 55].map(byte);
        let radar = RadarConfig::from_bytes(radar)
            .ok_or(ModelError::Field { name: "radar", value: i64::from_le_bytes(radar) })?;
        #[cfg_attr(not(feature = "graph"), allow(unused_mut))]
        let mut model = Model {
            content,
            sensing_slots: two(12),
            frames: two(26),
            preprocessing,
            radar,
            channels: byte(32),
            blocks: byte(33),
            classes: byte(34),
            stem_stride: byte(23),
            carrier_khz: u32::from_le_bytes(four(36)),
            interval_us: u32::from_le_bytes(four(40)),
            revision: u32::from_le_bytes(four(REVISION_AT)),
            signed: envelope.signature.is_some(),
            arena: u32::from_le_bytes(four(ARENA_AT)),
            #[cfg(feature = "graph")]
            graph: None,
        };
        model.check_header(two(20))?;
        check("reserved", 0, header[ARENA_AT + 4..].iter().all(|&zero| zero == 0))?;
        if model.channels == 0 {
            #[cfg(feature = "graph")]
            {
                model.graph = Some(model.check_graph()?);
            }
        } else {
            let (need, have) = (model.content_len(), content.len());
            if need != have {
                return Err(ModelError::Layers { need, have });
            }
            model.check_layers()?;
        }
        for class in 0..model.classes() {
            let name = model.class_name(class);
            check("class_name", 0, !name.is_empty() && !name.contains('\0'))?;
        }
        Ok(model)
    }

    fn check_header(&self, rows: u16) -> Result<(), ModelError> {
        if let Some((name, value)) = self.preprocessing.illegal(&self.radar) {
            return Err(ModelError::Field { name, value });
        }
        check("rows", i64::from(rows), usize::from(rows) == ROWS)?;
        check("classes", i64::from(self.classes), (2..=MAX_CLASSES).contains(&self.classes()))?;
        check("sensing_slots", i64::from(self.sensing_slots), self.sensing_slots() <= GRAM_SLOTS)?;
        let expected = self.preprocessing.frames(self.sensing_slots());
        check("frames", i64::from(self.frames), self.frames() == expected)?;
        let channels = self.channels();
        if cfg!(feature = "graph") && channels == 0 {
            return check("channels", 0, self.stem_stride == 0 && self.blocks == 0);
        }
        check("stem_stride", i64::from(self.stem_stride), matches!(self.stem_stride, 1 | 2))?;
        check("arena", i64::from(self.arena), self.arena == 0)?;
        let legal = (4..=MAX_CHANNELS).contains(&channels) && channels.is_multiple_of(4);
        check("channels", i64::from(self.channels), legal)?;
        check("blocks", i64::from(self.blocks), (1..=MAX_BLOCKS).contains(&self.blocks()))?;
        // the stem and its pooling must leave at least one column
        let columns = self.frames().div_ceil(self.stem_stride()) / 2;
        check("sensing_slots", i64::from(self.sensing_slots), columns > 0)
    }

    /// What its memory is sized by.
    pub fn shape(&self) -> Shape {
        Shape {
            sensing_slots: self.sensing_slots(),
            frames: self.frames(),
            channels: self.channels(),
            stem_stride: self.stem_stride(),
            arena: self.arena as usize,
            radar: self.radar,
        }
    }

    /// Its operators, if it holds a graph instead of the paper's network.
    #[cfg(feature = "graph")]
    pub fn graph(&self) -> Option<&Graph<'m>> {
        self.graph.as_ref()
    }

    /// The sensor it was trained for.
    pub fn radar(&self) -> RadarConfig {
        self.radar
    }

    /// Header, names and layers: what its checksum is over.
    pub(crate) fn bytes(&self) -> &'m [u8] {
        self.content
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

    /// Channels of every convolution; 0 of a graph.
    pub fn channels(&self) -> usize {
        usize::from(self.channels)
    }

    /// Residual blocks; 0 of a graph.
    pub fn blocks(&self) -> usize {
        usize::from(self.blocks)
    }

    /// Operators with an output that a probe sees: of a graph its own, else stem, four a block and average.
    pub(crate) fn operators(&self) -> usize {
        #[cfg(feature = "graph")]
        if let Some(graph) = self.graph() {
            return graph.nodes().count();
        }
        4 * self.blocks() + 2
    }

    /// Number of classes.
    pub fn classes(&self) -> usize {
        usize::from(self.classes)
    }

    /// Stride of the input convolution; 0 of a graph.
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

    /// Name of a class, empty if there is no such class.
    pub fn class_name(&self, class: usize) -> &'m str {
        let names = self.content.get(HEADER_LEN..).unwrap_or(&[]).chunks_exact(NAME_LEN);
        let name = names.take(self.classes()).nth(class).unwrap_or(&[]);
        core::str::from_utf8(name).unwrap_or("").trim_end_matches('\0')
    }
}
