//! Tests of `supervision::sample_health`.

use sdp3_core::config::{RadarConfig, SampleFormat};
use sdp3_core::supervision::sample_health::*;
use std::string::ToString;
use std::vec::Vec;

const PAPER: RadarConfig = RadarConfig::PAPER;

fn sweep(amplitude: f64) -> Vec<i16> {
    let pair = |n: usize| {
        let phase = 3e-4 * (n * n) as f64;
        [0.0, -1.571]
            .map(|shift| libm::round(amplitude * libm::cos(phase + shift)).clamp(-32768.0, 32767.0) as i16)
    };
    (0..1000).flat_map(pair).collect()
}

/// The in-phase values, or those in quadrature.
fn channel(slot: &mut [i16], quadrature: bool) -> impl Iterator<Item = &mut i16> {
    slot.iter_mut().skip(usize::from(quadrature)).step_by(2)
}

#[test]
fn working_converters_are_trusted_from_a_few_lsb_to_the_range() {
    for amplitude in [2.0, 5.0, 100.0, 3e4] {
        assert_eq!(check(&sweep(amplitude), &PAPER), Ok(()), "{amplitude}");
    }
    // 12 bits in the upper part of a word, and a beat signal beside zero
    for bits in [8, 12, 14] {
        let left = RadarConfig { converter_bits: bits, left_justified: true, ..PAPER };
        let slot: Vec<i16> = sweep(3e4).iter().map(|x| x >> (16 - bits) << (16 - bits)).collect();
        assert_eq!(check(&slot, &left), Ok(()), "{bits} bits");
        assert!(matches!(check(&slot, &PAPER), Err(SampleFault::Stuck { .. })));
    }
    let beside: Vec<i16> = sweep(50.0).iter().step_by(2).take(128).map(|x| x + 100).collect();
    assert_eq!(check(&beside, &RadarConfig::BGT60), Ok(()));
}

#[test]
fn every_fault_has_its_name() {
    assert_eq!(check(&[5; 2000], &PAPER), Err(SampleFault::Silent));
    assert_eq!(check(&[], &PAPER), Err(SampleFault::Silent));
    for bit in 0..16 {
        let mut slot = sweep(2000.0);
        channel(&mut slot, true).for_each(|x| *x |= 1 << bit);
        assert_eq!(check(&slot, &PAPER), Err(SampleFault::Stuck { i: 0, q: 1 << bit }));
        let mut slot = sweep(2000.0);
        channel(&mut slot, false).for_each(|x| *x &= !(1 << bit));
        assert_eq!(check(&slot, &PAPER), Err(SampleFault::Stuck { i: 1 << bit, q: 0 }));
    }
    assert!(matches!(check(&sweep(4e4), &PAPER), Err(SampleFault::Saturated { values: 60.. })));
    let mut slot = sweep(5000.0);
    channel(&mut slot, false).for_each(|x| *x += 3500);
    assert!(matches!(check(&slot, &PAPER), Err(SampleFault::Offset { i: 2500..4500, q: -1000..1000 })));
    // a real sensor of 12 bits
    let real: Vec<i16> = sweep(4000.0).iter().step_by(2).take(128).map(|x| (*x).clamp(-2048, 2047)).collect();
    assert!(matches!(check(&real, &RadarConfig::BGT60), Err(SampleFault::Saturated { .. })));
    let even: Vec<i16> = sweep(500.0).iter().step_by(2).take(128).map(|x| x & !1).collect();
    assert_eq!(check(&even, &RadarConfig::BGT60), Err(SampleFault::Stuck { i: 1, q: 0 }));
    // one of two channels of a beat signal that never moves
    for (moving, stuck) in [(false, (0, u16::MAX)), (true, (u16::MAX, 0))] {
        let mut slot = [7; 2 * RadarConfig::IWR.samples as usize];
        channel(&mut slot, moving).enumerate().for_each(|(n, x)| *x = (n * 37 % 1000) as i16 - 500);
        assert_eq!(check(&slot, &RadarConfig::IWR), Err(SampleFault::Stuck { i: stuck.0, q: stuck.1 }));
    }
}

/// Samples that move every bit about these means.
fn about(i: i16, q: i16) -> Vec<i16> {
    let pair = |n: usize| {
        let swing = 31 * (n as i16 / 2) + 1;
        let swing = if (n / 8).is_multiple_of(2) { swing } else { -swing };
        [i + swing, q - swing]
    };
    (0..1000).flat_map(pair).collect()
}

#[test]
fn means_beyond_the_limit_are_found_on_either_side() {
    for (i, q) in [(1800, 0), (0, -1800), (-1800, 1800)] {
        assert_eq!(check(&about(i, q), &PAPER), Ok(()), "{i}, {q}");
    }
    for (i, q) in [(2300, 0), (-2300, 1), (0, 2300), (7, -2300)] {
        assert!(matches!(check(&about(i, q), &PAPER), Err(SampleFault::Offset { .. })), "{i}, {q}");
    }
}

