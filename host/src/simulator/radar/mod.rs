//! From the channel to raw slots: sweep, thermal noise, impairments, converter.
//!
//! r_j = h_j * s + n_j (eq. (rt)), as values of the converter. Digital dechirp: the received chirp at t = n / f_s, n = 1 to L. Analog
//! dechirp: the beat at t = n / f_s, n = 0..L, of the sent sweep with the conjugate of the received, so that the range grows with
//! the frequency; real samples are its real part. Delays are exact, never a shift by whole samples, and constant during a sweep
//! ([`super::channel::response`]). Noise has the bandwidth of the sampling rate.
//!
//! A wave meets, in this order: leakage that is added, the amplifier's compression, the oscillator's phase noise, unequal I and Q,
//! an offset, thermal noise (referred to the input by its level), the converter. Each is a field of [`Radar`]; docs/theory.md has the
//! equations. Compression follows phase noise here: it takes magnitudes, which a phase leaves alone.

mod converter;
mod impairments;
mod interpolation;
mod oscillator;
mod range_samples;
mod samples;

use super::channel::response::{Response, Table};
use super::channel::{BLOCKS, Blocks, Complex64, Path, Sweep, Sweeps, phasor};
use crate::numerics::filter::{HighPass, pole};
use crate::numerics::random::Random;
use crate::numerics::vectors::vectorised;
use crate::scenario::{Dechirp, Format, Radar, Scenario};
use converter::round;
pub use converter::{Converter, KT};
use impairments::{Impairments, Limiter};
use interpolation::time_shift;
use oscillator::{Filters, Oscillator};
use range_samples::RangeFrontEnd;
use samples::Samples;
use sdp3_core::config::RadarConfig;
use sdp3_core::dims::{BEATS, Beat, ZERO_BEAT};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Samples, sampling rate in Hz and block of the paper's radar.
const SAMPLES: usize = RadarConfig::PAPER.samples as usize;
const SAMPLE_RATE: f64 = 10e6;
const BLOCK_SAMPLES: usize = SAMPLES / BEATS;

/// Delay of the leakage: 0.3 m of lines and of space between antennas, in s.
const LEAKAGE_DELAY_S: f64 = 1e-9;

/// The paper's chirp of amplitude 1, `[fast_time]`.
static CHIRP: LazyLock<Vec<Complex64>> = LazyLock::new(|| chirp(SAMPLES));

/// Its real and its imaginary parts.
static CHIRP_PARTS: LazyLock<[[f64; SAMPLES]; 2]> = LazyLock::new(|| {
    let part = |of: fn(&Complex64) -> f64| std::array::from_fn(|n| of(&CHIRP[n]));
    [part(|z| z.re), part(|z| z.im)]
});

/// A chirp of a bandwidth equal to its sampling rate, at t = n / f_s, n = 1 to L.
fn chirp(samples: usize) -> Vec<Complex64> {
    let l = samples as u64;
    (1..=l).map(|n| phasor(PI * ((n * n) % (2 * l)) as f64 / l as f64)).collect()
}

/// Mean over each block of conj(s)^2: what dechirping leaves of a mirrored signal.
static IMAGE: LazyLock<Blocks> = LazyLock::new(|| {
    let block = |b: usize| CHIRP[b * BLOCK_SAMPLES..(b + 1) * BLOCK_SAMPLES].iter();
    std::array::from_fn::<_, BLOCKS, _>(|b| {
        block(b).map(|s| (s * s).conj()).sum::<Complex64>() / BLOCK_SAMPLES as f64
    })
});

/// What a receiver draws random numbers for, each from a stream of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Draws {
    /// Thermal noise.
    Noise,
    /// The white phase from slot to slot.
    Phases,
    /// What a recording has throughout: the phases of leakage and offset.
    Module,
    /// The oscillator's phase noise.
    Oscillator,
}

/// Slots of which the range samples are formed together.
const TOGETHER: usize = 32;

