//! Tests of `simd::conj_mac`.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::simd::native_conj_mac;

#[test]
fn sums_are_exact() {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(5);
    for (round, block) in (0..50).zip([125, 128, 250, 1000, 64].into_iter().cycle()) {
        let mut draw = || match round {
            0 => i16::MIN,
            1 => [i16::MIN, i16::MAX][random.next_u32() as usize % 2],
            2 => -1,
            _ => random.next_u32() as i16 >> (round % 16),
        };
        let samples: [[i16; 2]; 1000] = core::array::from_fn(|_| [draw(), draw()]);
        let reference = sdp3_core::signal::dechirp::CHIRP;
        let (mut exact, mut found) = ([[0_i64; 2]; 16], [[0; 2]; 16]);
        for (n, (x, s)) in samples.iter().zip(&reference).enumerate().take(1000 / block * block) {
            let ([i, q], [c, s]) = (x.map(i64::from), s.map(i64::from));
            exact[n / block][0] += i * c + q * s;
            exact[n / block][1] += q * c - i * s;
        }
        native_conj_mac(&samples, &reference, block, &mut found);
        assert_eq!(found, exact, "blocks of {block}");
    }
}
