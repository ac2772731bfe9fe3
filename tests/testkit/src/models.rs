//! Model files in the repository, for tests and firmware; `README.md` of this crate says how each was made.

/// N_s = 200, 8 channels, 5 classes.
pub static DSN_200: &[u8] = include_bytes!("../models/dsn-200.sdp3");

/// [`DSN_200`] signed with the demonstration key, revision 0.
pub static DSN_200_SIGNED: &[u8] = include_bytes!("../models/dsn-200-signed.sdp3");

/// N_s = 1000, 16 channels, 5 classes.
pub static DSN_1000: &[u8] = include_bytes!("../models/dsn-1000.sdp3");

/// The demonstration key's public half (ed25519). Its secret half is 32 bytes of 3: it signs nothing but tests.
pub static PUBLIC_KEY: &[u8; 32] = include_bytes!("../models/station.pub");