/// The radar's receiver: front end and converter, slot after slot.
pub struct Receiver<'a> {
    radar: &'a Radar,
    converter: Converter,
    response: Response,
    impairments: Impairments,
    oscillator: Option<Oscillator>,
    /// The two sections of a Doppler sensor's AC coupling, over slow time.
    ac_coupling: Option<[HighPass<Complex64>; 2]>,
    /// The front end on range samples; none where it adds nothing.
    front_end: Option<RangeFrontEnd>,
    /// The offset in range samples: of the paper's radar in LSB, of others in LSB of range samples.
    offset: Blocks,
    random: Random,
    /// Of a radar with digital dechirp that is not the paper's.
    chirp: Vec<Complex64>,
    sweeps: Sweeps,
    beat: Samples,
    /// Draws of a slot's thermal noise, of the paper's radar.
    noise: Vec<[f64; 2]>,
}

impl<'a> Receiver<'a> {
    /// Of a scenario's radar; `streams` has its random numbers.
    pub fn new(scenario: &'a Scenario, streams: impl Fn(Draws) -> Random) -> Self {
        let radar = &scenario.radar;
        let samples = usize::from(radar.samples);
        let response = Response::of(radar);
        let own = matches!((&response, radar.dechirp), (Response::Table(_), Dechirp::Digital));
        let papers = matches!(response, Response::Paper);
        let effects = radar.effects();
        let converter = Converter::of(scenario);
        let impairments =
            Impairments::new(radar, &effects, &converter, streams(Draws::Phases), streams(Draws::Module));
        let filters = effects.spectrum.map(|spectrum| Filters::new(&spectrum, radar.sample_rate_hz));
        let mut receiver = Receiver {
            oscillator: filters.map(|filters| Oscillator::new(filters, streams(Draws::Oscillator))),
            ac_coupling: (radar.ac_coupling_hz > 0.0).then(|| {
                [(); 2].map(|()| HighPass::new(pole(radar.ac_coupling_hz, 1.0 / scenario.interval_s())))
            }),
            front_end: RangeFrontEnd::of(scenario, &response, &impairments, filters),
            random: streams(Draws::Noise),
            chirp: if own { chirp(samples) } else { Vec::new() },
            sweeps: Sweeps::default(),
            beat: Samples::new(samples, filters.is_some()),
            noise: if papers { vec![[0.0; 2]; samples] } else { Vec::new() },
            offset: Blocks::default(),
            converter,
            impairments,
            response,
            radar,
        };
        receiver.offset = receiver.offset_of_range_samples();
        receiver
    }

    /// What the offset leaves in range samples.
    fn offset_of_range_samples(&self) -> Blocks {
        let offset = self.impairments.offset;
        let mut blocks = Blocks::default();
        if offset == Complex64::default() {
            return blocks;
        }
        match (&self.response, self.radar.dechirp) {
            (Response::Paper, _) => {
                let parts = CHIRP.chunks(BLOCK_SAMPLES);
                blocks.iter_mut().zip(parts).for_each(|(sum, part)| *sum = offset * conjugate_mean(part));
            }
            // a range sample is conjugated; the offset is a beat of frequency 0
            (_, Dechirp::Analog) => self.response.add(&mut blocks, offset.conj(), 0.0),
            (_, Dechirp::Digital) => {
                self.response.add(&mut blocks, offset, 0.0);
                let parts = self.chirp.chunks(self.chirp.len() / usize::from(self.radar.range_samples));
                blocks.iter_mut().zip(parts).for_each(|(sum, part)| *sum *= conjugate_mean(part));
            }
        }
        blocks
    }

    /// Whether range samples have to be made from raw slots: [`Receiver::beats`] knows the front end's effects only of a range gate
    /// and of blocks in which the beat hardly turns, and nothing of an AC coupling.
    pub fn needs_samples(&self) -> bool {
        self.ac_coupling.is_some() || self.front_end.as_ref().is_some_and(RangeFrontEnd::needs_samples)
    }

