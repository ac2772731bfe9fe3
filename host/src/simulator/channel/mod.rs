//! Channels of the sensed room: nine models behind one trait, for the radar and for every receiver.
//!
//! A model says, slot after slot, over which [`Path`]s a wave travels between two points of a [`Scene`]. What a radar makes
//! of them is one sum of tones in the beat domain ([`Sweep`], [`response`]); what a receiver makes of them is a frequency
//! response ([`link`]).
//!
//! | name | file | what it is |
//! |---|---|---|
//! | `dahc` | [`dahc`] | the paper's: sixteen primitives and an AR(1) room, eqs. (DAHC), (uit), (vit) |
//! | `primitive` | [`primitive`] | the same with rho = 1: no uncertainty |
//! | `ray-tracing` | [`ray_tracing`] | images up to second order off slabs, rough surfaces, diffraction, a body that moves |
//! | `statistical` | [`statistical`] | Saleh and Valenzuela's clusters, fading by a Doppler spectrum |
//! | `80211ay` | [`ieee80211ay`] | quasi-deterministic rooms, polarised |
//! | `80211ax` | [`ieee80211ax`] | TGn/TGac/TGax models A to F, plane waves with their bell spectrum |
//! | `38901` | [`tr38901`] | 3GPP indoor office, every step of its procedure, with the sensing additions |
//! | `quadriga` | [`quadriga`] | the same clusters as scatterers in space, drifting within segments |
//! | `metis` | [`metis`] | map-based hybrid: traced rough walls, screens, random objects, stochastic clusters |

pub(crate) mod antenna;
pub(crate) mod autoregressive;
pub(crate) mod dahc;
pub(crate) mod diffraction;
pub(crate) mod echo;
pub(crate) mod field;
pub(crate) mod ieee80211ax;
pub(crate) mod ieee80211ay;
pub(crate) mod link;
pub(crate) mod material;
pub(crate) mod metis;
pub(crate) mod obstruction;
pub(crate) mod primitive;
pub(crate) mod properties;
pub(crate) mod quadriga;
pub(crate) mod ray_tracing;
pub(crate) mod response;
pub(crate) mod room;
pub(crate) mod roughness;
pub(crate) mod shadowing;
pub(crate) mod statistical;
pub(crate) mod target;
pub(crate) mod tgn;
pub(crate) mod tr38901;

use super::body::Vec3;
use super::body::number::LANES;
use crate::numerics::random::Random;
use crate::numerics::sincos::sincos;
use crate::numerics::vectors::vectorised;
use crate::scenario::{Model, SPEED_OF_LIGHT, Scenario};
use antenna::Antenna;
use response::Response;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;
use std::sync::LazyLock;
use target::Target;

pub type Complex64 = Complex<f64>;

/// One path of a wave at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Path {
    /// Complex amplitude ratio between isotropic antennas, the carrier's phase included.
    pub gain: Complex64,
    pub delay_s: f64,
    /// Unit vector from the transmitter towards where the wave leaves.
    pub departure: Vec3,
    /// Unit vector from the receiver towards where the wave comes from.
    pub arrival: Vec3,
}

/// Where everything is at one sensing slot.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The sensing slot, counted from 0.
    pub slot: u32,
    /// Its time in s.
    pub time_s: f64,
    /// Transmit antenna in m.
    pub from: Vec3,
    /// Receive antenna in m; the radar's own position for the radar.
    pub to: Vec3,
    /// Everybody in the room.
    pub people: &'a [Target],
}

impl Scene<'_> {
    /// Whether both ends are the radar's.
    pub fn monostatic(&self) -> bool {
        self.from == self.to
    }

    /// The scene `n` slots later; they follow `interval_s` apart.
    fn later(&self, n: usize, interval_s: f64) -> Self {
        Scene { slot: self.slot + n as u32, time_s: self.time_s + n as f64 * interval_s, ..*self }
    }

    /// Length of the direct path in m.
    pub fn distance_m(&self) -> f64 {
        super::body::norm(super::body::sub(self.to, self.from))
    }
}

/// What a radar makes of paths: its antenna for both ways, and its range samples.
#[derive(Debug, Clone)]
pub struct Sensor {
    pub antenna: Antenna,
    pub response: Response,
}

impl Sensor {
    /// The radar of a scenario.
    pub fn of(scenario: &Scenario) -> Self {
        Sensor { antenna: Antenna::of(scenario), response: Response::of(&scenario.radar) }
    }

    /// Adds paths.
    pub fn add(&self, beat: &mut Blocks, paths: &[Path]) {
        for paths in paths.chunks(LANES) {
            let weights =
                self.antenna.weights::<LANES>(std::array::from_fn(|n| &paths[n.min(paths.len() - 1)]));
            for (path, weight) in paths.iter().zip(weights) {
                self.response.add(beat, path.gain * weight, path.delay_s);
            }
        }
    }
}

