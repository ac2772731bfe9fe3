//! Why a byte string is not a model: every defect has its name.

use crate::dsn::format::VERSION;

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
    /// A signature is required and the model has none.
    Unsigned,
    /// The signature is not the key's for this content.
    Signature,
    /// The model is signed, but older than what this firmware may run.
    Older {
        /// Revision of the model.
        revision: u32,
        /// Oldest revision that is taken.
        oldest: u32,
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
            ModelError::Unsigned => write!(f, "not signed; a signature is required"),
            ModelError::Signature => write!(f, "its signature does not belong to this key and content"),
            ModelError::Older { revision, oldest } => {
                write!(f, "revision {revision} is a rollback: the oldest that is taken is {oldest}")
            }
            ModelError::Layers { need, have } => {
                write!(f, "its layers need {need} bytes, it has {have}")
            }
        }
    }
}

impl core::error::Error for ModelError {}
