//! From the channel to raw slots: sweep, thermal noise, impairments, converter.
//!
//! r_j = h_j * s + n_j (eq. (rt)), as values of the converter. Digital dechirp: the received chirp at t = n / f_s, n = 1 to L. Analog
//! dechirp: the beat at t = n / f_s, n = 0..L, of the sent sweep with the conjugate of the received, so that the range grows with
//! the frequency; real samples are its real part. Delays are exact, never a shift by whole samples, and constant during a sweep
//! ([`super::channel::response`]). Noise has the bandwidth of the sampling rate.

use super::channel::response::{Response, Table};
use super::channel::room::expected_power;
use super::channel::{BLOCKS, Blocks, Complex64, NODES, Path, SWEEP_S, Sweep, accumulate, phasor, tone};
use crate::numerics::random::Random;
use crate::scenario::{Dechirp, Format, Radar, Scenario};
use sdp3_core::config::RadarConfig;
use sdp3_core::dims::{BEATS, Beat, ZERO_BEAT};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Boltzmann's constant times 290 K in W/Hz.
pub const KT: f64 = 1.380_649e-23 * 290.0;

/// Samples, sampling rate in Hz and block of the paper's radar.
const SAMPLES: usize = RadarConfig::PAPER.samples as usize;
const SAMPLE_RATE: f64 = 10e6;
const BLOCK_SAMPLES: usize = SAMPLES / BEATS;

/// The paper's chirp of amplitude 1, `[fast_time]`.
static CHIRP: LazyLock<Vec<Complex64>> = LazyLock::new(|| chirp(SAMPLES));

/// A chirp of a bandwidth equal to its sampling rate, at t = n / f_s, n = 1 to L.
fn chirp(samples: usize) -> Vec<Complex64> {
    let l = samples as u64;
    (1..=l).map(|n| phasor(PI * ((n * n) % (2 * l)) as f64 / l as f64)).collect()
}

/// Values of the Lagrange polynomials of the nodes at the samples, `[fast_time][node]`.
static INTERPOLATION: LazyLock<Vec<[f64; NODES]>> = LazyLock::new(|| {
    let node = |k: usize| (PI * (k as f64 + 0.5) / NODES as f64, k);
    (1..=SAMPLES)
        .map(|n| {
            let x = 1.0 - 2.0 * (n as f64 / SAMPLE_RATE) / SWEEP_S;
            let x = libm::acos(x.clamp(-1.0, 1.0));
            // discrete cosine synthesis: sum over degrees of T_d(x) T_d(x_k)
            std::array::from_fn(|k| {
                let (angle, _) = node(k);
                let sum: f64 =
                    (1..NODES).map(|d| libm::cos(d as f64 * x) * libm::cos(d as f64 * angle)).sum();
                (1.0 + 2.0 * sum) / NODES as f64
            })
        })
        .collect()
});

/// Analog to digital conversion: LSB per sqrt W and noise in LSB.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converter {
    /// Amplitude of one LSB in sqrt W.
    pub lsb: f64,
    /// Standard deviation of the thermal noise of each value in LSB.
    pub noise_lsb: f64,
    /// Largest value in LSB; the smallest is one below its negative.
    largest: f64,
    /// Places by which values are shifted up in their 16 bits.
    shift: u32,
}

impl Converter {
    /// Full scale is `headroom_db` above the loudest that is expected.
    ///
    /// Noise of power k T f_s F is that of both sidebands; I and Q, or the only real value, have half of it each.
    pub fn of(scenario: &Scenario) -> Self {
        let radar = &scenario.radar;
        let front = radar.power_w.sqrt() * libm::pow(10.0, radar.antenna_gain_db / 10.0);
        let full_scale = front * expected_power(scenario).sqrt() * libm::pow(10.0, radar.headroom_db / 20.0);
        let bits = u32::from(radar.converter_bits);
        let largest = f64::from((1_u32 << (bits - 1)) - 1);
        let lsb = full_scale / largest;
        let figure = libm::pow(10.0, scenario.radar.noise_figure_db / 10.0);
        let noise = (KT * radar.sample_rate_hz * figure / 2.0).sqrt();
        let shift = if radar.left_justified { 16 - bits } else { 0 };
        Converter { lsb, noise_lsb: noise / lsb, largest, shift }
    }

    /// Nearest integer (halves to even), saturated to the converter's range and justified.
    fn convert(&self, x: f64) -> i16 {
        const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
        ((x.clamp(-1.0 - self.largest, self.largest) + MAGIC - MAGIC) as i16) << self.shift
    }
}

