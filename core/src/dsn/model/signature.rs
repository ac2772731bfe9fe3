//! Models that must come from the holder of a key: ed25519 (RFC 8032) over header, names and layers.

use super::{Envelope, KEY_LEN, Model, ModelError};
use ed25519_dalek::{Signature, VerifyingKey};

impl<'m> Model<'m> {
    /// [`Model::parse`] for firmware that takes signed models only: the signature is checked before any field of the
    /// content is looked at. A model of a revision before `oldest` is refused, however well it is signed; firmware keeps the
    /// largest revision it ever ran where no update can lower it, and passes it here.
    ///
    /// Signature, key and content are public: there is no secret that the time taken could reveal.
    ///
    /// # Errors
    ///
    /// [`ModelError::Unsigned`], [`ModelError::Signature`], [`ModelError::Older`], else as [`Model::parse`].
    pub fn parse_signed(bytes: &'m [u8], key: &[u8; KEY_LEN], oldest: u32) -> Result<Self, ModelError> {
        let envelope = Envelope::open(bytes)?;
        let signature = envelope.signature.ok_or(ModelError::Unsigned)?;
        VerifyingKey::from_bytes(key)
            .and_then(|key| key.verify_strict(envelope.content, &Signature::from_bytes(signature)))
            .map_err(|_| ModelError::Signature)?;
        let model = Self::content(&envelope)?;
        if model.revision < oldest {
            return Err(ModelError::Older { revision: model.revision, oldest });
        }
        Ok(model)
    }
}
