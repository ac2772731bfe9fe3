//! Power-on self test: the street up to the image on a seeded signal whose digest is known.
//!
//! It shows a wrong build, a damaged table or a floating-point unit in flush-to-zero mode before the first slot does.

use crate::config::RadarConfig;
use crate::digest::{Digest, DigestProbe};
use crate::dims::{Beat, Complex, ROWS, ZERO_BEAT};
use crate::signal::front_end::{FrontEnd, FrontEndBuffers, Preprocessing};
use crate::signal::stft::FloatStft;
use rand_core::Rng;

/// Slots of the test: two frames.
pub const SLOTS: usize = 136;

/// Digest of all stages for `rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3)`, on every processor.
pub const KNOWN_ANSWER: u64 = 0xab4d_1384_c502_acf1;

/// Fills a slot with seeded noise over a tenth of the converter's range.
pub fn noise(rng: &mut impl Rng, slot: &mut [i16]) {
    for sample in slot.as_chunks_mut::<2>().0 {
        let word = rng.next_u32();
        // arithmetic shifts keep the sign: about +-4096 LSB
        *sample = [(word as i16) >> 3, ((word >> 16) as i16) >> 3];
    }
}

/// Runs [`SLOTS`] slots of noise from `rng` through the street up to the image and digests every stage.
///
/// Takes about 13 kB of stack and 136 dechirped slots' time.
pub fn run(rng: &mut impl Rng) -> u64 {
    let mut beats: [Beat; SLOTS] = [ZERO_BEAT; SLOTS];
    let mut slow_time = [Complex::new(0, 0); SLOTS];
    let mut levels = [0; 2 * ROWS];
    let mut image = [0; 2 * ROWS];
    let buffers = FrontEndBuffers {
        reference: &mut [],
        beats: &mut beats,
        slow_time: &mut slow_time,
        levels: &mut levels,
        image: &mut image,
    };
    let Some(mut front_end) =
        FrontEnd::<FloatStft>::new(RadarConfig::PAPER, Preprocessing::default(), buffers)
    else {
        return 0;
    };
    let mut probe = DigestProbe::new();
    let mut slot = [0; RadarConfig::PAPER.values_per_slot()];
    for _ in 0..SLOTS {
        noise(rng, &mut slot);
        front_end.push(&slot, &mut probe);
    }
    front_end.image(&mut probe);
    let mut all = Digest::new();
    for (_, digest) in probe.stages() {
        all.value(digest.hash().to_le_bytes());
    }
    all.hash()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::SeedableRng;

    #[test]
    fn the_answer_is_known() {
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        assert_eq!(run(&mut rng), KNOWN_ANSWER);
    }

    #[test]
    fn another_signal_has_another_answer() {
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(4);
        assert_ne!(run(&mut rng), KNOWN_ANSWER);
    }
}