/// A channel model of one link in one recording: it has a state, and draws from its own stream of random numbers.
pub trait ChannelModel: Send {
    /// Appends the paths of `scene` between isotropic antennas. Scenes come in the order of their slots, every slot once.
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>);

    /// The range samples of consecutive slots by a radar's antenna and response, added to `beats`; `scene` is the first, the others follow
    /// `interval_s` apart. Models with sums that can be formed faster than path by path do so; the result agrees with
    /// [`ChannelModel::paths`] to -80 dB, of people with limbs far from the torso to -65 dB. A model keeps to the sensor it is first asked for.
    fn beats(&mut self, scene: &Scene, interval_s: f64, sensor: &Sensor, beats: &mut [Blocks]) {
        self.fluctuation(sensor, beats);
        self.steady_beats(scene, interval_s, sensor, beats);
    }

    /// The part of [`ChannelModel::beats`] that depends on rho: the room's AR(1) response. Models without one add nothing.
    fn fluctuation(&mut self, _sensor: &Sensor, _beats: &mut [Blocks]) {}

    /// The other part, which is the same for every rho.
    fn steady_beats(&mut self, scene: &Scene, interval_s: f64, sensor: &Sensor, beats: &mut [Blocks]) {
        let mut paths = Vec::new();
        for (n, beat) in beats.iter_mut().enumerate() {
            let scene = scene.later(n, interval_s);
            paths.clear();
            self.paths(&scene, &mut paths);
            sensor.add(beat, &paths);
        }
    }
}

/// Amplitude ratio of free space between isotropic antennas: lambda / (4 pi d).
pub fn free_space(length_m: f64, lambda: f64) -> f64 {
    lambda / (4.0 * PI * length_m)
}

/// The model of `scenario` for a link between two points, with the AR(1) coefficient `rho` where it has one.
pub fn model(
    scenario: &Scenario,
    from: Vec3,
    to: Vec3,
    rho: f64,
    mut random: Random,
) -> Box<dyn ChannelModel> {
    let link = (from, to);
    match scenario.channel.model {
        Model::Dahc => Box::new(dahc::Dahc::new(scenario, link, rho, random)),
        Model::Primitive => Box::new(primitive::model(scenario, link, random)),
        Model::RayTracing => Box::new(ray_tracing::RayTracing::new(scenario)),
        Model::Statistical => Box::new(statistical::SalehValenzuela::new(scenario, link, &mut random)),
        Model::Ieee80211ay => Box::new(ieee80211ay::ConferenceRoom::new(scenario, link, &mut random)),
        Model::Ieee80211ax => Box::new(ieee80211ax::Indoor::new(scenario, link, random)),
        Model::Tr38901 => Box::new(tr38901::IndoorOffice::new(scenario, link, random)),
        Model::Quadriga => Box::new(quadriga::Drifting::new(scenario, random)),
        Model::Metis => Box::new(metis::MapBased::new(scenario, link, random)),
    }
}

/// Chebyshev nodes of the paper's sweep. A delay of 110 ns turns the beat by 7 rad: sixteen nodes hold it to -160 dB; the 190 ns of a
/// corner path in a room of 20 m to -100 dB.
pub const NODES: usize = 16;

/// A slot's beat at the nodes.
pub type Sweep = [Complex64; NODES];

/// Most range samples of a slot.
pub const BLOCKS: usize = sdp3_core::dims::BEATS;

/// Range samples of a slot: of the paper's radar the beat averaged over each of the core's blocks, in sqrt W per sqrt W; of others
/// what [`Response`] says.
pub type Blocks = [Complex64; BLOCKS];

/// Sweep rate B / T_sw of the paper's radar in Hz/s.
pub const SWEEP_RATE: f64 = 10e6 / 100e-6;
/// Its sweep duration in s.
pub const SWEEP_S: f64 = 100e-6;
/// Time between two block centres in s.
pub const BLOCK_S: f64 = SWEEP_S / BLOCKS as f64;
/// Time of the sweep's middle in s: samples are taken at n / f_s, n = 1 to 1000.
pub const MIDDLE_S: f64 = SWEEP_S / 2.0 + 0.05e-6;

/// Time of a node in s.
pub fn node_time(k: usize) -> f64 {
    SWEEP_S * 0.5 * (1.0 - node_cosine(k))
}

/// How far a node lies before the sweep's middle, in halves of the sweep.
fn node_cosine(k: usize) -> f64 {
    libm::cos(PI * (k as f64 + 0.5) / NODES as f64)
}

/// Half of the nodes; the others mirror them at the sweep's middle.
const HALF: usize = NODES / 2;

/// [`node_cosine`] of the first half.
static NODE_COSINES: LazyLock<[f64; HALF]> = LazyLock::new(|| std::array::from_fn(node_cosine));

/// Paths of which the first phases are found together.
const TOGETHER: usize = 8;

/// Sums of paths' beats at the nodes, slot after slot. A path that keeps its delay from one slot to the next keeps its phasors.
#[derive(Default)]
pub struct Sweeps {
    /// Of each path the last delay in s, and sines and cosines of its phase at the first half of the nodes relative to the sweep's middle.
    phasors: Vec<(f64, [[f64; HALF]; 2])>,
}

