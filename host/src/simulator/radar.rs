//! From the channel to raw slots: sweep, thermal noise, impairments, converter.
//!
//! r_j = h_j * s + n_j (eq. (rt)), as values of the converter. Digital dechirp: the received chirp at t = n / f_s, n = 1..=L. Analog
//! dechirp: the beat at t = n / f_s, n = 0..L, of the sent sweep with the conjugate of the received, so that the range grows with
//! the frequency; real samples are its real part. Delays are exact, never a shift by whole samples, and constant during a sweep
//! ([`super::channel::response`]). Noise has the bandwidth of the sampling rate.

use super::channel::response::{Response, Table};
use super::channel::room::mean_power;
use super::channel::{BLOCKS, Blocks, Complex64, NODES, Path, SWEEP_S, Sweep, accumulate, phasor, tone};
use super::random::Random;
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

/// A chirp whose bandwidth is its sampling rate, at t = n / f_s, n = 1..=L.
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
    /// Full scale is `headroom_db` above the room's mean received amplitude.
    ///
    /// Noise of power k T f_s F is that of both sidebands; I and Q, or the only real value, have half of it each.
    pub fn of(scenario: &Scenario) -> Self {
        let radar = &scenario.radar;
        let front = radar.power_w.sqrt() * libm::pow(10.0, radar.antenna_gain_db / 10.0);
        let full_scale = front * mean_power(scenario).sqrt() * libm::pow(10.0, radar.headroom_db / 20.0);
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

    /// Appends one raw slot: the values that the sensor delivers of these paths, whose amplitudes are in sqrt W.
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
            (Dechirp::Digital, _) => beat.zip(&self.chirp).for_each(|(z, s)| complex(z * turn / converter.lsb * s)),
            (Dechirp::Analog, Format::Complex) => beat.for_each(|z| complex(z.conj() * turn / converter.lsb)),
            (Dechirp::Analog, Format::Real) => beat.for_each(|z| {
                let x = (z.conj() * turn / converter.lsb).re;
                values.push(converter.convert(x + converter.noise_lsb * random.gaussian()));
            }),
        }
    }
}

/// Lanes of [`beat`].
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
        let lanes: [_; LANES] = std::array::from_fn(|k| start * phasor(-2.0 * PI * step * (k as f64 + first)));
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
