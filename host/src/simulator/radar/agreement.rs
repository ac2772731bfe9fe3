//! What the front end adds: levels and spectra in raw slots, and the same in range samples.

use super::*;
use crate::formats::slots::Slots;
use crate::scenario::builtin::named;
use crate::scenario::{FrontEnd, SPEED_OF_LIGHT};
use crate::simulator::dataset::tests::disagreement;

/// A shipped scenario without noise figure, its front end ideal.
fn shipped(name: &str) -> Scenario {
    let mut scenario = named(name.as_ref()).unwrap().scenario();
    scenario.radar.front_end = FrontEnd::Ideal;
    scenario
}

/// A receiver with an LSB of 0.1 mW^0.5 and no noise.
fn quiet(scenario: &Scenario) -> Receiver<'_> {
    let mut receiver = Receiver::new(scenario, |draws| Random::new(1, draws as u64, 0, 0));
    (receiver.converter.lsb, receiver.converter.noise_lsb) = (1e-4, 0.0);
    receiver
}

fn path(amplitude: f64, phase: f64, delay_s: f64) -> Path {
    Path { gain: phasor(phase) * amplitude, delay_s, departure: [1.0, 0.0, 0.0], arrival: [1.0, 0.0, 0.0] }
}

/// The complex beat of a raw slot of the paper's radar, in LSB.
fn beat(values: &[i16]) -> Vec<Complex64> {
    let complex = |pair: &[i16]| Complex64::new(pair[0].into(), pair[1].into());
    values.chunks(2).zip(CHIRP.iter()).map(|(pair, s)| complex(pair) * s.conj()).collect()
}

fn db(ratio: f64) -> f64 {
    10.0 * libm::log10(ratio)
}

#[test]
fn phase_noise_of_an_echo_is_range_correlated() {
    let mut scenario = shipped("conference-room");
    let clean = scenario.clone();
    scenario.radar.phase_noise_dbc_hz = Some(-80.0);
    let spectrum = scenario.radar.effects().spectrum.unwrap();
    // bins of 10 kHz, in threes
    let bins = [4, 10, 30, 60, 100, 140];
    let (slots, window) =
        (300, |n: usize| 0.5 - 0.5 * libm::cos(2.0 * PI * (n as f64 + 0.5) / SAMPLES as f64));
    let norm: f64 = (0..SAMPLES).map(|n| window(n) * window(n)).sum::<f64>() * SAMPLE_RATE;
    let mut found = Vec::new();
    for delay_s in [3e-9, 30e-9] {
        let echo = [path(2.0, 0.3, delay_s)];
        let mut reference = Vec::new();
        quiet(&clean).slot(&echo, &mut reference);
        let reference = beat(&reference);
        let mut receiver = quiet(&scenario);
        let mut density = [0.0; 6];
        for _ in 0..slots {
            let mut values = Vec::new();
            receiver.slot(&echo, &mut values);
            let phase: Vec<f64> =
                beat(&values).iter().zip(&reference).map(|(z, r)| (z * r.conj()).im / r.norm_sqr()).collect();
            for (density, bin) in density.iter_mut().zip(bins) {
                for bin in bin - 1..=bin + 1 {
                    let term = |(n, x): (usize, &f64)| {
                        phasor(-2.0 * PI * ((bin * n) % SAMPLES) as f64 / SAMPLES as f64) * (x * window(n))
                    };
                    let sum: Complex64 = phase.iter().enumerate().map(term).sum();
                    *density += sum.norm_sqr() / norm / 3.0 / f64::from(slots);
                }
            }
        }
        for (found, bin) in density.iter().zip(bins) {
            let offset_hz = bin as f64 * 1e4;
            let sine = libm::sin(PI * offset_hz * delay_s);
            let exact = 4.0 * sine * sine * spectrum.at(offset_hz);
            assert!(db(found / exact).abs() < 0.5, "{delay_s} {offset_hz}: {} dB", db(found / exact));
        }
        found.push(density);
    }
    // 20 dB a decade of the delay
    for (near, far) in found[0].iter().zip(&found[1]) {
        assert!((db(far / near) - 20.0).abs() < 0.5, "{}", db(far / near));
    }
}

