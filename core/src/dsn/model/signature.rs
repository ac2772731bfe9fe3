//! Models that must come from the holder of a key: ed25519 (RFC 8032) over header, names and layers.

use super::{Envelope, KEY_LEN, Model, ModelError};
use ed25519_dalek::{Signature, VerifyingKey};

impl<'m> Model<'m> {
    /// [`Model::parse`] for firmware that takes signed models only: the signature is checked before any field of the
    /// content is looked at.
    ///
    /// # Errors
    ///
    /// [`ModelError::Unsigned`], [`ModelError::Signature`], else as [`Model::parse`].
    pub fn parse_signed(bytes: &'m [u8], key: &[u8; KEY_LEN]) -> Result<Self, ModelError> {
        let envelope = Envelope::open(bytes)?;
        let signature = envelope.signature.ok_or(ModelError::Unsigned)?;
        VerifyingKey::from_bytes(key)
            .and_then(|key| key.verify_strict(envelope.content, &Signature::from_bytes(signature)))
            .map_err(|_| ModelError::Signature)?;
        Self::content(&envelope)
    }
}
