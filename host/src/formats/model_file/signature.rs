//! Signs model files: ed25519 (RFC 8032) over header, names and layers, for firmware that takes signed models only.
//!
//! A key pair is two files of 32 bytes: `NAME.key`, the secret seed, and `NAME.pub`, which firmware is built with.

use super::ModelFileError;
use crate::error::Invalid;
use crate::store::limited;
use ed25519_dalek::{Signer, SigningKey};
use sdp3_core::dsn::model::{KEY_LEN, REVISION_AT, SIGNATURE_AT, SIGNATURE_LEN};
use sdp3_core::dsn::{Model, ModelError};
use std::path::{Path, PathBuf};

/// The model as this revision, with a signature by the key of this seed in place of any other.
///
/// # Errors
/// What the radar module's parser finds wrong.
pub fn sign(model: &[u8], seed: [u8; KEY_LEN], revision: u32) -> Result<Vec<u8>, ModelError> {
    let parsed = Model::parse(model)?;
    let trailer = 4 + if parsed.is_signed() { SIGNATURE_LEN } else { 0 };
    let mut file = model[..model.len() - trailer].to_vec();
    let total = (file.len() + SIGNATURE_LEN + 4) as u32;
    file[SIGNATURE_AT] = 1;
    file[REVISION_AT..REVISION_AT + 4].copy_from_slice(&revision.to_le_bytes());
    file[8..12].copy_from_slice(&total.to_le_bytes());
    let signature = SigningKey::from_bytes(&seed).sign(&file);
    file.extend_from_slice(&signature.to_bytes());
    let checksum = crc32fast::hash(&file);
    file.extend_from_slice(&checksum.to_le_bytes());
    Ok(file)
}

/// The public key of a seed.
pub fn public_key(seed: [u8; KEY_LEN]) -> [u8; KEY_LEN] {
    SigningKey::from_bytes(&seed).verifying_key().to_bytes()
}

/// Makes a key pair from the system's randomness and writes `NAME.key` and `NAME.pub`; keeps what is there. Returns both paths.
///
/// # Errors
/// A file that exists or cannot be written; then neither is made.
pub fn new_key(name: &Path) -> Result<[PathBuf; 2], ModelFileError> {
    let paths = [SECRET, PUBLIC].map(|extension| {
        let mut path = name.as_os_str().to_owned();
        path.push(".");
        path.push(extension);
        PathBuf::from(path)
    });
    let mut seed = [0; KEY_LEN];
    getrandom::fill(&mut seed).map_err(|error| ModelFileError::Io {
        path: "the system's randomness".to_owned(),
        source: std::io::Error::other(error.to_string()),
    })?;
    for (k, bytes) in [seed, public_key(seed)].iter().enumerate() {
        write_new(&paths[k], bytes, k == 0).map_err(|source| {
            paths[..k].iter().for_each(|made| drop(std::fs::remove_file(made)));
            ModelFileError::Io { path: paths[k].display().to_string(), source }
        })?;
    }
    Ok(paths)
}

const SECRET: &str = "key";
const PUBLIC: &str = "pub";

/// Writes a file that is not there yet, a secret one for its owner's eyes alone.
fn write_new(path: &Path, bytes: &[u8], secret: bool) -> std::io::Result<()> {
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(not(unix))]
    let _ = secret;
    #[cfg(unix)]
    if secret {
        use std::os::unix::fs::OpenOptionsExt;
        options.mode(0o600);
    }
    let mut file = options.open(path)?;
    std::io::Write::write_all(&mut file, bytes).inspect_err(|_| drop(std::fs::remove_file(path)))
}

/// Reads a secret key.
///
/// # Errors
/// A file that cannot be read, does not hold 32 bytes, or is named as a public key: both kinds are 32 bytes, and a signature by
/// a public key would be one that everybody can make.
pub fn read_secret_key(path: &Path) -> Result<[u8; KEY_LEN], ModelFileError> {
    refuse_kind(path, PUBLIC, "a secret key, NAME.key")?;
    read_key(path)
}

/// Reads a public key.
///
/// # Errors
/// A file that cannot be read, does not hold 32 bytes, or is named as a secret key.
pub fn read_public_key(path: &Path) -> Result<[u8; KEY_LEN], ModelFileError> {
    refuse_kind(path, SECRET, "a public key, NAME.pub")?;
    read_key(path)
}

