//! Calibration: the rho at which simulated intensities are nearest to the measured ones.
//!
//! [`conditioning`] treats measured and simulated signals alike, [`intensity`] makes levels of them, [`mod@divergence`] compares and searches,
//! [`stored`] keeps what was found. The same random draws serve every rho, so the curve is smooth.

pub(crate) mod conditioning;
pub(crate) mod divergence;
pub(crate) mod intensity;
pub(crate) mod resample;
pub(crate) mod stored;

pub use stored::{rho_of, stored_elsewhere, stored_rho};

use super::channel::{BLOCKS, Complex64};
use super::dataset::{Set, Simulation};
use crate::error::Invalid;
use crate::formats::slots::Slots;
use crate::recordings::{Samples, Signal};
use crate::results::{Calibration, Spectrogram};
use crate::scenario::{Class, Radar, Scenario};
use conditioning::{ac_couple, clutter_free, moving_windows, remove_mean};
use divergence::{Counts, EVALUATIONS, divergence, search, shares};
use intensity::{Intensity, LEVELS, RANGE_DB, histogram};
use rayon::prelude::*;
use resample::resample;
use sdp3_core::config::RadarConfig;
use sdp3_core::dims::Beat;
use std::sync::atomic::{AtomicU64, Ordering};

/// Highest rate a measured signal is compared at, in Hz; faster ones are resampled to it.
pub const MEASURED_PRF_HZ: f64 = 2000.0;
/// Slots simulated before a window: the room's first response fades and the AC coupling settles. Measured rooms have no
/// beginning.
pub const SETTLE_SLOTS: u32 = 300;
/// Simulated people behind every point of the curve.
pub const PEOPLE: u32 = 100;
/// Recordings that stand for a measurement when none is given.
pub const STAND_INS: u32 = 30;
/// Window and hop of the measured spectrograms, and the fewest samples of a window of the signal.
const WINDOW: usize = 128;
const HOP: usize = 8;
const FEWEST: usize = 256;

/// Progress callback: steps done, steps in all.
pub type Progress<'a> = &'a (dyn Fn(u64, u64) + Sync);

/// How simulated signals are made to look like the measured one.
pub struct Bench<'a> {
    scenario: &'a Scenario,
    seed: u64,
    class: Class,
    /// A real, AC-coupled signal instead of a complex one.
    real: bool,
    /// One range cell, its mean removed, instead of the beat matrix.
    single_cell: bool,
    slots: u32,
    intensity: Intensity,
    hop: usize,
}

impl<'a> Bench<'a> {
    /// Complex recordings of `slots` sensing slots as the scenario's front end shows them; real ones if asked.
    pub fn new(scenario: &'a Scenario, seed: u64, class: Class, real: bool, slots: u32) -> Self {
        let settings = &scenario.spectrogram;
        let hop = usize::from(settings.hop);
        let intensity = Intensity::new(usize::from(settings.window), hop);
        Bench { scenario, seed, class, real, single_cell: false, slots, intensity, hop }
    }

    /// One person's slow-time signal: clutter removed, as the measured one has it.
    fn signal(&self, rho: f64, set: Set, index: u32) -> Vec<Complex64> {
        let mut simulation = Simulation::new(self.scenario, rho, self.seed, set, self.class, index);
        if self.real {
            // a CW sensor sees one number a time; its filter settles before the window begins
            let beats = simulation.advance_blocks(SETTLE_SLOTS + self.slots);
            let mut y: Vec<_> = beats.iter().map(|b| Complex64::new(b[BLOCKS / 2].re, 0.0)).collect();
            ac_couple(&mut y, 1.0 / self.scenario.interval_s());
            return y.split_off(SETTLE_SLOTS as usize);
        }
        let mut beats = simulation.advance_blocks(SETTLE_SLOTS + self.slots);
        let beats = beats.split_off(SETTLE_SLOTS as usize);
        if self.single_cell {
            let mut y: Vec<_> = beats.iter().map(|b| b[BLOCKS / 2]).collect();
            remove_mean(&mut y);
            return y;
        }
        clutter_free(&beats)
    }