/// Per range sample the power of what changes from slot to slot with echoes that do not, and its covariance with the next sample.
fn fluctuation(beats: &[Beat], kept: usize) -> Vec<[f64; 2]> {
    let at = |beat: &Beat, r: usize| Complex64::new(beat[r].re.into(), beat[r].im.into());
    let slots = beats.len() as f64;
    let mean = |r| beats.iter().map(|b| at(b, r)).sum::<Complex64>() / slots;
    let mean: Vec<_> = (0..kept).map(mean).collect();
    (0..kept)
        .map(|r| {
            let next = (r + 1) % kept;
            let product = |b: &Beat| {
                let (z, n) = (at(b, r) - mean[r], at(b, next) - mean[next]);
                [z.norm_sqr(), (z * n.conj()).re]
            };
            beats.iter().map(product).fold([0.0; 2], |sum, p| [sum[0] + p[0] / slots, sum[1] + p[1] / slots])
        })
        .collect()
}

#[test]
fn phase_noise_of_range_samples_is_that_of_raw_slots() {
    let mut chirp = shipped("conference-room");
    let r = &mut chirp.radar;
    (r.bandwidth_hz, r.sample_rate_hz, r.sweep_s, r.samples) = (40e6, 40e6, 40e-6, 1600);
    for mut scenario in [shipped("conference-room"), chirp, shipped("bgt60"), shipped("iwr")] {
        scenario.check("test").unwrap();
        scenario.radar.phase_noise_dbc_hz = Some(-75.0);
        let (config, kept) = (scenario.radar.config(), usize::from(scenario.radar.range_samples));
        let (gate, wide) = (scenario.radar.bins_per_sample > 0, scenario.radar.bandwidth_hz > 10e6);
        let metres = [1.2, 1.93, 3.1, 4.37, 5.2];
        let echoes: Vec<_> = (0..5)
            .map(|k| path(0.03, 1.3 * f64::from(k * k), 2.0 * metres[k as usize] / SPEED_OF_LIGHT))
            .collect();
        let slots = 1500;
        let mut receiver = quiet(&scenario);
        let mut raw = Slots::with_capacity(config.values_per_slot(), slots);
        (0..slots).for_each(|_| receiver.slot(&echoes, &mut raw.values));
        let raw = fluctuation(&raw.beats(config).unwrap(), kept);
        let mut blocks = Blocks::default();
        echoes.iter().for_each(|one| receiver.response.add(&mut blocks, one.gain, one.delay_s));
        assert!(!receiver.needs_samples());
        let fast = receiver.beats(&vec![blocks; slots]);
        let fast = fluctuation(&fast, kept);
        let sum = |of: &[[f64; 2]]| of.iter().map(|one| one[0]).sum::<f64>();
        let (each, all) = if gate {
            (2.5, 1.6)
        } else if wide {
            (1.6, 0.7)
        } else {
            (0.6, 0.4)
        };
        let total = db(sum(&fast) / sum(&raw));
        for (r, (raw, fast)) in raw.iter().zip(&fast).enumerate() {
            assert!(db(fast[0] / raw[0]).abs() < each, "{} {r}", scenario.name);
        }
        assert!(total.abs() < all, "{}: {total} dB", scenario.name);
    }
}

#[test]
fn offset_and_leakage_have_their_levels() {
    for name in ["conference-room", "bgt60", "iwr"] {
        let mut scenario = shipped(name);
        scenario.radar.dc_offset = Some(0.01);
        let real = scenario.radar.format == Format::Real;
        let full = f64::from((1_u32 << (scenario.radar.converter_bits - 1)) - 1);
        let mut values = Vec::new();
        quiet(&scenario).slot(&[], &mut values);
        let magnitude = match real {
            true => f64::from(values[0]).abs(),
            false => f64::from(values[0]).hypot(values[1].into()),
        };
        assert!((magnitude - 0.01 * full).abs() < 0.8, "{name}: {magnitude}");
        assert!(values.windows(3).all(|three| three[0] == three[2]), "{name}");

        scenario.radar.dc_offset = None;
        scenario.radar.isolation_db = Some(30.0);
        // into the converter's range
        scenario.radar.power_w = 1.0;
        let mut values = Vec::new();
        quiet(&scenario).slot(&[], &mut values);
        let power = values.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>()
            / f64::from(scenario.radar.samples);
        let power = if real { 2.0 * power } else { power };
        // 1 W less 30 dB are 316 LSB
        assert!(db(power / 1e5).abs() < 0.3, "{name}: {power}");
    }
}