    /// What the core makes of slots with these range samples, one after the other: its integers, the noise and that of the converter's
    /// rounding.
    ///
    /// Left out with a sensor that dechirps: saturation, and the mirrored frequencies that unequal I and Q or a wandering phase of
    /// real samples leave in the gate, -70 dB of the loudest echo from the sixth bin on.
    pub fn beats(&mut self, slots: &[Blocks]) -> Vec<Beat> {
        let mut beats = Vec::with_capacity(slots.len());
        let Response::Table(table) = self.response.clone() else {
            slots.chunks(TOGETHER).for_each(|slots| self.block_means(slots, &mut beats));
            return beats;
        };
        beats.extend(slots.iter().map(|blocks| {
            let (turn, blocks) = self.behind_front_end(blocks);
            let front = match self.radar.dechirp {
                Dechirp::Digital => turn * self.impairments.direct,
                Dechirp::Analog => (turn * self.impairments.direct).conj(),
            };
            let blocks = [&blocks, &self.offset];
            Self::range_samples(&self.converter, &table, blocks, front, &mut self.random)
        }));
        beats
    }

    /// The oscillator's phase in the next slot, and its range samples behind what the front end does to them.
    fn behind_front_end(&mut self, blocks: &Blocks) -> (Complex64, Blocks) {
        let turn = self.impairments.turn();
        match &self.front_end {
            None => (turn, *blocks),
            Some(front_end) => (turn, front_end.apply(blocks, self.oscillator.as_mut())),
        }
    }

    /// Appends the block means of up to [`TOGETHER`] slots.
    fn block_means(&mut self, slots: &[Blocks], beats: &mut Vec<Beat>) {
        let Converter { lsb, noise_lsb, .. } = self.converter;
        let scale = BLOCK_SAMPLES as f64 * 32767.0 / f64::from(1_u32 << RadarConfig::PAPER.shift());
        let noise = ((noise_lsb * noise_lsb + 1.0 / 12.0) / BLOCK_SAMPLES as f64).sqrt();
        let mut drawn = [[[0.0; 2]; BLOCKS]; TOGETHER];
        self.random.gaussians(drawn[..slots.len()].as_flattened_mut().as_flattened_mut());
        let Impairments { direct, image, .. } = self.impairments;
        let ideal = self.front_end.is_none() && self.impairments.is_ideal() && !self.impairments.turns();
        let mut received;
        // in LSB
        let (slots, lsb) = if ideal {
            (slots, lsb)
        } else {
            received = [Blocks::default(); TOGETHER];
            for (received, blocks) in received.iter_mut().zip(slots) {
                let (turn, blocks) = self.behind_front_end(blocks);
                let places = received.iter_mut().zip(&blocks).zip(IMAGE.iter()).zip(&self.offset);
                for (((to, z), of_image), offset) in places {
                    let z = z * turn / lsb;
                    *to = direct * z + image * (z.conj() * of_image) + offset;
                }
            }
            (&received[..slots.len()], 1.0)
        };
        let begin = beats.len();
        beats.resize(begin + slots.len(), ZERO_BEAT);
        vectorised(
            #[inline(always)]
            || {
                for ((beat, slot), drawn) in beats[begin..].iter_mut().zip(slots).zip(&drawn) {
                    for ((to, z), drawn) in beat.iter_mut().zip(slot).zip(drawn) {
                        to.re = round((z.re / lsb + noise * drawn[0]) * scale);
                        to.im = round((z.im / lsb + noise * drawn[1]) * scale);
                    }
                }
            },
        );
    }

    fn range_samples(
        converter: &Converter,
        table: &Table,
        [blocks, offset]: [&Blocks; 2],
        front: Complex64,
        random: &mut Random,
    ) -> Beat {
        let noise = (converter.noise_lsb * converter.noise_lsb + 1.0 / 12.0).sqrt();
        let drawn = table.noise(|| random.gaussian());
        let mut beat = ZERO_BEAT;
        for (((out, z), offset), drawn) in beat.iter_mut().zip(blocks).zip(offset).zip(drawn) {
            let z = z * front / converter.lsb + offset + drawn * noise;
            (out.re, out.im) = (round(z.re), round(z.im));
        }
        beat
    }

