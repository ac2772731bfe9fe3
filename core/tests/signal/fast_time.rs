//! Tests of `signal::fast_time` and the range gate.

use sdp3_core::config::{Dechirp, RadarConfig, RangeGate, SampleFormat};
use sdp3_core::signal::dechirp::CHIRP;
use sdp3_core::signal::fast_time::FastTime;

#[test]
fn the_chirp_against_itself_is_a_constant() {
    let chirp = FastTime::new(RadarConfig::PAPER, &mut []).unwrap();
    let full = (32767_i64 * 32767 * 125) >> RadarConfig::PAPER.shift();
    for value in chirp.beat(CHIRP.as_flattened()).unwrap() {
        // rounding of the table: each sample is off by at most 0.71 of 32767
        assert!((i64::from(value.re) - full).abs() < full / 30_000, "{}", value.re);
        assert!(i64::from(value.im).abs() < full / 30_000);
    }
}

/// The strongest slot there is for a range sample: every value at the end of the range that adds to it.
fn loudest(config: &RadarConfig, table: &[[i16; 2]]) -> Vec<i16> {
    let reference = match (config.dechirp, table) {
        (Dechirp::Digital, []) => &CHIRP[..],
        _ => table,
    };
    let at = |n: usize| reference.get(n).copied().unwrap_or([1, 1]);
    let end = |s: i16| if s < 0 { i16::MIN } else { i16::MAX };
    let values = (0..usize::from(config.samples)).flat_map(|n| at(n).map(end));
    match config.format {
        SampleFormat::Complex => values.collect(),
        SampleFormat::Real => values.step_by(2).collect(),
    }
}

#[test]
fn a_full_scale_slot_of_any_configuration_stays_within_the_stated_magnitude() {
    let blocks = RadarConfig { dechirp: Dechirp::Analog, ..RadarConfig::PAPER };
    let wide = RadarConfig { samples: 2048, ..RadarConfig::IWR };
    let gate = |bins| Some(RangeGate { first_bin: 8, bins_per_sample: bins });
    let mut configs = vec![RadarConfig::PAPER, RadarConfig::BGT60, RadarConfig::IWR, blocks];
    configs.extend([1, 2, 32].map(|bins| RadarConfig { gate: gate(bins), ..wide }));
    configs.extend([64, 200, 2048].map(|samples| RadarConfig { samples, ..RadarConfig::PAPER }));
    configs.extend([1, 2, 4, 5].map(|range_samples| RadarConfig { range_samples, ..RadarConfig::PAPER }));
    configs.extend([64, 2048].map(|samples| RadarConfig { samples, range_samples: 1, ..RadarConfig::PAPER }));
    configs.push(RadarConfig { samples: 2048, range_samples: 1, ..blocks });
    configs.extend([RadarConfig::DOPPLER, RadarConfig::DOPPLER_IQ]);
    configs.extend([1, 512, 513, 2048].map(|samples| RadarConfig { samples, ..RadarConfig::DOPPLER_IQ }));
    for config in configs {
        let mut memory = vec![[0; 2]; config.reference_len()];
        FastTime::new(config, &mut memory).unwrap();
        let loudest = loudest(&config, &memory);
        let fast_time = FastTime::new(config, &mut memory).unwrap();
        for value in fast_time.beat(&loudest).unwrap() {
            let power = i64::from(value.re).pow(2) + i64::from(value.im).pow(2);
            assert!(power < 1 << 51, "{config:?}: {value}");
        }
        assert!(fast_time.beat(&[0; 63]).is_none());
    }
}

#[test]
fn an_odd_sweep_has_its_middle_sample() {
    for (samples, bins_per_sample) in [(129, 1), (129, 4), (255, 3), (257, 8)] {
        let gate = Some(RangeGate { first_bin: 4, bins_per_sample });
        let config = RadarConfig { samples, gate, ..RadarConfig::IWR };
        let mut memory = vec![[0; 2]; config.reference_len()];
        FastTime::new(config, &mut memory).unwrap();
        // the window is largest in the middle, where neighbouring bins are in phase
        let size = |n: usize| memory[n].map(|x| f64::from(x).powi(2)).iter().sum::<f64>().sqrt();
        let middle = usize::from(samples) / 2;
        assert!(size(middle) >= size(middle - 1).max(size(middle + 1)) - 2.0, "{samples}");
        assert!((size(middle) - 32767.0).abs() < 2.0, "{samples}: {}", size(middle));
    }
}

