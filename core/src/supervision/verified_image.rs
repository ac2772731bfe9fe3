//! A model file that is looked at again before it is used again.
//!
//! Memory that held a good model when it was accepted may hold another later. What is compared is the checksum of all bytes with
//! the one taken then, not with the one in the file: a file that was replaced as a whole is found too. A flip of up to 32
//! neighbouring bits is always found (CRC-32), any other damage but once in 2^32 times.

use crate::dsn::model::crc32;
use crate::dsn::{Model, ModelError};

/// The bytes of an accepted model.
#[derive(Debug, Clone, Copy)]
pub struct Intact<'m> {
    bytes: &'m [u8],
    checksum: u32,
}

impl<'m> Intact<'m> {
    /// Accepts a file; the model is what [`Model::parse`] makes of it.
    ///
    /// # Errors
    ///
    /// As [`Model::parse`].
    pub fn accept(bytes: &'m [u8]) -> Result<(Self, Model<'m>), ModelError> {
        let model = Model::parse(bytes)?;
        Ok((Intact { bytes, checksum: crc32(bytes) }, model))
    }

    /// Looks at the bytes again. Cost: about 40 instructions a byte.
    ///
    /// # Errors
    ///
    /// [`ModelError::Checksum`].
    pub fn check(&self) -> Result<(), ModelError> {
        self.against(self.bytes)
    }

    /// The same for a copy of the file in other memory.
    ///
    /// # Errors
    ///
    /// [`ModelError::Checksum`].
    pub fn against(&self, bytes: &[u8]) -> Result<(), ModelError> {
        match crc32(bytes) {
            computed if computed == self.checksum && bytes.len() == self.bytes.len() => Ok(()),
            computed => Err(ModelError::Checksum { stated: self.checksum, computed }),
        }
    }
}
