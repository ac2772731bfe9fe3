//! A measured signal beside simulated ones: on the same windows, by intensities and by spectra.

use super::conditioning::{ac_couple, moving_windows, remove_mean};
use super::divergence::{Counts, divergence};
use super::intensity::{Intensity, LEVELS, histogram};
use super::room_fit::{DRAWS, FEWEST_WINDOWS, RoomFit as SpectralFits, STREAM, fit, interval};
use super::sensor::SensorSimulation;
use super::spectrum::{Bands, Conditioning, Spectrum};
use super::{PEOPLE, beats_of, without_clutter};
use crate::error::Invalid;
use crate::numerics::random::Random;
use crate::numerics::resample::resample;
use crate::recordings::{Samples, Signal};
use crate::results::{Interval, RoomFit, RoomModel};
use crate::scenario::{ArMode, Class, Model, Radar, Scenario};
use crate::simulator::channel::{BLOCKS, Complex64};
use crate::simulator::dataset::Set;
use rayon::prelude::*;

/// Highest rate a measured signal is compared at, in Hz; faster ones are resampled to it.
pub const MEASURED_PRF_HZ: f64 = 2000.0;
/// Window and hop of the measured spectrograms, and the fewest samples of a window of the signal.
const WINDOW: usize = 128;
const HOP: usize = 8;
const FEWEST: usize = 256;

/// Simulated people behind the spectrum of an echo.
const ECHOES: u32 = 1500;
/// A K factor at which nothing is left of the fluctuation, in dB.
const NO_FLUCTUATION_DB: f64 = 400.0;

/// A measured signal at the rate of comparison.
pub struct Slow {
    /// For intensities, the clutter of raw slots gone.
    pub signal: Vec<Complex64>,
    /// The mean over range samples, of raw slots.
    summed: Option<Vec<Complex64>>,
    pub rate_hz: f64,
    pub real: bool,
}

/// A measured signal at the rate of comparison, raw slots as this radar's module receives them.
///
/// # Errors
///
/// Slots of another radar.
pub fn slow_time(signal: &Signal, radar: &Radar) -> Result<Slow, Invalid> {
    let rate = signal.rate_hz.min(MEASURED_PRF_HZ);
    let brought = |x: &[f64]| {
        if signal.rate_hz > MEASURED_PRF_HZ { resample(x, signal.rate_hz, rate) } else { x.to_vec() }
    };
    Ok(match &signal.samples {
        Samples::Real(x) => {
            let mut y: Vec<_> = brought(x).into_iter().map(|x| Complex64::new(x, 0.0)).collect();
            ac_couple(&mut y, rate);
            Slow { signal: y, summed: None, rate_hz: rate, real: true }
        }
        Samples::Complex(z) => {
            let re = brought(&z.iter().map(|z| z.re).collect::<Vec<_>>());
            let im = brought(&z.iter().map(|z| z.im).collect::<Vec<_>>());
            let signal = re.into_iter().zip(im).map(|(re, im)| Complex64::new(re, im)).collect();
            Slow { signal, summed: None, rate_hz: rate, real: false }
        }
        Samples::Slots(slots) => {
            let config = radar.config();
            let beats = beats_of(slots, config).ok_or_else(|| {
                let legal = format!("{}, as the scenario's radar has", config.values_per_slot());
                Invalid::new("values a slot", slots.per_slot, legal).at(&signal.title)
            })?;
            let summed = beats.iter().map(|b| b.iter().sum::<Complex64>() / BLOCKS as f64).collect();
            Slow {
                signal: without_clutter(&beats, config.range_samples),
                summed: Some(summed),
                rate_hz: signal.rate_hz,
                real: false,
            }
        }
    })
}

/// A measured signal, conditioned and counted, and the sensor that simulated ones are compared on.
pub struct Comparison {
    pub at_carrier: Scenario,
    pub signal: Vec<Complex64>,
    /// The sum over range samples of raw slots; of other signals [`Self::signal`] itself.
    summed: Option<Vec<Complex64>>,
    pub rate_hz: f64,
    real: bool,
    single_cell: bool,
    pub slots: usize,
    /// Numbers of the windows with motion, their intensities, and those of them all.
    pub windows: Vec<usize>,
    each: Vec<Counts>,
    pub counts: Counts,
}

