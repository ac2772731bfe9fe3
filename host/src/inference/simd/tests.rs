//! Every vector operation against its plain meaning, on every instruction set that this processor has.

use super::arrays::Arrays;
use super::*;
use crate::fixed::{clamp_i8, requantize};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Runs a job on the portable twins and on all the processor has.
fn on_all(job: impl Job + Copy) {
    Arrays::<2>.enter(job);
    Arrays::<4>.enter(job);
    for isa in Isa::ALL {
        if let Some(unit) = Unit::new(isa) {
            assert!(isa.available(), "{isa:?}");
            unit.run(job);
        }
    }
}

fn random() -> Xoshiro128PlusPlus {
    Xoshiro128PlusPlus::seed_from_u64(7)
}

#[cfg(target_arch = "x86_64")]
#[test]
fn the_processor_has_what_the_standard_library_finds() {
    extern crate std;
    let avx2 = std::is_x86_feature_detected!("avx2");
    assert_eq!(Isa::Avx2.available(), avx2);
    assert_eq!(Isa::AvxVnni.available(), avx2 && std::is_x86_feature_detected!("avxvnni"));
    let avx512 = std::is_x86_feature_detected!("avx512f") && std::is_x86_feature_detected!("avx512bw");
    assert_eq!(Isa::Avx512Vnni.available(), avx2 && avx512 && std::is_x86_feature_detected!("avx512vnni"));
    let fastest = Isa::ALL.iter().rposition(|isa| isa.available());
    assert_eq!(Isa::ALL.iter().position(|isa| *isa == Isa::best()), fastest);
}

/// Multipliers and accumulators at which rounding turns, then random ones.
fn multipliers(random: &mut impl Rng) -> [i32; 16] {
    let edges = [0, 1 << 30, (1 << 30) + 1, i32::MAX, i32::MAX - 1, 3 << 29];
    core::array::from_fn(|k| edges.get(k).copied().unwrap_or((1 << 30) + (random.next_u32() >> 2) as i32))
}

#[derive(Clone, Copy)]
struct Requantisation;

impl Job for Requantisation {
    fn run<L: Lanes>(self, lanes: L) {
        let mut random = random();
        let mut compared = 0;
        for shift in -MAX_SHIFT..=-1 {
            let exponent = u32::from(shift.unsigned_abs());
            for multiplier in multipliers(&mut random) {
                let zero = random.next_u32() as i8;
                let mut lines = [Line::ZERO; 5];
                (0..LANES).for_each(|lane| assert!(set_lane(&mut lines, lane, multiplier, shift, zero)));
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
                    let acc: [i32; LANES] = core::array::from_fn(|lane| {
                        step(lane).clamp(-(MAX_ACCUMULATOR as i32) + 1, MAX_ACCUMULATOR as i32 - 1)
                    });
                    let both = [
                        lanes.store(lanes.rescale::<true>(lanes.load(&Line(acc)), &lines)),
                        lanes.store(lanes.rescale::<false>(lanes.load(&Line(acc)), &lines)),
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
    let mut lines = [Line::ZERO; 5];
    for shift in [-31, -21, 0, 1, 7] {
        assert!(!set_lane(&mut lines, 0, 1 << 30, shift, 0));
    }
    assert!(!set_lane(&mut lines, 0, -1, -5, 0));
}

#[derive(Clone, Copy)]
struct Products;

impl Job for Products {
    fn run<L: Lanes>(self, lanes: L) {
        let mut random = random();
        for round in 0..2000 {
            let mut byte = || match round {
                0 => 127,
                1 => -128,
                _ => random.next_u32() as i8,
            };
            let four: [i8; 4] = core::array::from_fn(|_| byte());
            let weights: [[i8; 4]; LANES] = core::array::from_fn(|_| core::array::from_fn(|_| byte()));
            let start: [i32; LANES] = core::array::from_fn(|lane| i32::MAX - 1000 * lane as i32);
            let mut words = [0; 2];
            let words = &mut words[..4 / L::INPUTS];
            lanes.words(&four, words);
            let mut sum = lanes.load(&Line(start));
            for (k, &word) in words.iter().enumerate() {
                let line = Line(weights.map(|w| match L::INPUTS {
                    2 => i32::from(w[2 * k]) & 0xffff | i32::from(w[2 * k + 1]) << 16,
                    _ => i32::from_le_bytes(w.map(|w| w as u8)),
                }));
                sum = lanes.dot(sum, word, lanes.load(&line));
            }
            let offset = if L::INPUTS == 4 { 128 } else { 0 };
            for (lane, &found) in lanes.store(sum).0.iter().enumerate() {
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

impl Job for Simple {
    fn run<L: Lanes>(self, lanes: L) {
        let mut random = random();
        for _ in 0..500 {
            let v: [[i32; LANES]; 4] = core::array::from_fn(|_| {
                core::array::from_fn(|_| random.next_u32() as i32 >> (random.next_u32() % 32))
            });
            let [a, b, ..] = v.map(|v| lanes.load(&Line(v)));
            let sum = lanes.store(lanes.add(a, b)).0;
            let largest = lanes.store(lanes.max(a, b)).0;
            let difference = lanes.store(lanes.sub(a, b)).0;
            let by = v[2][1] as u32 % 32;
            let right = lanes.store(lanes.shift_right(a, by)).0;
            let low = lanes.store(lanes.multiply_low(a, b)).0;
            let halves = v.map(|v| lanes.load16(v.first_chunk().expect("half")));
            let halves = [
                lanes.store16(lanes.add16(halves[0], halves[1])),
                lanes.store16(lanes.sub16(halves[0], halves[1])),
                lanes.store16(lanes.shift_left16::<2>(halves[0])),
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
            let shifted = lanes.store(lanes.shift_left::<19>(a)).0;
            let (x, y) = (v[0].map(|v| v as i8), v[1].map(|v| v as i8));
            let product = lanes.store(lanes.multiply(lanes.widen(&x), lanes.widen(&y))).0;
            let (least, most) = (x[0].min(y[0]), x[0].max(y[0]));
            let narrow = lanes.narrow(v.map(|v| lanes.load(&Line(v))), least, most);
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
            assert_eq!(lanes.store(lanes.splat(v[2][0])).0, [v[2][0]; LANES]);
            let mut values = [0_i8; 44];
            values.iter_mut().for_each(|v| *v = random.next_u32() as i8);
            let (mut words, mut expected) = ([0; 22], [0; 22]);
            let count = values.len() / L::INPUTS;
            lanes.words(&values, &mut words[..count]);
            match L::INPUTS {
                2 => Arrays::<2>.words(&values, &mut expected[..count]),
                _ => Arrays::<4>.words(&values, &mut expected[..count]),
            }
            assert_eq!(words, expected);
        }
    }
}

#[test]
fn the_other_operations_are_their_names() {
    on_all(Simple);
}
