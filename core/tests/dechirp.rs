//! Echoes through dechirp and on to the image: a delay is a slope of the beat's phase, an approach a positive Doppler frequency.
//!
//! Oracle: the sums of the sampled complex exponentials in closed form.

mod support;

use core::f64::consts::{PI, TAU};
use sdp3_core::config::{RadarConfig, SampleFormat};
use sdp3_core::dims::{BEATS, Complex, ROWS};
use sdp3_core::signal::clutter::SvdRange;
use sdp3_core::signal::fast_time::FastTime;
use sdp3_core::signal::front_end::{FrontEnd, Preprocessing};
use sdp3_core::signal::stft::{FixedStft, FloatStft, Stft};
use sdp3_testkit::signals::{Echo, beat_echo, beat_echo_real, chirp_echo};
use support::{Memory, VALUES};

/// A slot of these echoes.
fn received(echoes: &[Echo], number: u32) -> [i16; VALUES] {
    let mut samples = [0; VALUES];
    chirp_echo(echoes, number, &mut samples);
    samples
}

/// What dechirp makes of their first slot.
fn beats(echoes: &[Echo]) -> [Complex<f64>; BEATS] {
    let fast_time = FastTime::new(RadarConfig::PAPER, &mut []).expect("no reference in memory");
    let beat = fast_time.beat(&received(echoes, 0)).expect("a slot");
    beat.map(|value| Complex::new(value.re.into(), value.im.into()))
}

/// Beat `k` of a static echo: the sum of a exp(j pi ((n - d)^2 - n^2) / 1000) over n = 125 k + 1 ..= 125 k + 125, times the chirp's
/// amplitude 32767 and 2^-12.
fn beat(amplitude: f64, delay: f64, k: usize) -> Complex<f64> {
    // exp(j pi d^2 / 1000) exp(-j 2 pi d n / 1000): a geometric series about its middle, n = 125 k + 63
    let step = PI * delay / 1000.0;
    let series = if delay == 0.0 { 125.0 } else { (125.0 * step).sin() / step.sin() };
    let phase = step * delay - 2.0 * step * (125 * k + 63) as f64;
    Complex::new(phase.cos(), phase.sin()) * (amplitude * series * 32767.0 / 4096.0)
}

#[test]
fn a_delayed_echo_is_the_beat_of_its_range() {
    for delay in [0.0, 0.05, 0.4, 1.0, 1.7, 2.5, 3.9, -0.4] {
        for amplitude in [300.0, 30_000.0] {
            let found = beats(&[Echo { amplitude, delay, ..Echo::default() }]);
            for (k, value) in found.iter().enumerate() {
                let exact = beat(amplitude, delay, k);
                let error = (value - exact).norm_sqr().sqrt();
                // 125 samples and chirp values off by at most half an LSB each in I and in Q
                let bound = 125.0 * (32767.0 + amplitude) * 0.5_f64.hypot(0.5) / 4096.0;
                assert!(error < bound, "delay {delay}, amplitude {amplitude}, beat {k}: off by {error}");
            }
            // a range cell is an eighth of a turn from one beat to the next
            let turns = |k: usize| {
                let product = found[k + 1] * found[k].conj();
                product.im.atan2(product.re) / TAU
            };
            let cells = -8.0 * (0..7).map(turns).sum::<f64>() / 7.0;
            assert!((cells - delay).abs() < 0.002, "delay {delay}: in range cell {cells}");
        }
    }
}

#[test]
fn echoes_add_up() {
    let near = Echo { amplitude: 8000.0, delay: 0.3, ..Echo::default() };
    let far = Echo { amplitude: 5000.0, delay: 1.6, ..Echo::default() };
    let found = beats(&[near, far]);
    for (k, value) in found.iter().enumerate() {
        let exact = beat(8000.0, 0.3, k) + beat(5000.0, 1.6, k);
        assert!((value - exact).norm_sqr().sqrt() < 1000.0, "beat {k}: {value}, not {exact}");
    }
}