impl Comparison {
    /// Brings the signal to the rate of comparison.
    ///
    /// # Errors
    ///
    /// See [`Invalid`].
    pub fn new(scenario: &Scenario, measured: &Signal) -> Result<Self, Invalid> {
        let Slow { mut signal, summed, rate_hz, real } = slow_time(measured, &scenario.radar)?;
        let slots = ((rate_hz.round() as usize).max(FEWEST)).min(signal.len());
        if slots < FEWEST {
            let legal = format!("at least {FEWEST} at {rate_hz} Hz");
            return Err(Invalid::new("length in samples", signal.len(), legal).at(&measured.title));
        }
        let mut at_carrier = scenario.clone();
        if !matches!(measured.samples, Samples::Slots(_)) {
            // a sensor without range cells, or one with a body in its cell
            at_carrier.radar = scenario.radar.with_sweep_of(&Radar::default());
        }
        at_carrier.radar.carrier_hz = measured.carrier_hz;
        at_carrier.frame.slot_s = 1.0 / rate_hz;
        at_carrier.frame.spacing_slots = 0;
        let single_cell = matches!(measured.samples, Samples::Complex(_));
        if single_cell {
            signal.chunks_mut(slots).for_each(remove_mean);
        }
        let intensity = Intensity::new(WINDOW, HOP);
        let windows = moving_windows(&signal, slots);
        let count = |&w: &usize| histogram(&intensity.decibels(&signal[w * slots..][..slots], real));
        let each: Vec<Counts> = windows.iter().map(count).collect();
        let counts = total(&each, 0..each.len());
        if windows.is_empty() {
            let legal = "above 0 after clutter removal: nothing moves in this recording";
            return Err(Invalid::new("energy", 0, legal).at(&measured.title));
        }
        Ok(Comparison {
            at_carrier,
            signal,
            summed,
            rate_hz,
            real,
            single_cell,
            slots,
            windows,
            each,
            counts,
        })
    }

    /// Simulated people who move as `class` says, as the signal shows its own.
    pub fn sensor(&self, seed: u64, class: Class) -> SensorSimulation<'_> {
        let mut sensor = SensorSimulation::new(&self.at_carrier, seed, class, self.real, self.slots as u32);
        sensor.intensity = Intensity::new(WINDOW, HOP);
        sensor.single_cell = self.single_cell;
        sensor
    }

    /// Spectra of the windows with motion.
    fn spectra(&self, spectrum: &Spectrum) -> Vec<Bands> {
        let signal = self.summed.as_ref().unwrap_or(&self.signal);
        let of = |&w: &usize| {
            let mut window = signal[w * self.slots..][..self.slots].to_vec();
            if !self.real {
                remove_mean(&mut window);
            }
            spectrum.of(&window)
        };
        self.windows.iter().map(of).collect()
    }

    /// The room by three models; `None` of a channel without a mean. `curve` is what was simulated for the KL curve, rho = 1 last.
    pub fn room(&self, sensor: &SensorSimulation, curve: &[Counts]) -> Option<RoomFit> {
        let echoes = Echoes::new(sensor, ECHOES)?;
        let fitted = echoes.fit(&self.spectra(&echoes.spectrum));
        let still = curve.len() - 1;
        let noisy = white_noise(sensor, &self.counts, curve[still]);
        let least = |measured: &Counts, simulated: &[Counts]| {
            simulated.iter().map(|counts| divergence(measured, counts, 0)).fold(f64::INFINITY, f64::min)
        };
        let models = [curve, &noisy, &curve[still..]];
        let draw = |draw: u64| -> [f64; 2] {
            let mut random = Random::new(sensor.seed, STREAM, 1, draw);
            let n = self.each.len();
            let chosen = (0..n).map(|_| (random.uniform() * n as f64) as usize);
            let measured = total(&self.each, chosen);
            let [ar, white, still] = models.map(|simulated| least(&measured, simulated));
            [white - ar, still - ar]
        };
        let draws = if self.each.len() >= FEWEST_WINDOWS { DRAWS } else { 0 };
        let drawn: Vec<[f64; 2]> = (0..draws).map(draw).collect();
        let behind = |k: usize| interval(drawn.iter().map(|draw| draw[k]).collect());
        let names = ["AR room", "white noise", "static room"];
        let behind = [None, behind(0), behind(1)];
        let models: Vec<RoomModel> = (0..names.len())
            .map(|k| RoomModel {
                model: names[k].into(),
                kl: least(&self.counts, models[k]),
                kl_excess: behind[k],
                spectral: fitted.models[k].divergence,
                spectral_excess: fitted.models[k].behind,
                noise_db: fitted.models[k].noise_db,
            })
            .collect();
        Some(RoomFit {
            windows: self.each.len() as u32,
            rho: fitted.rho,
            rho_interval: fitted.rho_interval,
            k_factor_db: fitted.k_factor_db,
            k_factor_interval: fitted.k_factor_interval,
            verdict: verdict(&models[1], fitted.inside),
            models,
        })
    }
}

