//! CRC-32 of IEEE 802.3: reflected, polynomial 0xEDB88320, initial value and final exclusive or 0xFFFFFFFF.
//!
//! Source: D. V. Sarwate, Computation of cyclic redundancy checks via table look-up, CACM 31(8), 1988; a byte at a time.

const TABLE: [u32; 256] = {
    let mut table = [0; 256];
    let mut index = 0;
    while index < 256 {
        let mut crc = index as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
            bit += 1;
        }
        table[index] = crc;
        index += 1;
    }
    table
};

/// A checksum that is computed piece by piece: `Crc32::new().update(bytes).finish()`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Crc32(u32);

impl Crc32 {
    /// Of no bytes.
    #[allow(clippy::new_without_default)] // one name is enough
    pub const fn new() -> Self {
        Crc32(u32::MAX)
    }

    /// Takes in more bytes. Cost: about 7 instructions a byte on Cortex-M4F, and 1 kB of tables.
    #[must_use]
    pub fn update(self, bytes: &[u8]) -> Self {
        Crc32(bytes.iter().fold(self.0, |crc, &byte| TABLE[usize::from(crc as u8 ^ byte)] ^ crc >> 8))
    }

    /// The checksum.
    pub const fn finish(self) -> u32 {
        !self.0
    }
}

/// The checksum of these bytes.
pub fn crc32(bytes: &[u8]) -> u32 {
    Crc32::new().update(bytes).finish()
}
