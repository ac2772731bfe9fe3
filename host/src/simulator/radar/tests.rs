//! The receiver without a front end's effects.

use super::*;
use crate::formats::slots::Slots;
use crate::scenario::builtin::named;
use crate::scenario::{FrontEnd, SPEED_OF_LIGHT};
use crate::simulator::channel::{carrier_phase, wavelength};

fn shipped(name: &str) -> Scenario {
    let mut scenario = named(name.as_ref()).unwrap().scenario();
    scenario.radar.front_end = FrontEnd::Ideal;
    scenario
}

/// A receiver of this scenario with an LSB of 0.1 mW^0.5 and no noise.
fn quiet(scenario: &Scenario) -> Receiver<'_> {
    let mut receiver = Receiver::new(scenario, |_| Random::new(0, 0, 0, 0));
    (receiver.converter.lsb, receiver.converter.noise_lsb) = (1e-4, 0.0);
    receiver
}

fn path(gain: Complex64, delay_s: f64) -> Path {
    Path { gain, delay_s, departure: [1.0, 0.0, 0.0], arrival: [1.0, 0.0, 0.0] }
}

/// A path there and back over a distance, with its carrier phase.
fn echo(scenario: &Scenario, amplitude: f64, distance_m: f64) -> Path {
    let lambda = wavelength(scenario.radar.carrier_hz);
    path(carrier_phase(2.0 * distance_m, lambda) * amplitude, 2.0 * distance_m / SPEED_OF_LIGHT)
}

