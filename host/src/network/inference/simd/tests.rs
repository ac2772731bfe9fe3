//! Every vector operation against its plain meaning, on every instruction set that this processor has.

use super::arrays::Arrays;
use super::*;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::fixed::{clamp_i8, requantize};

/// Runs a kernel on arrays and on everything the processor has.
fn on_all(kernel: impl Kernel + Copy) {
    Arrays::<2>.dispatch(kernel);
    Arrays::<4>.dispatch(kernel);
    for isa in Isa::ALL {
        if let Some(backend) = Backend::new(isa) {
            assert!(isa.available(), "{isa:?}");
            backend.dispatch(kernel);
        }
    }
}

fn random() -> Xoshiro128PlusPlus {
    Xoshiro128PlusPlus::seed_from_u64(7)
}

/// Multipliers and accumulators at which rounding turns, then random ones.
fn multipliers(random: &mut impl Rng) -> [i32; 16] {
    let edges = [0, 1 << 30, (1 << 30) + 1, i32::MAX, i32::MAX - 1, 3 << 29];
    std::array::from_fn(|k| edges.get(k).copied().unwrap_or((1 << 30) + (random.next_u32() >> 2) as i32))
}

#[derive(Clone, Copy)]
struct Requantisation;

impl Kernel for Requantisation {
    fn run<S: SimdI32>(self, simd: S) {
        let mut random = random();
        let mut compared = 0;
        for shift in -MAX_SHIFT..=-1 {
            let exponent = u32::from(shift.unsigned_abs());
            for multiplier in multipliers(&mut random) {
                let zero = random.next_u32() as i8;
                let mut by = Requantizer::ZERO;
                (0..LANES).for_each(|lane| by.set_lane(lane, multiplier, shift, zero).expect("in range"));
                for round in 0..40 {
                    let mut step = |lane: usize| {
                        // around the halves of the output's steps, which a multiplier near 1 keeps where they are
                        let half = (2 * (random.next_u32() as i32 % 200) + 1) << (exponent - 1);
                        match round % 4 {
                            0 => lane as i32 - 8,
                            1 => [1 << 30, (1 << 30) - 1, (1 << 30) - 2][lane % 3] * (1 - (lane as i32 & 2)),
                            2 => half + lane as i32 - 8,
                            _ => random.next_u32() as i32 >> (2 + random.next_u32() % 20),
                        }
                    };
                    let acc: [i32; LANES] = std::array::from_fn(|lane| {
                        step(lane).clamp(-(MAX_ACCUMULATOR as i32) + 1, MAX_ACCUMULATOR as i32 - 1)
                    });
                    let twice = simd.load(&I32x16(acc.map(|acc| 2 * acc)));
                    let both = [
                        simd.store(simd.requantize::<true>(twice, &by)),
                        simd.store(simd.requantize::<false>(twice, &by)),
                    ];
                    for lane in 0..LANES {
                        let expected = requantize(acc[lane], multiplier, shift) + i32::from(zero);
                        assert_eq!(both[0].0[lane], expected, "{} {multiplier} {shift} {zero}", acc[lane]);
                        assert_eq!(both[1].0[lane].max(zero.into()), expected.max(zero.into()));
                        compared += 1;
                    }
                }
            }
        }
        assert!(compared > 200_000);
    }
}

#[test]
fn requantisation_is_the_plain_rule() {
    on_all(Requantisation);
    let mut by = Requantizer::ZERO;
    for shift in [-31, -21, 0, 1, 7] {
        assert_eq!(by.set_lane(0, 1 << 30, shift, 0), None);
    }
    assert_eq!(by.set_lane(0, -1, -5, 0), None);
}

#[derive(Clone, Copy)]
struct Products;

impl Kernel for Products {
    fn run<S: SimdI32>(self, simd: S) {
        let mut random = random();
        for round in 0..2000 {
            let mut byte = || match round {
                0 => 127,
                1 => -128,
                _ => random.next_u32() as i8,
            };
            let four: [i8; 4] = std::array::from_fn(|_| byte());
            let weights: [[i8; 4]; LANES] = std::array::from_fn(|_| core::array::from_fn(|_| byte()));
            let start: [i32; LANES] = std::array::from_fn(|lane| i32::MAX - 1000 * lane as i32);
            let mut words = [0; 2];
            let words = &mut words[..4 / S::INPUTS];
            simd.input_words(&four, words);
            let mut sum = simd.load(&I32x16(start));
            for (k, &word) in words.iter().enumerate() {
                let line = I32x16(weights.map(|w| match S::INPUTS {
                    2 => i32::from(w[2 * k]) & 0xffff | i32::from(w[2 * k + 1]) << 16,
                    _ => i32::from_le_bytes(w.map(|w| w as u8)),
                }));
                sum = simd.dot(sum, word, simd.load(&line));
            }
            let offset = if S::INPUTS == 4 { 128 } else { 0 };
            for (lane, &found) in simd.store(sum).0.iter().enumerate() {
                let products = four.iter().zip(weights[lane]);
                let dot: i32 = products.map(|(&x, w)| (i32::from(x) + offset) * i32::from(w)).sum();
                assert_eq!(found, start[lane].wrapping_add(dot));
            }
        }
    }
}