impl Sweeps {
    /// Of each path its amplitude times s(t - tau) / s(t), the carrier's phase left to the amplitude: exp(j pi S tau (tau - T)) in the
    /// sweep's middle, and exp(+-j pi S tau T x) times that at the nodes x before and after it. Cost: [`NODES`] / 2 phasors a path that moves.
    pub fn sum(&mut self, mut paths: impl Iterator<Item = (Complex64, f64)>) -> Sweep {
        let nodes = &*NODE_COSINES;
        vectorised(
            #[inline(always)]
            || {
                let [mut re, mut im, mut mirrored_re, mut mirrored_im] = [[0.0; HALF]; 4];
                let mut index = 0;
                while let Some(first) = paths.next() {
                    let (mut group, mut count) = ([first; TOGETHER], 1);
                    for (place, path) in group[1..].iter_mut().zip(&mut paths) {
                        (*place, count) = (path, count + 1);
                    }
                    let [sines, cosines] =
                        sincos(&group.map(|(_, delay_s)| PI * SWEEP_RATE * delay_s * (delay_s - SWEEP_S)));
                    if self.phasors.len() < index + count {
                        self.phasors.resize(index + count, (f64::NAN, Default::default()));
                    }
                    for (n, (amplitude, delay_s)) in group.into_iter().enumerate().take(count) {
                        let middle = Complex64::new(cosines[n], sines[n]) * amplitude;
                        let (kept_s, phasors) = &mut self.phasors[index + n];
                        if *kept_s != delay_s {
                            *phasors = sincos(&nodes.map(|x| PI * SWEEP_RATE * SWEEP_S * delay_s * x));
                            *kept_s = delay_s;
                        }
                        let [s, c] = &*phasors;
                        for k in 0..HALF {
                            let (a, b) = (middle.re * c[k], middle.im * s[k]);
                            let (d, e) = (middle.re * s[k], middle.im * c[k]);
                            re[k] += a - b;
                            im[k] += e + d;
                            mirrored_re[k] += a + b;
                            mirrored_im[k] += e - d;
                        }
                    }
                    index += count;
                }
                std::array::from_fn(|k| match k {
                    ..HALF => Complex64::new(re[k], im[k]),
                    _ => Complex64::new(mirrored_re[NODES - 1 - k], mirrored_im[NODES - 1 - k]),
                })
            },
        )
    }
}

/// Mean over a block of 125 samples of a tone at `frequency` in Hz, relative to its value at the block's centre, to -140 dB.
pub fn boxcar(frequency: f64) -> f64 {
    let x = PI * frequency * BLOCK_S;
    // sin(x) / x over sin(x/125) / (x/125), to x^6
    let x2 = x * x;
    1.0 - x2 / 6.0 * (1.0 - 1.0 / 15_625.0) * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0))
}

/// Adds one path's block means.
pub fn add_blocks(beat: &mut Blocks, amplitude: Complex64, delay_s: f64) {
    let frequency = SWEEP_RATE * delay_s;
    let angle = PI * SWEEP_RATE * delay_s * delay_s - 2.0 * PI * frequency * (MIDDLE_S - 3.5 * BLOCK_S);
    let mut value = amplitude * phasor(angle) * boxcar(frequency);
    let step = phasor(-2.0 * PI * frequency * BLOCK_S);
    for beat in beat {
        *beat += value;
        value *= step;
    }
}

pub fn phasor(angle: f64) -> Complex64 {
    let (sine, cosine) = libm::sincos(angle);
    Complex64::new(cosine, sine)
}

/// -2 pi length / lambda in rad, whole wavelengths taken off.
pub fn carrier_angle(length_m: f64, lambda: f64) -> f64 {
    let turns = length_m / lambda;
    -2.0 * PI * (turns - turns.floor())
}

/// exp(-j 2 pi length / lambda): whole wavelengths are taken off before the cosine.
pub fn carrier_phase(length_m: f64, lambda: f64) -> Complex64 {
    phasor(carrier_angle(length_m, lambda))
}

pub fn wavelength(carrier_hz: f64) -> f64 {
    SPEED_OF_LIGHT / carrier_hz
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn block_means_are_means_of_the_beat() {
        for delay in [0.4e-9, 13.3e-9, 60e-9, 110e-9] {
            let mut found = Blocks::default();
            add_blocks(&mut found, Complex64::new(0.8, -0.3), delay);
            for (b, found) in found.iter().enumerate() {
                let sum: Complex64 = (1..=125)
                    .map(|n| {
                        let t = f64::from(125 * b as u32 + n) / 10e6;
                        phasor(PI * SWEEP_RATE * (delay * delay - 2.0 * delay * t))
                    })
                    .sum();
                let exact = sum * Complex64::new(0.8, -0.3) / 125.0;
                assert!((found - exact).norm() < 1e-7, "{delay} {b}: {found} {exact}");
            }
        }
    }
}