/// Mean over each block of conj(s)^2: what dechirping leaves of a mirrored signal.
static IMAGE: LazyLock<Blocks> = LazyLock::new(|| {
    let block = |b: usize| CHIRP[b * BLOCK_SAMPLES..(b + 1) * BLOCK_SAMPLES].iter();
    std::array::from_fn::<_, BLOCKS, _>(|b| {
        block(b).map(|s| (s * s).conj()).sum::<Complex64>() / BLOCK_SAMPLES as f64
    })
});

/// Nearest integer, halves to even.
fn round(x: f64) -> i32 {
    const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
    (x + MAGIC - MAGIC) as i32
}

/// What real front ends add: the oscillator's phase from slot to slot, and I and Q that are neither equal nor in quadrature.
///
/// Q' = g (Q cos phi + I sin phi) turns x into a x + b conj(x) with a = (1 + g e^(j phi)) / 2 and b = (1 - g e^(-j phi)) / 2.
#[derive(Debug, Clone)]
struct Impairments {
    phase_rad: f64,
    direct: Complex64,
    image: Complex64,
    random: Random,
}

impl Impairments {
    /// Of a radar; `random` draws the phases.
    fn new(radar: &Radar, random: Random) -> Self {
        let gain = libm::pow(10.0, radar.iq_gain_db / 20.0);
        let phase = radar.iq_phase_deg * PI / 180.0;
        Impairments {
            phase_rad: radar.phase_noise_deg * PI / 180.0,
            direct: (phasor(phase) * gain + 1.0) / 2.0,
            image: (-phasor(-phase) * gain + 1.0) / 2.0,
            random,
        }
    }

    /// The oscillator's phase in the next slot.
    fn turn(&mut self) -> Complex64 {
        if self.phase_rad == 0.0 {
            Complex64::new(1.0, 0.0)
        } else {
            phasor(self.phase_rad * self.random.gaussian())
        }
    }
}

/// The radar's receiver: front end and converter, slot after slot.
pub struct Receiver<'a> {
    radar: &'a Radar,
    converter: Converter,
    response: Response,
    impairments: Impairments,
    random: Random,
    /// Of a radar with digital dechirp that is not the paper's.
    chirp: Vec<Complex64>,
    re: Vec<f64>,
    im: Vec<f64>,
}

impl<'a> Receiver<'a> {
    /// Of a scenario's radar; `random` draws its noise, `phases` the oscillator's phases.
    pub fn new(scenario: &'a Scenario, phases: Random, random: Random) -> Self {
        let radar = &scenario.radar;
        let samples = usize::from(radar.samples);
        let response = Response::of(radar);
        let own = matches!((&response, radar.dechirp), (Response::Table(_), Dechirp::Digital));
        Receiver {
            converter: Converter::of(scenario),
            impairments: Impairments::new(radar, phases),
            random,
            chirp: if own { chirp(samples) } else { Vec::new() },
            re: vec![0.0; samples],
            im: vec![0.0; samples],
            response,
            radar,
        }
    }

    /// What the core makes of a slot with these range samples: its integers, the noise and that of the converter's rounding.
    ///
    /// Left out with a sensor that dechirps: saturation, and the mirrored frequencies that unequal I and Q or a wandering phase of
    /// real samples leave in the gate, -70 dB of the loudest echo from the sixth bin on.
    pub fn beat(&mut self, blocks: &Blocks) -> Beat {
        let turn = self.impairments.turn();
        match &self.response {
            Response::Paper => self.block_means(blocks, turn),
            Response::Table(table) => Self::range_samples(
                &self.converter,
                table,
                blocks,
                match self.radar.dechirp {
                    Dechirp::Digital => turn * self.impairments.direct,
                    Dechirp::Analog => (turn * self.impairments.direct).conj(),
                },
                &mut self.random,
            ),
        }
    }

    fn block_means(&mut self, blocks: &Blocks, turn: Complex64) -> Beat {
        let Converter { lsb, noise_lsb, .. } = self.converter;
        let scale = BLOCK_SAMPLES as f64 * 32767.0 / f64::from(1_u32 << RadarConfig::PAPER.shift());
        let noise = ((noise_lsb * noise_lsb + 1.0 / 12.0) / BLOCK_SAMPLES as f64).sqrt();
        let mut beat = ZERO_BEAT;
        for ((out, z), image) in beat.iter_mut().zip(blocks).zip(IMAGE.iter()) {
            let z = z * turn / lsb;
            let z = self.impairments.direct * z + self.impairments.image * (z.conj() * image);
            out.re = round((z.re + noise * self.random.gaussian()) * scale);
            out.im = round((z.im + noise * self.random.gaussian()) * scale);
        }
        beat
    }