#[test]
fn products_wrap_and_do_not_saturate() {
    on_all(Products);
}

#[derive(Clone, Copy)]
struct Simple;

impl Kernel for Simple {
    fn run<S: SimdI32>(self, simd: S) {
        let mut random = random();
        for _ in 0..500 {
            let v: [[i32; LANES]; 4] = std::array::from_fn(|_| {
                std::array::from_fn(|_| random.next_u32() as i32 >> (random.next_u32() % 32))
            });
            let [a, b, ..] = v.map(|v| simd.load(&I32x16(v)));
            let sum = simd.store(simd.add(a, b)).0;
            let largest = simd.store(simd.max(a, b)).0;
            let difference = simd.store(simd.sub(a, b)).0;
            let by = v[2][1] as u32 % 32;
            let right = simd.store(simd.shift_right(a, by)).0;
            let low = simd.store(simd.multiply_low(a, b)).0;
            let halves = v.map(|v| simd.load16(v.first_chunk().expect("half")));
            let halves = [
                simd.store16(simd.add16(halves[0], halves[1])),
                simd.store16(simd.sub16(halves[0], halves[1])),
                simd.store16(simd.shift_left16::<2>(halves[0])),
            ];
            for (k, (&a, &b)) in v[0].iter().zip(&v[1]).enumerate().take(LANES / 2) {
                let of = |part: u32, word: i32| (word >> (16 * part)) as i16;
                for part in 0..2 {
                    let (a, b) = (of(part, a), of(part, b));
                    assert_eq!(of(part, halves[0][k]), a.wrapping_add(b));
                    assert_eq!(of(part, halves[1][k]), a.wrapping_sub(b));
                    assert_eq!(of(part, halves[2][k]), a << 2);
                }
            }
            let shifted = simd.store(simd.shift_left::<19>(a)).0;
            let (x, y) = (v[0].map(|v| v as i8), v[1].map(|v| v as i8));
            let product = simd
                .store(simd.multiply(simd.widen(&x), simd.load(&I32x16(y.map(|y| i32::from(y) & 0xffff)))))
                .0;
            let (least, most) = (x[0].min(y[0]), x[0].max(y[0]));
            let narrow = simd.narrow(v.map(|v| simd.load(&I32x16(v))), least, most);
            for lane in 0..LANES {
                assert_eq!(sum[lane], v[0][lane].wrapping_add(v[1][lane]));
                assert_eq!(largest[lane], v[0][lane].max(v[1][lane]));
                assert_eq!(difference[lane], v[0][lane].wrapping_sub(v[1][lane]));
                assert_eq!(right[lane], v[0][lane] >> by);
                assert_eq!(low[lane], v[0][lane].wrapping_mul(v[1][lane]));
                assert_eq!(shifted[lane], v[0][lane] << 19);
                assert_eq!(product[lane], i32::from(x[lane]) * i32::from(y[lane]));
                for k in 0..4 {
                    assert_eq!(narrow[LANES * k + lane], clamp_i8(v[k][lane], least, most));
                }
            }
            assert_eq!(simd.store(simd.splat(v[2][0])).0, [v[2][0]; LANES]);
            let mut values = [0_i8; 44];
            values.iter_mut().for_each(|v| *v = random.next_u32() as i8);
            let (mut words, mut expected) = ([0; 22], [0; 22]);
            let count = values.len() / S::INPUTS;
            simd.input_words(&values, &mut words[..count]);
            match S::INPUTS {
                2 => Arrays::<2>.input_words(&values, &mut expected[..count]),
                _ => Arrays::<4>.input_words(&values, &mut expected[..count]),
            }
            assert_eq!(words, expected);
        }
    }
}

#[test]
fn the_other_operations_are_their_names() {
    on_all(Simple);
}