    /// Intensities of `people` recordings of a set, together.
    pub fn counts(&self, rho: f64, set: Set, people: u32) -> Counts {
        let one = |index| histogram(&self.intensity.decibels(&self.signal(rho, set, index), self.real));
        let each: Vec<Counts> = (0..people).into_par_iter().map(one).collect();
        let mut counts = [0_u64; LEVELS];
        each.iter().for_each(|one| counts.iter_mut().zip(one).for_each(|(sum, n)| *sum += n));
        counts
    }

    fn search(&self, measured: &Counts, progress: Progress) -> (Vec<crate::results::KlPoint>, Counts, usize) {
        let done = AtomicU64::new(0);
        let found = search(measured, |rho| {
            let counts = self.counts(rho, Set::Calibration, PEOPLE);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, EVALUATIONS);
            counts
        });
        progress(EVALUATIONS, EVALUATIONS);
        found
    }
}

/// A measured signal at the rate of comparison: slow time, its rate, whether it is real, whether its clutter is gone.
fn slow_time(signal: &Signal, radar: &Radar) -> Result<(Vec<Complex64>, f64, bool), Invalid> {
    let rate = signal.rate_hz.min(MEASURED_PRF_HZ);
    let brought = |x: &[f64]| {
        if signal.rate_hz > MEASURED_PRF_HZ { resample(x, signal.rate_hz, rate) } else { x.to_vec() }
    };
    Ok(match &signal.samples {
        Samples::Real(x) => {
            let mut y: Vec<_> = brought(x).into_iter().map(|x| Complex64::new(x, 0.0)).collect();
            ac_couple(&mut y, rate);
            (y, rate, true)
        }
        Samples::Complex(z) => {
            let re = brought(&z.iter().map(|z| z.re).collect::<Vec<_>>());
            let im = brought(&z.iter().map(|z| z.im).collect::<Vec<_>>());
            (re.into_iter().zip(im).map(|(re, im)| Complex64::new(re, im)).collect(), rate, false)
        }
        Samples::Slots(slots) => {
            let config = radar.config();
            let found = slots_without_clutter(slots, config).ok_or_else(|| {
                let legal = format!("{}, as the scenario's radar has", config.values_per_slot());
                Invalid::new("values a slot", slots.per_slot, legal).at(&signal.title)
            })?;
            (found, signal.rate_hz, false)
        }
    })
}

/// The slow time of raw slots, without what stands still; `None` if they are not of this radar.
pub fn slots_without_clutter(slots: &Slots, radar: RadarConfig) -> Option<Vec<Complex64>> {
    let complex = |beat: &Beat| beat.map(|z| Complex64::new(f64::from(z.re), f64::from(z.im)));
    Some(clutter_free(&slots.beats(radar)?.iter().map(complex).collect::<Vec<_>>()))
}

/// A measured signal, conditioned and counted, and the bench that simulated ones are compared on.
struct Comparison {
    at_carrier: Scenario,
    signal: Vec<Complex64>,
    rate_hz: f64,
    real: bool,
    single_cell: bool,
    slots: usize,
    /// Windows with motion, and the intensities of them all.
    windows: usize,
    counts: Counts,
}

impl Comparison {
    fn new(scenario: &Scenario, measured: &Signal) -> Result<Self, Invalid> {
        let (mut signal, rate_hz, real) = slow_time(measured, &scenario.radar)?;
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
        let mut counts = [0; LEVELS];
        let windows = moving_windows(&signal, slots);
        for window in &windows {
            let one = histogram(&intensity.decibels(window, real));
            counts.iter_mut().zip(one).for_each(|(sum, n)| *sum += n);
        }
        let windows = windows.len();
        if windows == 0 {
            let legal = "above 0 after clutter removal: nothing moves in this recording";
            return Err(Invalid::new("energy", 0, legal).at(&measured.title));
        }
        Ok(Comparison { at_carrier, signal, rate_hz, real, single_cell, slots, windows, counts })
    }