#[test]
fn real_and_complex_echoes_land_in_the_range_sample_that_covers_them() {
    for config in [RadarConfig::BGT60, RadarConfig::IWR] {
        let gate = config.gate.unwrap();
        let mut memory = vec![[0; 2]; config.reference_len()];
        let fast_time = FastTime::new(config, &mut memory).unwrap();
        let bins = f64::from(gate.bins_per_sample);
        for range in 0..8 {
            for inside in [0.0, 0.3, 0.5, 0.9] {
                let bin = f64::from(gate.first_bin) - 0.5 + bins * (range as f64 + inside);
                let phase = |n: usize| core::f64::consts::TAU * bin * n as f64 / f64::from(config.samples);
                let pair = |n: usize| [(1e4 * phase(n).cos()) as i16, (1e4 * phase(n).sin()) as i16];
                let all: Vec<i16> = (0..usize::from(config.samples)).flat_map(pair).collect();
                let real = config.format == SampleFormat::Real;
                let slot: Vec<i16> = all.iter().copied().step_by(1 + usize::from(real)).collect();
                let beat = fast_time.beat(&slot).unwrap();
                let power = beat.map(|b| f64::from(b.re).hypot(f64::from(b.im)));
                let strongest = (0..8).max_by(|&a, &b| power[a].total_cmp(&power[b])).unwrap();
                // at the very edge two neighbours are alike
                assert!(strongest == range || (inside == 0.0 && strongest + 1 == range), "{bin}: {power:?}");
            }
        }
    }
}

#[test]
fn references_are_the_windowed_sums_of_bins() {
    for config in [RadarConfig::BGT60, RadarConfig::IWR] {
        let gate = config.gate.unwrap();
        let mut table = vec![[0; 2]; config.reference_len()];
        FastTime::new(config, &mut table).unwrap();
        let l = f64::from(config.samples);
        for (at, sample) in table.iter().enumerate() {
            let (range, n) = (at / usize::from(config.samples), at % usize::from(config.samples));
            let u = (n as f64 + 0.5) / l - 0.5;
            let bins = usize::from(gate.bins_per_sample);
            let first = usize::from(gate.first_bin) + range * bins;
            let hann = 0.5 + 0.5 * (core::f64::consts::TAU * u).cos();
            let phases: Vec<f64> =
                (first..first + bins).map(|k| core::f64::consts::TAU * k as f64 * u).collect();
            let sum =
                |f: fn(f64) -> f64| phases.iter().map(|&p| f(p)).sum::<f64>() * hann / bins as f64 * 32767.0;
            assert!((f64::from(sample[0]) - sum(f64::cos)).abs() < 0.51, "{range}, {n}");
            assert!((f64::from(sample[1]) - sum(f64::sin)).abs() < 0.51, "{range}, {n}");
        }
        for reference in table.chunks_exact(usize::from(config.samples)) {
            let sum: f64 = reference.iter().map(|s| f64::from(s[0]).hypot(f64::from(s[1]))).sum();
            assert!(sum <= 32768.0 * l / 2.0 * 1.01, "the bound that the shift stands on: {sum}");
        }
    }
}

#[test]
fn blocks_of_a_sweep_that_the_sensor_dechirps_are_summed_and_conjugated() {
    let config = RadarConfig { dechirp: Dechirp::Analog, ..RadarConfig::PAPER };
    let blocks = FastTime::new(config, &mut []).unwrap();
    let slot: Vec<i16> = (0..1000).flat_map(|n| [3 * n - 700, 900 - 2 * n]).collect();
    for (k, value) in blocks.beat(&slot).unwrap().iter().enumerate() {
        let part = || (125 * k as i32..).take(125);
        let (re, im): (i32, i32) = (part().map(|n| 3 * n - 700).sum(), part().map(|n| 900 - 2 * n).sum());
        assert_eq!((value.re, value.im), (re, -im), "block {k}");
    }
}

#[test]
fn a_doppler_sensors_sample_is_its_range_sample() {
    let one = FastTime::new(RadarConfig::DOPPLER, &mut []).unwrap();
    let both = FastTime::new(RadarConfig::DOPPLER_IQ, &mut []).unwrap();
    for x in [i16::MIN, -1, 0, 1, 300, i16::MAX] {
        let [first, rest @ ..] = one.beat(&[x]).unwrap();
        assert_eq!((first.re, first.im), (i32::from(x), 0));
        assert!(rest.iter().all(|z| (z.re, z.im) == (0, 0)));
        let first = both.beat(&[x, -7]).unwrap()[0];
        assert_eq!((first.re, first.im), (i32::from(x), 7));
        assert!(one.beat(&[x, x]).is_none() && one.beat(&[]).is_none() && both.beat(&[x]).is_none());
    }
    // blocks of a real converter's samples
    let blocks = RadarConfig { samples: 6, range_samples: 3, ..RadarConfig::DOPPLER };
    let found = FastTime::new(blocks, &mut []).unwrap().beat(&[1, 2, 3, 4, 5, 6]).unwrap();
    assert_eq!(found.map(|z| z.re), [3, 7, 11, 0, 0, 0, 0, 0]);
}