/// The image of 144 slots of a sensor, `[64, 3]`, without the strongest component unless `clutter` is to stay.
fn image<T: Stft>(config: RadarConfig, echoes: &[Echo], clutter: bool, bins_per_row: u8) -> Vec<i8> {
    let kept = SvdRange { first: if clutter { 1 } else { 2 }, last: 8 };
    let settings = Preprocessing { kept, bins_per_row, ..Preprocessing::default() };
    let (mut memory, mut reference) = (Memory::of_front_end(144, 3), vec![[0; 2]; config.reference_len()]);
    let mut buffers = memory.view().front_end;
    buffers.reference = &mut reference;
    let mut front_end = FrontEnd::<T>::new(config, settings, buffers).expect("legal");
    let mut slot = vec![0; config.values_per_slot()];
    for n in 0..144 {
        match (config.gate, config.format) {
            (None, _) => chirp_echo(echoes, n, &mut slot),
            (_, SampleFormat::Complex) => beat_echo(echoes, n, &mut slot),
            (_, SampleFormat::Real) => beat_echo_real(echoes, n, &mut slot),
        }
        assert!(front_end.push(&slot, &mut ()));
    }
    front_end.image(&mut ()).expect("three frames").to_vec()
}

/// The brightest row of every frame.
fn rows(image: &[i8]) -> Vec<usize> {
    (0..3).filter_map(|frame| (0..ROWS).max_by_key(|row| image[row * 3 + frame])).collect()
}

const WALL: Echo = Echo { amplitude: 12_000.0, delay: 0.2, doppler: 0.0, delay_step: 0.0 };

/// A target with a Doppler frequency of `bins` 256ths of the slot rate. At 350 wavelengths a range cell (3.5 GHz, 10 MHz) its
/// delay changes with it.
fn target(bins: f64) -> Echo {
    let doppler = bins / 256.0;
    Echo { amplitude: 600.0, delay: 1.3, doppler, delay_step: -doppler / 350.0 }
}

fn doppler_is_in_its_row<T: Stft>() {
    for (bins, bins_per_row, row) in
        [(7.0, 1, 39), (30.0, 1, 62), (-7.0, 1, 25), (-31.0, 1, 1), (40.0, 2, 52), (-90.0, 4, 9)]
    {
        let (paper, echoes) = (RadarConfig::PAPER, [WALL, target(bins)]);
        let found = image::<T>(paper, &echoes, false, bins_per_row);
        assert_eq!(rows(&found), [row; 3], "{bins} bins");
        // the wall, 26 dB above the target, is gone, and nothing is mirrored: a row is 20 dB (102 levels of 50 dB) below
        let mirrored = ROWS - row;
        for dark in [32, mirrored].into_iter().filter(|dark| dark.abs_diff(row) > 5) {
            let level = (0..3).map(|frame| found[dark * 3 + frame]).max().expect("three frames");
            assert!(level < 127 - 102, "{bins} bins: row {dark} has {level}");
        }
        // with the clutter the wall is the brightest
        assert_eq!(
            rows(&image::<T>(paper, &echoes, true, bins_per_row)),
            [32; 3],
            "{bins} bins with the wall"
        );
    }
    // the same sign from sensors that dechirp: a wall and a target in two of the gate's range samples
    for config in [RadarConfig::BGT60, RadarConfig::IWR] {
        let gate = config.gate.expect("a gate");
        let middle =
            |range: f64| f64::from(gate.first_bin) - 0.5 + (range + 0.5) * f64::from(gate.bins_per_sample);
        for bins in [9.0, -14.0] {
            let wall = Echo { amplitude: 1200.0, delay: middle(6.0), ..Echo::default() };
            let target =
                Echo { amplitude: 300.0, delay: middle(2.0), doppler: bins / 256.0, delay_step: 0.0 };
            let found = image::<T>(config, &[wall, target], false, 1);
            assert_eq!(rows(&found), [(32.0 + bins) as usize; 3], "{config:?}, {bins} bins");
        }
    }
}

#[test]
fn an_approaching_target_is_above_the_middle_row_in_floats() {
    doppler_is_in_its_row::<FloatStft>();
}

#[test]
fn an_approaching_target_is_above_the_middle_row_in_integers() {
    doppler_is_in_its_row::<FixedStft>();
}