/// A slot of the paper's radar in which only the samples that are looked at are not zero: one of each 8, at another place in every group.
/// Their means are these, and every bit moves.
fn looked_at(i: i16, q: i16) -> Vec<i16> {
    let mut slot = std::vec![0; 2000];
    for k in 0..125_usize {
        let swing = 37 * k.div_ceil(2) as i16;
        let swing = if k % 2 == 0 { swing } else { -swing };
        let sample = 8 * k + k % 8;
        (slot[2 * sample], slot[2 * sample + 1]) = (i + swing, q - swing);
    }
    slot
}

#[test]
fn limits_hold_to_the_last_value() {
    // one in 16 of 32767, and one for what division drops
    for mean in [2048, -2048] {
        assert_eq!(check(&looked_at(mean, 0), &PAPER), Ok(()));
        assert_eq!(check(&looked_at(0, mean), &PAPER), Ok(()));
        let beyond = mean + mean.signum();
        assert_eq!(check(&looked_at(beyond, 0), &PAPER), Err(SampleFault::Offset { i: beyond, q: 0 }));
        assert_eq!(check(&looked_at(0, beyond), &PAPER), Err(SampleFault::Offset { i: 0, q: beyond }));
    }
    // one in 100 of 250 values; others are not looked at
    let mut slot = looked_at(0, 0);
    slot[2] = i16::MAX;
    (slot[0], slot[2 * 9 + 1]) = (i16::MAX, i16::MIN);
    assert_eq!(check(&slot, &PAPER), Ok(()));
    slot[2 * 18] = i16::MIN;
    assert_eq!(check(&slot, &PAPER), Err(SampleFault::Saturated { values: 3 }));
}

#[test]
fn a_converter_of_12_bits_has_its_own_ends_and_bits() {
    // the lower end alone, right-justified
    let low: Vec<i16> =
        sweep(1900.0).iter().step_by(2).take(128).map(|&x| if x < 0 { -2048 } else { x }).collect();
    assert!(matches!(check(&low, &RadarConfig::BGT60), Err(SampleFault::Saturated { .. })));
    // a bit in the middle, left-justified
    let left = RadarConfig { converter_bits: 12, left_justified: true, ..PAPER };
    for bit in 4..16 {
        let slot: Vec<i16> = sweep(3e4).iter().map(|x| (x >> 4 << 4) | 1 << bit).collect();
        assert_eq!(check(&slot, &left), Err(SampleFault::Stuck { i: 1 << bit, q: 1 << bit }), "{bit}");
    }
}

#[test]
fn a_slot_of_one_sample_shows_only_the_ends_of_the_range() {
    for value in [0, 5, -30_000, 32_766] {
        assert_eq!(check(&[value], &RadarConfig::DOPPLER), Ok(()));
        assert_eq!(check(&[value, 0], &RadarConfig::DOPPLER_IQ), Ok(()));
    }
    assert_eq!(check(&[i16::MAX], &RadarConfig::DOPPLER), Err(SampleFault::Saturated { values: 1 }));
    let both = [i16::MIN, i16::MAX];
    assert_eq!(check(&both, &RadarConfig::DOPPLER_IQ), Err(SampleFault::Saturated { values: 2 }));
    let bits = RadarConfig { converter_bits: 12, ..RadarConfig::DOPPLER };
    assert_eq!(check(&[2047], &bits), Err(SampleFault::Saturated { values: 1 }));
}

#[test]
fn every_fault_says_what_it_is() {
    for (fault, words) in [
        (SampleFault::Silent, "the samples are the same"),
        (SampleFault::Stuck { i: 1, q: 0x8000 }, "bits never move: 0x0001 in phase, 0x8000 in quadrature"),
        (SampleFault::Saturated { values: 21 }, "21 values are at an end of the range"),
        (SampleFault::Offset { i: -3000, q: 4 }, "the mean is -3000 LSB in phase, 4 in quadrature"),
    ] {
        assert_eq!(fault.to_string(), words);
    }
}

#[test]
fn a_slot_of_another_length_is_looked_at_as_far_as_the_sensor_has_values() {
    let sound = sweep(5000.0);
    let longer = [sound.clone(), std::vec![i16::MAX; 65_536]].concat();
    assert_eq!(check(&longer, &PAPER), Ok(()));
    assert_eq!(check(&sound[..1000], &PAPER), Ok(()));
    // more than 65 535 values, and a sum beyond 32 bits
    let complex = RadarConfig { samples: 64, ..PAPER };
    assert_eq!(check(&[1; 65_536], &complex), Err(SampleFault::Silent));
    assert_eq!(check(&std::vec![30_000; 200_000], &RadarConfig::BGT60), Err(SampleFault::Silent));
    // configurations that no sensor may have
    for samples in [0, 1, 63, 64, 249, 65_535] {
        for format in [SampleFormat::Complex, SampleFormat::Real] {
            let config = RadarConfig { samples, format, ..PAPER };
            for value in [i16::MIN, 0, i16::MAX] {
                assert_eq!(
                    check(&std::vec![value; 200_000], &config).is_ok(),
                    samples < 64 && (value == 0 || samples == 0)
                );
            }
        }
    }
}