    fn bench(&self, seed: u64, class: Class) -> Bench<'_> {
        let mut bench = Bench::new(&self.at_carrier, seed, class, self.real, self.slots as u32);
        bench.intensity = Intensity::new(WINDOW, HOP);
        bench.hop = HOP;
        bench.single_cell = self.single_cell;
        bench
    }
}

/// D(measured || simulated) in nats of the scenario's channel model as it is, at this rho, and the simulated shares of the levels.
///
/// # Errors
///
/// See [`Invalid`].
pub fn divergence_measured(
    scenario: &Scenario,
    measured: &Signal,
    class: Class,
    seed: u64,
    rho: f64,
) -> Result<(f64, Vec<f64>), Invalid> {
    let comparison = Comparison::new(scenario, measured)?;
    let simulated = comparison.bench(seed, class).counts(rho, Set::Calibration, PEOPLE);
    Ok((divergence(&comparison.counts, &simulated, 0), shares(&simulated)))
}

/// Calibrates on a measured signal of a person who moves as `class` says.
///
/// # Errors
///
/// See [`Invalid`].
pub fn calibrate_measured(
    scenario: &Scenario,
    measured: &Signal,
    class: Class,
    seed: u64,
    progress: Progress,
) -> Result<Calibration, Invalid> {
    let comparison = Comparison::new(scenario, measured)?;
    let bench = comparison.bench(seed, class);
    let (curve, simulated, best) = bench.search(&comparison.counts, progress);
    let shown = moving_windows(&comparison.signal, comparison.slots)[0];
    let picture_of = bench.signal(curve[best].rho, Set::Demo, 0);
    let (slots, rate_hz) = (comparison.slots, comparison.rate_hz);
    let seconds = slots as f64 / rate_hz;
    let (title, carrier_hz) = (&measured.title, measured.carrier_hz);
    Ok(Calibration {
        source: format!(
            "measured: {title}, {:.4} GHz, {} windows of {seconds:.1} s with motion at {rate_hz} Hz",
            carrier_hz / 1e9,
            comparison.windows
        ),
        carrier_hz,
        rho: curve[best].rho,
        kl: Some(curve[best].kl),
        kl_without_uncertainty: curve.last().map(|p| p.kl),
        curve_of: format!("intensities of {title} against {PEOPLE} simulated recordings of {}", class.name()),
        curve,
        measured_pmf: shares(&comparison.counts),
        simulated_pmf: shares(&simulated),
        measured: Some(picture(&bench, title, shown)),
        simulated: Some(picture(&bench, &format!("simulated {}", class.name()), &picture_of)),
    })
}

/// No measurement: the stored rho, and the curve that recovers it from recordings simulated with it.
pub fn recover(scenario: &Scenario, rho: f64, source: &str, seed: u64, progress: Progress) -> Calibration {
    let class = Class::AdultWalking;
    let bench = Bench::new(scenario, seed, class, false, scenario.largest_sensing_slots());
    let measured = bench.counts(rho, Set::Surrogate, STAND_INS);
    let (curve, simulated_counts, best) = bench.search(&measured, progress);
    let simulated = bench.signal(rho, Set::Demo, 0);
    Calibration {
        source: source.to_owned(),
        carrier_hz: scenario.radar.carrier_hz,
        rho,
        kl: Some(curve[best].kl),
        kl_without_uncertainty: curve.last().map(|p| p.kl),
        curve_of: format!(
            "self-check, nothing measured: {STAND_INS} walkers simulated at rho = {rho} stand for the measurement; the \
             curve's minimum is at {}",
            curve[best].rho
        ),
        curve,
        measured_pmf: shares(&measured),
        simulated_pmf: shares(&simulated_counts),
        measured: None,
        simulated: Some(picture(&bench, "simulated walker", &simulated)),
    }
}