fn refuse_kind(path: &Path, refused: &str, legal: &str) -> Result<(), ModelFileError> {
    if path.extension().is_none_or(|extension| extension != refused) {
        return Ok(());
    }
    Err(Invalid::option("--key", path.display(), legal).into())
}

fn read_key(path: &Path) -> Result<[u8; KEY_LEN], ModelFileError> {
    let name = path.display().to_string();
    let bytes = limited::read(path, limited::TEXT)
        .map_err(|source| ModelFileError::Io { path: name.clone(), source })?;
    let length = bytes.len();
    bytes.try_into().map_err(|_| {
        Invalid::new("length of the key", length, format!("{KEY_LEN} bytes")).at(path.display()).into()
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::network;
    use super::*;
    use sdp3_testkit::models::{DSN_200, DSN_200_SIGNED, PUBLIC_KEY};

    #[test]
    fn a_signed_model_is_taken_with_its_key_and_no_other() {
        let plain = network().to_bytes().unwrap();
        let signed = sign(&plain, [7; 32], 4).unwrap();
        let key = public_key([7; 32]);
        assert!(Model::parse_signed(&signed, &key, 4).unwrap().is_signed());
        let older = ModelError::Older { revision: 4, oldest: 5 };
        assert_eq!(Model::parse_signed(&signed, &key, 5).unwrap_err(), older);
        assert!(Model::parse(&signed).unwrap().is_signed());
        assert_eq!(Model::parse_signed(&plain, &key, 0).unwrap_err(), ModelError::Unsigned);
        let other = public_key([8; 32]);
        assert_eq!(Model::parse_signed(&signed, &other, 0).unwrap_err(), ModelError::Signature);
        assert_eq!(sign(&signed, [7; 32], 4).unwrap(), signed, "signing again replaces the signature");
        // a change that corrects the checksum is a change all the same
        for at in [40, REVISION_AT, 200, signed.len() - 10] {
            let mut forged = signed[..signed.len() - 4].to_vec();
            forged[at] ^= 1;
            let checksum = crc32fast::hash(&forged);
            forged.extend_from_slice(&checksum.to_le_bytes());
            let error = Model::parse_signed(&forged, &key, 0).unwrap_err();
            assert_eq!(error, ModelError::Signature, "byte {at}");
        }
    }

    #[test]
    fn keys_and_signatures_are_rfc_8032s() {
        // section 7.1, test 1: the public key of its secret key
        let hex = |text: &str| -> Vec<u8> {
            (0..text.len()).step_by(2).map(|k| u8::from_str_radix(&text[k..k + 2], 16).unwrap()).collect()
        };
        let secret = hex("9d61b19deffd5a60ba844af492ec2cc44449c5697b326919703bac031cae7f60");
        let public = hex("d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a");
        assert_eq!(public_key(secret.try_into().unwrap()).to_vec(), public);
        // a model that OpenSSL signed
        assert!(Model::parse_signed(DSN_200_SIGNED, PUBLIC_KEY, 0).is_ok());
        assert_eq!(sign(DSN_200, [3; 32], 0).unwrap(), DSN_200_SIGNED);
    }

    #[test]
    fn new_keys_differ_and_are_never_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let [secret, public] = new_key(&folder.path().join("one")).unwrap();
        assert_eq!(public_key(read_key(&secret).unwrap()), read_key(&public).unwrap());
        let [other, _] = new_key(&folder.path().join("two")).unwrap();
        assert_ne!(read_key(&secret).unwrap(), read_key(&other).unwrap());
        assert!(new_key(&folder.path().join("one")).is_err());
        // a public key that is there is kept, and no secret one without its pair is left
        std::fs::write(folder.path().join("three.v2.pub"), b"kept").unwrap();
        assert!(new_key(&folder.path().join("three.v2")).is_err());
        assert!(!folder.path().join("three.v2.key").exists());
        // neither kind is taken for the other
        assert!(read_secret_key(&public).unwrap_err().to_string().contains("must be a secret key"));
        assert!(read_public_key(&secret).unwrap_err().to_string().contains("must be a public key"));
        std::fs::write(&other, b"short").unwrap();
        assert!(
            read_key(&other).unwrap_err().to_string().contains("length of the key is 5, must be 32 bytes")
        );
    }
}
