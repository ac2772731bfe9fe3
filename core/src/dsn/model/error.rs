//! Why a byte string is not a model: every defect has its name.

use crate::dsn::format::VERSION;

/// Why a byte string is not a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ModelError {
    /// It ends before its content does: bytes needed, bytes there.
    #[error("truncated: it needs at least {need} bytes and has {have}")]
    Truncated {
        /// Bytes the content needs.
        need: usize,
        /// Bytes there are.
        have: usize,
    },
    /// It does not begin with `SDP3`.
    #[error("not a model: it does not begin with \"SDP3\"")]
    Magic,
    /// The layout's version is not the one this crate reads.
    #[error("version {found}; this program reads version {VERSION}")]
    Version {
        /// The version found.
        found: u16,
    },
    /// The length in the header is not the length of the byte string.
    #[error("truncated or extended: its header says {stated} bytes, it has {have}")]
    Length {
        /// The length in the header.
        stated: usize,
        /// The length of the byte string.
        have: usize,
    },
    /// The checksum does not match: the file is damaged.
    #[error("damaged: its checksum is {stated:08x}, its content's {computed:08x}")]
    Checksum {
        /// The checksum in the file.
        stated: u32,
        /// The checksum of the content.
        computed: u32,
    },
    /// A field has a value outside its legal range.
    #[error("field {name} has the illegal value {value}")]
    Field {
        /// Name of the field.
        name: &'static str,
        /// Its value.
        value: i64,
    },
    /// A signature is required and the model has none.
    #[error("not signed; a signature is required")]
    Unsigned,
    /// The signature is not the key's for this content.
    #[error("its signature does not belong to this key and content")]
    Signature,
    /// The model is signed, but older than what this firmware may run.
    #[error("revision {revision} is a rollback: the oldest that is taken is {oldest}")]
    Older {
        /// Revision of the model.
        revision: u32,
        /// Oldest revision that is taken.
        oldest: u32,
    },
    /// The content is longer or shorter than the layers need.
    #[error("its layers need {need} bytes, it has {have}")]
    Layers {
        /// Bytes the layers need.
        need: usize,
        /// Bytes there are.
        have: usize,
    },
}

/// Refuses a field unless it is legal.
pub(crate) fn check(name: &'static str, value: i64, legal: bool) -> Result<(), ModelError> {
    if legal { Ok(()) } else { Err(ModelError::Field { name, value }) }
}

/// Refuses a multiplier that is neither 0 nor Q0.31 in 2^30..2^31.
pub(crate) fn check_multiplier(name: &'static str, value: i32) -> Result<(), ModelError> {
    check(name, i64::from(value), value == 0 || value >= 1 << 30)
}

/// Refuses a shift outside -31 to 7.
pub(crate) fn check_shift(name: &'static str, value: i8) -> Result<(), ModelError> {
    check(name, i64::from(value), (-31..=7).contains(&value))
}
