//! The layout of a model file.
//!
//! Layout (little-endian): 64-byte header, class names of 24 bytes, layers in the order stem, per block (affine, conv, conv, add),
//! head, or a graph (module `graph`) in their place, an ed25519 signature of everything before it if the header says so, and the CRC-32 (IEEE 802.3) of everything before that.
//!
//! | header byte | field |
//! |---|---|
//! | 0..4, 4..6, 6..8, 8..12 | `SDP3`, version, length of the header, length of the file |
//! | 12..16 | sensing slots N_s (u16, at most 4000), first (at most the number of range samples) and last singular component kept |
//! | 16..24 | Kaiser window's length, hop, image rows (u16 each), FFT bins per row, stride of the stem (0: a graph) |
//! | 24..32 | dynamic range in 1/64 octave, frames (u16 each), Kaiser window's beta (f32) |
//! | 32..36 | channels, blocks (both 0: a graph), classes, signature: 0 none, 1 ed25519 |
//! | 36..44 | carrier in kHz, interval of the sensing slots in us (u32 each; for people) |
//! | 44..48 | revision (u32), which only grows: what a rollback is known by |
//! | 48..56 | the sensor, [`RadarConfig::to_bytes`](crate::config::RadarConfig::to_bytes): zeros for the paper's radar |
//! | 56..60 | bytes of the graph's arena (u32); 0 without a graph |
//! | 60..64 | zeros |

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
/// Bytes of an ed25519 signature.
pub const SIGNATURE_LEN: usize = 64;
/// Bytes of an ed25519 public key.
pub const KEY_LEN: usize = 32;
/// Where the header says whether there is a signature.
pub const SIGNATURE_AT: usize = 35;
/// Where the header has its revision (u32, little-endian).
pub const REVISION_AT: usize = 44;
/// Where the header has the bytes of a graph's arena (u32, little-endian).
pub const ARENA_AT: usize = 56;