#[test]
fn leakage_raises_full_scale_instead_of_saturating() {
    for name in ["conference-room", "bgt60", "iwr"] {
        let mut scenario = shipped(name);
        scenario.radar.isolation_db = Some(20.0);
        let mut receiver = Receiver::new(&scenario, |draws| Random::new(1, draws as u64, 0, 0));
        let mut values = Vec::new();
        receiver.slot(&[], &mut values);
        let full = (1_i32 << (scenario.radar.converter_bits - 1)) - 1;
        assert!(values.iter().all(|&x| i32::from(x).abs() < full), "{name}");
    }
}

#[test]
fn a_loud_echo_is_compressed_by_one_decibel() {
    for name in ["conference-room", "bgt60", "iwr"] {
        let mut scenario = shipped(name);
        let echo = [path(0.15, 0.2, 16e-9)];
        let level = |scenario: &Scenario| {
            let mut values = Vec::new();
            quiet(scenario).slot(&echo, &mut values);
            values.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>()
        };
        let before = level(&scenario);
        // 0.0225 W
        scenario.radar.compression_dbm = Some(db(0.0225) + 30.0);
        let lost = db(before / level(&scenario));
        assert!((lost - 1.0).abs() < 0.01, "{name}: {lost}");
    }
}

#[test]
fn raw_slots_and_beats_agree_on_every_effect_of_the_front_end() {
    type Set = fn(&mut Radar);
    fn quadrature(r: &mut Radar) {
        if r.format == Format::Complex {
            (r.iq_gain_db, r.iq_phase_deg) = (Some(0.2), Some(1.0));
        }
    }
    fn compression(r: &mut Radar) {
        (r.front_end, r.phase_noise_dbc_hz) = (FrontEnd::Typical, Some(-200.0));
        (r.isolation_db, r.dc_offset) = (Some(200.0), Some(0.0));
        (r.iq_gain_db, r.iq_phase_deg) = (Some(0.0), Some(0.0));
    }
    fn phase_noise(r: &mut Radar) {
        compression(r);
        (r.phase_noise_dbc_hz, r.compression_dbm) = (None, Some(100.0));
    }
    // phase noise is drawn for range samples: there its own power is the difference, twice
    let effects: [(&str, Set, [f64; 3]); 6] = [
        (
            "leakage",
            |r| r.isolation_db = Some(if r.carrier_hz > 10e9 { 65.0 } else { 40.0 }),
            [-75.0, -75.0, -71.0],
        ),
        ("offset", |r| r.dc_offset = Some(0.01), [-75.0; 3]),
        ("quadrature", quadrature, [-75.0, -75.0, -60.0]),
        ("compression", compression, [-85.0, -45.0, -38.0]),
        ("phase noise", phase_noise, [-85.0, -54.0, -44.0]),
        ("typical", |r| r.front_end = FrontEnd::Typical, [-80.0, -44.0, -40.0]),
    ];
    let mut worst = Vec::new();
    for (k, name) in ["conference-room", "bgt60", "iwr"].into_iter().enumerate() {
        for (effect, set, most_db) in effects {
            let mut scenario = shipped(name);
            // the 12 bits of a small converter would round more away
            (scenario.radar.converter_bits, scenario.radar.noise_figure_db) = (16, 0.0);
            if name != "conference-room" {
                scenario.radar.power_w *= 1e4;
            }
            set(&mut scenario.radar);
            scenario.check("test").unwrap();
            let db = disagreement(&scenario);
            println!("{name}: raw slots and range samples {effect} {db:.1} dB (limit {})", most_db[k]);
            worst.extend((db >= most_db[k]).then_some((name, effect, db)));
        }
    }
    assert!(worst.is_empty(), "{worst:?}");
}

#[test]
fn range_samples_that_are_not_known_are_made_of_raw_slots() {
    let mut scenario = shipped("iwr");
    (scenario.radar.bins_per_sample, scenario.radar.first_bin) = (0, 0);
    scenario.check("test").unwrap();
    assert!(!quiet(&scenario).needs_samples());
    scenario.radar.isolation_db = Some(60.0);
    assert!(!quiet(&scenario).needs_samples());
    scenario.radar.front_end = FrontEnd::Typical;
    assert!(quiet(&scenario).needs_samples());
    assert_eq!(disagreement(&scenario), f64::NEG_INFINITY);
}