/// Simulated people behind the spectrum of an echo, as a sensor shows them.
pub struct Echoes {
    /// Of the sensor's signals.
    pub spectrum: Spectrum,
    people: Vec<Bands>,
    /// Power of the room's mean in the people's unit.
    mean_power: f64,
    seed: u64,
}

impl Echoes {
    /// Of `people` people; `None` of a channel without a mean.
    pub fn new(sensor: &SensorSimulation, people: u32) -> Option<Self> {
        let channel = &sensor.scenario.channel;
        if channel.model != Model::Dahc || channel.mode != ArMode::Rician {
            return None;
        }
        let with = |k_factor_db| {
            let mut scenario = sensor.scenario.clone();
            scenario.channel.k_factor_db = k_factor_db;
            scenario
        };
        // without a fluctuation, and with one as strong as the mean
        let (none, strong) = (with(NO_FLUCTUATION_DB), with(0.0));
        let rate_hz = 1.0 / sensor.scenario.interval_s();
        let conditioning =
            if sensor.real { Conditioning::AcCoupled(rate_hz) } else { Conditioning::MeanRemoved };
        let spectrum = Spectrum::new(sensor.slots as usize, conditioning);
        let of = |index| spectrum.of(&sensor.slow_time(&none, 1.0, Set::Calibration, index));
        Some(Echoes {
            people: (0..people).into_par_iter().map(of).collect(),
            mean_power: sensor.added_power([&none, &strong], 0.0, PEOPLE / 4),
            seed: sensor.seed,
            spectrum,
        })
    }

    /// The three models on spectra of windows.
    pub fn fit(&self, windows: &[Bands]) -> SpectralFits {
        fit(&self.spectrum, windows, &self.people, self.mean_power, self.seed)
    }
}

/// What static rooms with white noise of growing power show: in steps of 4 dB, then around the best in halves of it.
fn white_noise(sensor: &SensorSimulation, measured: &Counts, still: Counts) -> Vec<Counts> {
    let signals = |index| (sensor.signal(1.0, Set::Calibration, index), sensor.noise(index));
    let people: Vec<_> = (0..PEOPLE).into_par_iter().map(signals).collect();
    let power = |y: &[Complex64]| y.iter().map(|z| z.norm_sqr()).sum::<f64>();
    let echo: f64 = people.iter().map(|(echo, _)| power(echo)).sum();
    let noise: f64 = people.iter().map(|(_, noise)| power(noise)).sum();
    let at = |db: f64| {
        let gain = (echo / noise * libm::pow(10.0, db / 10.0)).sqrt();
        let sum = |(echo, noise): &(Vec<Complex64>, Vec<Complex64>)| {
            echo.iter().zip(noise).map(|(z, n)| z + n * gain).collect()
        };
        sensor.counted(people.par_iter().map(sum))
    };
    let mut found = vec![still];
    let mut best = (divergence(measured, &found[0], 0), -80.0);
    let mut evaluate = |db: f64, best: &mut (f64, f64)| {
        let counts = at(db);
        let kl = divergence(measured, &counts, 0);
        if kl < best.0 {
            *best = (kl, db);
        }
        found.push(counts);
    };
    (0..20).for_each(|k| evaluate(-60.0 + 4.0 * f64::from(k), &mut best));
    for step in [2.0, 1.0, 0.5] {
        let centre = best.1;
        [-step, step].iter().for_each(|side| evaluate(centre + side, &mut best));
    }
    found
}

/// Whether the AR room is nearer than white noise, by both measures.
fn verdict(white: &RoomModel, inside: bool) -> String {
    let words = |behind: Option<Interval>| match behind {
        None => "cannot be compared with white noise in so few windows",
        Some(behind) if behind.low > 0.0 => "is nearer than white noise",
        Some(behind) if behind.high < 0.0 => "is farther than white noise",
        Some(_) => "cannot be distinguished from white noise",
    };
    let known = match inside {
        true => "",
        false => "; rho lies at an end of the search, so that these windows do not determine it",
    };
    let [kl, spectral] = [white.kl_excess, white.spectral_excess].map(words);
    if kl == spectral {
        return format!("the AR room {kl} by intensities and by spectra{known}");
    }
    format!("the AR room {kl} by intensities, and {spectral} by spectra{known}")
}

/// Sum of chosen counts.
fn total(each: &[Counts], chosen: impl Iterator<Item = usize>) -> Counts {
    let mut counts = [0; LEVELS];
    chosen.for_each(|k| counts.iter_mut().zip(&each[k]).for_each(|(sum, n)| *sum += n));
    counts
}