fn picture(bench: &Bench, title: &str, signal: &[Complex64]) -> Spectrogram {
    let decibels = bench.intensity.decibels(signal, bench.real);
    let rows = decibels.first().map_or(0, Vec::len);
    let row_hz = 1.0 / (256.0 * bench.scenario.interval_s());
    let pixel =
        |row: usize| decibels.iter().map(move |f| ((1.0 + f[row] / RANGE_DB).clamp(0.0, 1.0) * 255.0) as u8);
    Spectrogram {
        title: title.to_owned(),
        rows: rows as u32,
        frames: decibels.len() as u32,
        first_row_hz: if bench.real { 0.0 } else { -128.0 * row_hz },
        row_hz,
        frame_s: bench.hop as f64 * bench.scenario.interval_s(),
        carrier_hz: bench.scenario.radar.carrier_hz,
        range_db: RANGE_DB,
        grey: (0..rows).flat_map(pixel).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_walker_behind_a_real_sensor_is_found() {
        // 6 s of a simulated 24 GHz sensor at 8 kHz, as a file would hold them
        let mut scenario = Scenario::default();
        scenario.radar.carrier_hz = 24.125e9;
        scenario.frame.slot_s = 1.0 / MEASURED_PRF_HZ;
        scenario.frame.spacing_slots = 0;
        let mut samples = Vec::new();
        for index in 0..6 {
            let mut simulation =
                Simulation::new(&scenario, 0.993, 11, Set::Surrogate, Class::AdultWalking, index);
            samples.extend(simulation.advance_blocks(2000).iter().map(|b| b[BLOCKS / 2].re));
        }
        let samples = Samples::Real(resample(&samples, 2000.0, 8000.0));
        let measured = Signal { samples, rate_hz: 8000.0, carrier_hz: 24.125e9, title: "test".into() };
        let class = Class::AdultWalking;
        let found = calibrate_measured(&Scenario::default(), &measured, class, 3, &|_, _| ()).unwrap();
        assert!((found.rho - 0.993).abs() < 0.002, "{}", found.rho);
        assert!(found.kl_without_uncertainty > found.kl.map(|kl| 10.0 * kl));
        assert_eq!(found.curve.last().map(|p| p.rho), Some(1.0));
        assert!(found.measured.is_some_and(|m| m.grey.contains(&255)));
    }

    #[test]
    fn a_silent_or_short_signal_is_refused() {
        let signal = |n: usize| Signal {
            samples: Samples::Complex(vec![Complex64::new(0.5, 0.5); n]),
            rate_hz: 20.0,
            carrier_hz: 60e9,
            title: "wall".into(),
        };
        let refusal = |n: usize| {
            calibrate_measured(&Scenario::default(), &signal(n), Class::Standing, 1, &|_, _| ())
                .unwrap_err()
                .to_string()
        };
        assert!(refusal(600).contains("nothing moves"), "{}", refusal(600));
        assert!(
            refusal(90).contains("wall: length in samples is 90") && refusal(90).contains("256"),
            "{}",
            refusal(90)
        );
    }

    #[test]
    fn known_memories_are_recovered_within_a_thousandth() {
        let scenario = Scenario::default();
        for (seed, rho) in [(3, 0.990), (4, 0.993), (5, 0.995), (6, 0.997), (7, 0.998)] {
            let found = recover(&scenario, rho, "test", seed, &|_, _| ());
            let best = found.curve.iter().min_by(|a, b| a.kl.total_cmp(&b.kl)).unwrap();
            assert!((best.rho - rho).abs() <= 0.001, "{rho}: {}", best.rho);
            assert!(found.kl_without_uncertainty > found.kl.map(|kl| 5.0 * kl));
        }
    }
}