/// Largest error of the interpolation against the exact sum, relative to the echo, over the samples.
fn error(delay: f64) -> f64 {
    let nodes = Sweeps::default().sum(std::iter::once((Complex64::new(1.0, 0.0), delay)));
    let (mut re, mut im) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES]);
    interpolation::interpolate(&nodes, &mut re, &mut im);
    let errors = re.into_iter().zip(im).enumerate().map(|(n, (re, im))| {
        let z = Complex64::new(re, im);
        let t = (n + 1) as f64 / SAMPLE_RATE;
        (z - phasor(PI * 1e11 * delay * delay - 2.0 * PI * 1e11 * delay * t)).norm()
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn interpolation_holds_delays_to_160_db() {
    for delay in [0.0, 0.3e-9, 13.4e-9, 60e-9, 110e-9] {
        assert!(error(delay) < 1e-8, "{delay}: {:e}", error(delay));
    }
    // 190 ns: a corner path of the largest room, 20 m
    assert!(error(190e-9) < 1e-5, "{:e}", error(190e-9));
}

#[test]
fn a_slot_is_the_delayed_chirp_itself() {
    // two echoes far above the noise, summed sample by sample at t - tau; the paper's sweep and one of 40 MHz
    let mut wide = shipped("conference-room");
    let r = &mut wide.radar;
    (r.bandwidth_hz, r.sample_rate_hz, r.sweep_s, r.samples) = (40e6, 40e6, 40e-6, 1600);
    wide.check("test").unwrap();
    for scenario in [shipped("conference-room"), wide] {
        let rate = scenario.radar.sweep_rate();
        let echoes = [(0.9, 21.37e-9), (1.3, 6.671e-9)];
        let paths = echoes.map(|(a, tau)| path(Complex64::new(a, 0.0), tau));
        let mut values = Vec::new();
        quiet(&scenario).slot(&paths, &mut values);
        assert_eq!(values.len(), 2 * usize::from(scenario.radar.samples));
        for (n, sample) in values.chunks(2).enumerate() {
            let t = (n + 1) as f64 / scenario.radar.sample_rate_hz;
            let exact: Complex64 =
                echoes.iter().map(|&(a, tau)| phasor(PI * rate * (t - tau) * (t - tau)) * (a / 1e-4)).sum();
            assert!((f64::from(sample[0]) - exact.re).abs() < 0.501, "{n}");
            assert!((f64::from(sample[1]) - exact.im).abs() < 0.501, "{n}");
        }
    }
}

#[test]
fn a_dechirping_sensor_delivers_the_product_of_sent_and_received_sweep() {
    for name in ["bgt60", "iwr"] {
        let scenario = shipped(name);
        let radar = &scenario.radar;
        let mut values = Vec::new();
        let echoes = [echo(&scenario, 0.11, 1.234), echo(&scenario, 0.07, 3.3)];
        quiet(&scenario).slot(&echoes, &mut values);
        // the phase of a sweep that begins at the carrier, in turns, of which whole ones do not count
        let sweep = |t: f64| radar.carrier_hz * t + 0.5 * radar.sweep_rate() * t * t;
        let step = if radar.format == Format::Real { 1 } else { 2 };
        for (n, sample) in values.chunks(step).enumerate() {
            let t = n as f64 / radar.sample_rate_hz;
            let turns = |path: &Path| sweep(t) - sweep(t - path.delay_s);
            let exact: Complex64 =
                echoes.iter().map(|p| phasor(2.0 * PI * turns(p).fract()) * (p.gain.norm() / 1e-4)).sum();
            assert!((f64::from(sample[0]) - exact.re).abs() < 0.52, "{name} {n}: {} {exact}", sample[0]);
            if let Some(q) = sample.get(1) {
                assert!((f64::from(*q) - exact.im).abs() < 0.52, "{name} {n}: {q} {exact}");
            }
        }
    }
}

/// Range samples that the core makes of slots.
fn range_samples(scenario: &Scenario, slots: &[Vec<Path>]) -> Vec<Beat> {
    let config = scenario.radar.config();
    let mut receiver = quiet(scenario);
    let mut raw = Slots::with_capacity(config.values_per_slot(), slots.len());
    slots.iter().for_each(|paths| receiver.slot(paths, &mut raw.values));
    raw.beats(config).unwrap()
}

fn power(z: &sdp3_core::dims::Complex<i32>) -> f64 {
    f64::from(z.re).powi(2) + f64::from(z.im).powi(2)
}

#[test]
fn echoes_land_in_the_range_sample_that_covers_their_distance() {
    for name in ["bgt60", "iwr"] {
        let scenario = shipped(name);
        let r = &scenario.radar;
        let bin_m = SPEED_OF_LIGHT / (2.0 * r.bandwidth_hz);
        for range in 0..usize::from(r.range_samples) {
            let first = f64::from(r.first_bin) + f64::from(r.bins_per_sample) * range as f64 - 0.5;
            for inside in [0.1, 0.5, 0.9] {
                let distance = bin_m * (first + inside * f64::from(r.bins_per_sample));
                let beat = range_samples(&scenario, &[vec![echo(&scenario, 0.1, distance)]]);
                let powers = beat[0].map(|z| power(&z));
                let strongest = (0..8).max_by(|&a, &b| powers[a].total_cmp(&powers[b]));
                assert_eq!(strongest, Some(range), "{name}, {distance} m: {powers:?}");
                // two samples further there is nothing left of it
                let far =
                    (0..8).filter(|k: &usize| k.abs_diff(range) >= 2).map(|k| powers[k]).fold(0.0, f64::max);
                assert!(far < 1e-3 * powers[range], "{name}, {distance} m: {powers:?}");
            }
        }
        let gate = bin_m * f64::from(r.first_bin)
            ..bin_m * (f64::from(r.first_bin) + f64::from(r.bins_per_sample) * f64::from(r.range_samples));
        assert!(gate.start < 0.95 && gate.end > 5.6, "{name}: {gate:?}");
    }
}

#[test]
fn who_comes_nearer_turns_forwards_at_the_doppler_frequency() {
    // 1 m/s towards the radar: every kind of radar; the shift belongs to its centre frequency
    let mut blocks = shipped("iwr");
    (blocks.radar.bins_per_sample, blocks.radar.first_bin) = (0, 0);
    for scenario in [shipped("conference-room"), shipped("bgt60"), shipped("iwr"), blocks] {
        scenario.check("test").unwrap();
        let interval = scenario.interval_s();
        let slots: Vec<_> =
            (0..50).map(|n| vec![echo(&scenario, 0.1, 2.5 - f64::from(n) * interval)]).collect();
        let beats = range_samples(&scenario, &slots);
        let strongest = (0..8).max_by(|&a, &b| power(&beats[0][a]).total_cmp(&power(&beats[0][b]))).unwrap();
        let z: Vec<_> =
            beats.iter().map(|b| Complex64::new(b[strongest].re.into(), b[strongest].im.into())).collect();
        let turned: f64 = z.windows(2).map(|pair| (pair[1] / pair[0]).arg()).sum();
        let doppler_hz = turned / (49.0 * interval * 2.0 * PI);
        let centre = scenario.radar.centre_hz();
        let exact = 2.0 * centre / SPEED_OF_LIGHT;
        // blocks see their own part of the sweep instead of its centre
        let within =
            if scenario.radar.bins_per_sample > 0 { 2e-3 } else { scenario.radar.bandwidth_hz / centre };
        assert!((doppler_hz / exact - 1.0).abs() < within, "{}: {doppler_hz} Hz of {exact}", scenario.name);
    }
}

#[test]
fn echoes_fade_by_the_radar_equation_and_real_samples_have_half_the_amplitude() {
    for name in ["bgt60", "iwr"] {
        let scenario = shipped(name);
        let r = &scenario.radar;
        let config = r.config();
        let centre = |range: u16| {
            let bins = f64::from(r.bins_per_sample);
            let bin = f64::from(r.first_bin) + bins * f64::from(range) + 0.5 * (bins - 1.0);
            bin * SPEED_OF_LIGHT / (2.0 * r.bandwidth_hz)
        };
        // a sphere of 1 m^2: amplitude lambda / ((4 pi)^1.5 D^2) of the sent one, here of 3000 sqrt W
        let lambda = wavelength(r.carrier_hz);
        let amplitude = |d: f64| 3000.0 * lambda / (libm::pow(4.0 * PI, 1.5) * d * d);
        for range in [1, 4, 6] {
            let d = centre(range);
            let beat = range_samples(&scenario, &[vec![echo(&scenario, amplitude(d), d)]]);
            let found = power(&beat[0][usize::from(range)]).sqrt();
            // Hann's window has half of the sum; g of its bins, here from the middle of a cell, add to one
            let half = if r.format == Format::Real { 0.5 } else { 1.0 };
            let bins = f64::from(r.bins_per_sample);
            let hann = |x: f64| 0.5 * libm::sin(PI * x) / (PI * x) / (1.0 - x * x);
            let flat: f64 = (0..r.bins_per_sample).map(|k| hann(f64::from(k) - 0.5 * (bins - 1.0))).sum();
            let whole = half * flat * amplitude(d) / 1e-4 * 32767.0 * f64::from(r.samples) / bins;
            let exact = whole / libm::exp2(f64::from(config.shift()));
            assert!((found / exact - 1.0).abs() < 0.005, "{name} {range}: {found} {exact}");
        }
    }
}

#[test]
fn thermal_noise_is_minus_94_dbm_at_10_db_noise_figure() {
    let scenario = shipped("conference-room");
    let converter = Converter::of(&scenario);
    let power = 2.0 * (converter.noise_lsb * converter.lsb) * (converter.noise_lsb * converter.lsb);
    // k T B F = -174 dBm/Hz + 70 dB + 10 dB
    let dbm = 10.0 * libm::log10(power * 1e3);
    assert!((dbm + 93.98).abs() < 0.02, "{dbm}");
    // k T f_s F at 2 MHz and 12 dB
    let converter = Converter::of(&shipped("bgt60"));
    let power = 2.0 * (converter.noise_lsb * converter.lsb) * (converter.noise_lsb * converter.lsb);
    let dbm = 10.0 * libm::log10(power * 1e3);
    assert!((dbm + 98.97).abs() < 0.02, "{dbm}");
}

#[test]
fn the_converter_rounds_saturates_and_justifies() {
    let converted = |bits, left_justified| {
        let mut scenario = shipped("conference-room");
        (scenario.radar.converter_bits, scenario.radar.left_justified) = (bits, left_justified);
        let converter = Converter::of(&scenario);
        [0.4, 0.6, -0.6, 1e9, -1e9].map(|x| converter.convert(x))
    };
    assert_eq!(converted(16, false), [0, 1, -1, 32767, -32768]);
    assert_eq!(converted(12, false), [0, 1, -1, 2047, -2048]);
    assert_eq!(converted(12, true), [0, 16, -16, 32752, -32768]);
    assert_eq!(converted(16, true), converted(16, false));
}