    fn range_samples(
        converter: &Converter,
        table: &Table,
        blocks: &Blocks,
        front: Complex64,
        random: &mut Random,
    ) -> Beat {
        let noise = (converter.noise_lsb * converter.noise_lsb + 1.0 / 12.0).sqrt();
        let drawn = table.noise(|| random.gaussian());
        let mut beat = ZERO_BEAT;
        for ((out, z), drawn) in beat.iter_mut().zip(blocks).zip(drawn) {
            let z = z * front / converter.lsb + drawn * noise;
            (out.re, out.im) = (round(z.re), round(z.im));
        }
        beat
    }

    /// Appends one raw slot: the values that the sensor delivers of these paths, amplitudes in sqrt W.
    pub fn slot(&mut self, paths: &[Path], values: &mut Vec<i16>) {
        let turn = self.impairments.turn();
        let (direct, image) = (self.impairments.direct, self.impairments.image);
        let Receiver { radar, converter, random, re, im, .. } = self;
        let mut complex = |z: Complex64| {
            let z = direct * z + image * z.conj();
            values.push(converter.convert(z.re + converter.noise_lsb * random.gaussian()));
            values.push(converter.convert(z.im + converter.noise_lsb * random.gaussian()));
        };
        if matches!(self.response, Response::Paper) {
            let mut sweep = Sweep::default();
            paths.iter().for_each(|path| accumulate(&mut sweep, &tone(path.gain, path.delay_s)));
            let scaled: Sweep = sweep.map(|z| z * turn / converter.lsb);
            for (row, chirp) in INTERPOLATION.iter().zip(CHIRP.iter()) {
                let (mut re, mut im) = (0.0, 0.0);
                for (w, z) in row.iter().zip(&scaled) {
                    re += w * z.re;
                    im += w * z.im;
                }
                complex(Complex64::new(re, im) * chirp);
            }
            return;
        }
        beat(paths, radar, re, im);
        let beat = re.iter().zip(im.iter()).map(|(&re, &im)| Complex64::new(re, im));
        match (radar.dechirp, radar.format) {
            (Dechirp::Digital, _) => {
                beat.zip(&self.chirp).for_each(|(z, s)| complex(z * turn / converter.lsb * s))
            }
            (Dechirp::Analog, Format::Complex) => beat.for_each(|z| complex(z.conj() * turn / converter.lsb)),
            (Dechirp::Analog, Format::Real) => beat.for_each(|z| {
                let x = (z.conj() * turn / converter.lsb).re;
                values.push(converter.convert(x + converter.noise_lsb * random.gaussian()));
            }),
        }
    }
}

const LANES: usize = 8;