    /// Appends one raw slot: the values that the sensor delivers of these paths, amplitudes in sqrt W.
    pub fn slot(&mut self, paths: &[Path], values: &mut Vec<i16>) {
        let turn = self.impairments.turn();
        if let Some(oscillator) = &mut self.oscillator {
            oscillator.draw(&mut self.beat.frequency);
        }
        let Impairments { direct, image, offset, limiter, leakage, .. } = self.impairments;
        let Receiver { radar, converter, random, ac_coupling, noise, .. } = self;
        let noise_lsb = converter.noise_lsb;
        // in LSB from here on
        let limiter = limiter.map(|one| Limiter { steepness: one.steepness * converter.lsb * converter.lsb });
        let compressed = |z: Complex64| limiter.map_or(z, |one| z * one.gain(z.norm_sqr()));
        let impaired = |z: Complex64| direct * z + image * z.conj() + offset;
        let tones = paths.iter().map(|path| (path.gain, path.delay_s));
        let tones = tones.chain(leakage.map(|one| (one.gain, one.delay_s)));
        if matches!(self.response, Response::Paper) {
            let scaled: Sweep = self.sweeps.sum(tones).map(|z| z * turn / converter.lsb);
            self.beat.interpolate(&scaled, || time_shift(&scaled));
            random.gaussians(noise.as_flattened_mut());
            let Samples { re, im, .. } = &self.beat;
            let samples = (re.first_chunk::<SAMPLES>(), im.first_chunk::<SAMPLES>(), noise.first_chunk());
            let (Some(re), Some(im), Some(noise)) = samples else {
                unreachable!("the paper's radar has {SAMPLES} samples")
            };
            let ([c, s], begin) = (&*CHIRP_PARTS, values.len());
            values.resize(begin + 2 * SAMPLES, 0);
            let Some(slot) = values[begin..].as_chunks_mut().0.first_chunk_mut() else {
                unreachable!("as many values as were appended")
            };
            if self.impairments.is_ideal() {
                converter.convert_all(
                    #[inline(always)]
                    move |n| [re[n] * c[n] - im[n] * s[n], re[n] * s[n] + im[n] * c[n]],
                    noise,
                    slot,
                );
            } else {
                converter.convert_all(
                    #[inline(always)]
                    move |n| {
                        let z =
                            impaired(compressed(Complex64::new(re[n], im[n])) * Complex64::new(c[n], s[n]));
                        [z.re, z.im]
                    },
                    noise,
                    slot,
                );
            }
            return;
        }
        self.beat.fill(tones, radar);
        let Samples { re, im, .. } = &self.beat;
        let beat = re.iter().zip(im.iter()).map(|(&re, &im)| Complex64::new(re, im));
        let mut coupled = |z| ac_coupling.iter_mut().flatten().fold(z, |z, section| section.pass(z));
        let mut digitise = |x: f64| values.push(converter.convert(x + noise_lsb * random.gaussian()));
        let mut complex = |z: Complex64| {
            digitise(z.re);
            digitise(z.im);
        };
        match (radar.dechirp, radar.format) {
            (Dechirp::Digital, _) => {
                beat.zip(&self.chirp)
                    .for_each(|(z, s)| complex(impaired(compressed(z * turn / converter.lsb) * s)));
            }
            (Dechirp::Analog, Format::Complex) => beat.for_each(|z| {
                complex(coupled(impaired(compressed(z.conj() * turn / converter.lsb))));
            }),
            (Dechirp::Analog, Format::Real) => beat.for_each(|z| {
                digitise(coupled(compressed(z.conj() * turn / converter.lsb) + offset).re);
            }),
        }
    }
}

/// Mean of conj(s): what digital dechirping leaves of a constant.
fn conjugate_mean(chirp: &[Complex64]) -> Complex64 {
    chirp.iter().map(|s| s.conj()).sum::<Complex64>() / chirp.len() as f64
}

#[cfg(test)]
mod agreement;
#[cfg(test)]
mod tests;