/// The beat of received times conjugate sent sweep at the samples, path by path, every path a phasor that turns:
/// `gain exp(j pi S tau^2 - 2 pi j S tau t)`.
fn beat(paths: &[Path], radar: &Radar, re: &mut [f64], im: &mut [f64]) {
    re.fill(0.0);
    im.fill(0.0);
    let first = if radar.dechirp == Dechirp::Digital { 1.0 } else { 0.0 };
    for path in paths {
        // turns of a sample
        let step = radar.bandwidth_hz * path.delay_s / f64::from(radar.samples);
        let start = path.gain * phasor(PI * radar.sweep_rate() * path.delay_s * path.delay_s);
        let lanes: [_; LANES] =
            std::array::from_fn(|k| start * phasor(-2.0 * PI * step * (k as f64 + first)));
        let (mut a, mut b) = (lanes.map(|z| z.re), lanes.map(|z| z.im));
        let turn = phasor(-2.0 * PI * step * LANES as f64);
        for (re, im) in re.chunks_mut(LANES).zip(im.chunks_mut(LANES)) {
            re.iter_mut().zip(&a).for_each(|(sum, a)| *sum += a);
            im.iter_mut().zip(&b).for_each(|(sum, b)| *sum += b);
            for (a, b) in a.iter_mut().zip(&mut b) {
                (*a, *b) = (*a * turn.re - *b * turn.im, *a * turn.im + *b * turn.re);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::slots::Slots;
    use crate::scenario::SPEED_OF_LIGHT;
    use crate::scenario::builtin::named;
    use crate::simulator::channel::{carrier_phase, wavelength};

    fn shipped(name: &str) -> Scenario {
        named(name.as_ref()).unwrap().scenario()
    }

    /// A receiver of this scenario with an LSB of 0.1 mW^0.5 and no noise.
    fn quiet(scenario: &Scenario) -> Receiver<'_> {
        let random = Random::new(0, 0, 0, 0);
        let mut receiver = Receiver::new(scenario, random.clone(), random);
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
        let nodes = tone(Complex64::new(1.0, 0.0), delay);
        let errors = INTERPOLATION.iter().enumerate().map(|(n, row)| {
            let z: Complex64 = row.iter().zip(&nodes).map(|(w, z)| z * w).sum();
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
        let mut wide = Scenario::default();
        let r = &mut wide.radar;
        (r.bandwidth_hz, r.sample_rate_hz, r.sweep_s, r.samples) = (40e6, 40e6, 40e-6, 1600);
        wide.check("test").unwrap();
        for scenario in [Scenario::default(), wide] {
            let rate = scenario.radar.sweep_rate();
            let echoes = [(0.9, 21.37e-9), (1.3, 6.671e-9)];
            let paths = echoes.map(|(a, tau)| path(Complex64::new(a, 0.0), tau));
            let mut values = Vec::new();
            quiet(&scenario).slot(&paths, &mut values);
            assert_eq!(values.len(), 2 * usize::from(scenario.radar.samples));
            for (n, sample) in values.chunks(2).enumerate() {
                let t = (n + 1) as f64 / scenario.radar.sample_rate_hz;
                let exact: Complex64 = echoes
                    .iter()
                    .map(|&(a, tau)| phasor(PI * rate * (t - tau) * (t - tau)) * (a / 1e-4))
                    .sum();
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
                    let far = (0..8)
                        .filter(|k: &usize| k.abs_diff(range) >= 2)
                        .map(|k| powers[k])
                        .fold(0.0, f64::max);
                    assert!(far < 1e-3 * powers[range], "{name}, {distance} m: {powers:?}");
                }
            }
            let gate = bin_m * f64::from(r.first_bin)
                ..bin_m
                    * (f64::from(r.first_bin) + f64::from(r.bins_per_sample) * f64::from(r.range_samples));
            assert!(gate.start < 0.95 && gate.end > 5.6, "{name}: {gate:?}");
        }
    }

    #[test]
    fn who_comes_nearer_turns_forwards_at_the_doppler_frequency() {
        // 1 m/s towards the radar: every kind of radar; the shift belongs to its centre frequency
        let mut blocks = shipped("iwr");
        (blocks.radar.bins_per_sample, blocks.radar.first_bin) = (0, 0);
        for scenario in [Scenario::default(), shipped("bgt60"), shipped("iwr"), blocks] {
            scenario.check("test").unwrap();
            let interval = scenario.interval_s();
            let slots: Vec<_> =
                (0..50).map(|n| vec![echo(&scenario, 0.1, 2.5 - f64::from(n) * interval)]).collect();
            let beats = range_samples(&scenario, &slots);
            let strongest =
                (0..8).max_by(|&a, &b| power(&beats[0][a]).total_cmp(&power(&beats[0][b]))).unwrap();
            let z: Vec<_> = beats
                .iter()
                .map(|b| Complex64::new(b[strongest].re.into(), b[strongest].im.into()))
                .collect();
            let turned: f64 = z.windows(2).map(|pair| (pair[1] / pair[0]).arg()).sum();
            let doppler_hz = turned / (49.0 * interval * 2.0 * PI);
            let centre = scenario.radar.centre_hz();
            let exact = 2.0 * centre / SPEED_OF_LIGHT;
            // blocks see their own part of the sweep instead of its centre
            let within =
                if scenario.radar.bins_per_sample > 0 { 2e-3 } else { scenario.radar.bandwidth_hz / centre };
            assert!(
                (doppler_hz / exact - 1.0).abs() < within,
                "{}: {doppler_hz} Hz of {exact}",
                scenario.name
            );
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
        let scenario = Scenario::default();
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
            let mut scenario = Scenario::default();
            (scenario.radar.converter_bits, scenario.radar.left_justified) = (bits, left_justified);
            let converter = Converter::of(&scenario);
            [0.4, 0.6, -0.6, 1e9, -1e9].map(|x| converter.convert(x))
        };
        assert_eq!(converted(16, false), [0, 1, -1, 32767, -32768]);
        assert_eq!(converted(12, false), [0, 1, -1, 2047, -2048]);
        assert_eq!(converted(12, true), [0, 16, -16, 32752, -32768]);
        assert_eq!(converted(16, true), converted(16, false));
    }
}
