//! From simulation to measurement: a network trained on simulated Doppler alone classifies measured walking, running and still.
//!
//! A recording is one number a time (the real part of a complex one), at 2 kHz, AC-coupled, cut into windows of one second every
//! half second, each on its own level: spectrograms of 0..rate/2 in 64 rows. Every window of a recording has the motion of the
//! recording's name, pauses and turns included. A carrier above 30 GHz takes proportionally higher rates where the recording
//! has them; a slower recording keeps its own. The training draws are those of [`crate::simulator::randomised`]; no measured sample
//! is learned from.

use super::cells::Cells;
use super::labelled::{LeftOut, Measured};
use super::{Request, RunContext, Spread};
use crate::error::Failure;
use crate::formats::model_file::Preprocessing;
use crate::network::evaluation::Networks;
use crate::network::float_network::{FloatNetwork, first_maximum};
use crate::network::parameters::{Images, Parameters};
use crate::network::training::{self, train_all};
use crate::network::tuning::quantize_tuned;
use crate::recordings::{Samples, Signal};
use crate::simulator::calibration::conditioning::ac_couple;
use crate::simulator::calibration::intensity::{BETA, Intensity, RANGE_DB};
use crate::simulator::calibration::resample::resample;
use crate::simulator::calibration::slots_without_clutter;
use crate::simulator::channel::Complex64;
use crate::simulator::randomised::{Motion, draw};
use rayon::prelude::*;
use schemars::JsonSchema;
use sdp3_core::config::RadarConfig;
use sdp3_core::dims::ROWS;
use serde::{Deserialize, Serialize};

/// Simulated seconds of each motion: to learn from, and to test on.
const TRAIN: u32 = 1200;
const TEST: u32 = 300;
/// Rate of comparison in Hz, up to this carrier in Hz.
const RATE_HZ: f64 = 2000.0;
const RATE_CARRIER_HZ: f64 = 30e9;
/// Slowest recording in Hz: slower ones hold no second of spectrogram.
const SLOWEST_HZ: f64 = 400.0;

/// What images look like at a carrier and a rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// Rate in Hz.
    pub rate_hz: f64,
    window: usize,
    hop: usize,
}

impl Layout {
    /// For a recording; `None` if it is too slow.
    pub fn of(signal: &Signal) -> Option<Self> {
        let wanted = RATE_HZ * (signal.carrier_hz / RATE_CARRIER_HZ).clamp(1.0, 2.0);
        let rate_hz = signal.rate_hz.min(wanted).round();
        // windows of 64 ms every 12 ms; the transform has 256 points
        let samples = |seconds: f64| (seconds * rate_hz).round() as usize;
        let (window, hop) = (samples(0.064).clamp(64, 256), samples(0.012).max(4));
        (rate_hz >= SLOWEST_HZ).then_some(Layout { carrier_hz: signal.carrier_hz, rate_hz, window, hop })
    }

    /// Samples of a window.
    pub fn second(&self) -> usize {
        self.rate_hz as usize
    }

    fn frames(&self) -> usize {
        (self.second() - self.window) / self.hop + 1
    }

    /// The image of one AC-coupled second, on its own mean level.
    pub fn image(&self, second: &[f64]) -> Vec<i8> {
        let signal: Vec<_> = second.iter().map(|&y| Complex64::new(y, 0.0)).collect();
        let decibels = Intensity::new(self.window, self.hop).decibels(&signal, true);
        let pixel = |frame: &Vec<f64>, row: usize| {
            let power = |bin: usize| libm::pow(10.0, frame[bin] / 10.0);
            let db = 10.0 * libm::log10(0.5 * (power(2 * row) + power(2 * row + 1)));
            ((1.0 + db / RANGE_DB).clamp(0.0, 1.0) * 255.0 - 128.0) as i8
        };
        (0..ROWS).flat_map(|row| decibels.iter().map(move |frame| pixel(frame, row))).collect()
    }

    /// The image of every window of a recording.
    pub fn windows(&self, signal: &Signal, label: u8) -> Images {
        let real = match &signal.samples {
            Samples::Real(x) => x.clone(),
            Samples::Complex(z) => z.iter().map(|z| z.re).collect(),
            Samples::Slots(slots) => {
                let slow = slots_without_clutter(slots, RadarConfig::PAPER).unwrap_or_default();
                slow.iter().map(|z| z.re).collect()
            }
        };
        let slow =
            if signal.rate_hz > self.rate_hz { resample(&real, signal.rate_hz, self.rate_hz) } else { real };
        let mut coupled: Vec<_> = slow.into_iter().map(|y| Complex64::new(y, 0.0)).collect();
        ac_couple(&mut coupled, self.rate_hz);
        let real: Vec<f64> = coupled.iter().map(|z| z.re).collect();
        let last = real.len().saturating_sub(self.second());
        let starts: Vec<usize> = (0..=last).step_by(self.second() / 2).collect();
        let each: Vec<Vec<i8>> =
            starts.par_iter().map(|&at| self.image(&real[at..at + self.second()])).collect();
        Images { rows: ROWS, frames: self.frames(), pixels: each.concat(), labels: vec![label; starts.len()] }
    }

    /// Simulated images, `count` of each motion in turn.
    fn simulated(&self, seed: u64, set: u64, count: u32, context: RunContext) -> Images {
        let all = count * Motion::ALL.len() as u32;
        let what = format!("{} GHz at {} Hz, seed {seed}", self.carrier_hz / 1e9, self.rate_hz);
        let stage = context.progress.stage("simulate", &what);
        let motion = |n: u32| Motion::ALL[n as usize % Motion::ALL.len()];
        let each: Vec<Vec<i8>> = (0..all)
            .into_par_iter()
            .map(|n| {
                let index = n / Motion::ALL.len() as u32;
                stage.step(u64::from(all));
                self.image(&draw(self.carrier_hz, self.rate_hz, motion(n), seed, set, index))
            })
            .collect();
        stage.finish(&format!("{all} seconds, {what}"));
        let labels = (0..all).map(|n| motion(n) as u8).collect();
        Images { rows: ROWS, frames: self.frames(), pixels: each.concat(), labels }
    }

    fn preprocessing(&self) -> Preprocessing {
        Preprocessing {
            radar: RadarConfig::PAPER,
            sensing_slots: self.second() as u16,
            first_kept: 1,
            last_kept: 8,
            window_len: self.window as u16,
            hop: self.hop as u16,
            bins_per_row: 1,
            range: 1063,
            kaiser_beta: BETA as f32,
            carrier_khz: (self.carrier_hz / 1e3).round() as u32,
            slow_time_us: (1e6 / self.rate_hz).round() as u32,
        }
    }
}

/// A network of one seed at one carrier.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Recogniser {
    /// Its float parameters.
    pub parameters: Parameters,
    /// Its int8 model file.
    pub model: Vec<u8>,
    /// Share of unseen simulated seconds that it recognises, in float.
    pub simulated: f64,
}

impl Recogniser {
    /// Trains on simulated seconds alone.
    ///
    /// # Errors
    ///
    /// What the training or the quantisation says.
    pub fn learn(request: &Request, layout: Layout, seed: u64, context: RunContext) -> Result<Self, Failure> {
        Self::learn_from(request, layout, seed, (TRAIN, TEST), context)
    }

    fn learn_from(
        request: &Request,
        layout: Layout,
        seed: u64,
        (train, test): (u32, u32),
        context: RunContext,
    ) -> Result<Self, Failure> {
        let learning = &request.scenario.learning;
        let images = layout.simulated(seed, 0, train, context);
        let stage = context.progress.stage("train", &format!("three motions, seed {seed}"));
        let after_epoch = |_: usize, _: &dyn Fn() -> _, _: &[_]| {
            stage.step(u64::from(learning.epochs));
            Ok(())
        };
        let job = training::Job { seed: seed ^ 0x0073_7472, ..Default::default() };
        let images = [images];
        let trained = train_all(&images, &[job], learning, Motion::ALL.len(), context.workers, &after_epoch)?;
        let parameters = trained.into_iter().next().ok_or("no network was trained")?.parameters;
        let names = Motion::ALL.map(|m| m.name().to_owned());
        let (quantized, _) =
            quantize_tuned(&parameters, layout.preprocessing(), &names, &images[0], learning)?;
        let simulated =
            FloatNetwork::new(&parameters).classify(&layout.simulated(seed, 1, test, context)).accuracy();
        stage.finish(&format!("three motions, seed {seed}: {simulated:.3} of unseen simulated seconds"));
        Ok(Recogniser { parameters, model: quantized.to_bytes()?, simulated })
    }
}

/// What networks said about one recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordingResult {
    /// Its path below the folder.
    pub name: String,
    /// What its name says.
    pub motion: Motion,
    /// Windows.
    pub windows: u32,
    /// Windows by answer of the float networks, in the order of [`Motion::ALL`], every seed counted.
    pub answers: [u32; 3],
    /// Share of its windows that is right, float.
    pub float: Spread,
    /// The same by the core's int8 network.
    pub int8: Spread,
    /// The same by the ensemble of the seeds' networks: the sum of their logits.
    pub ensemble: f64,
}

/// The result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SimToReal {
    /// Share of unseen simulated seconds that is recognised.
    pub simulated: Spread,
    /// Every recording.
    pub recordings: Vec<RecordingResult>,
    /// Share of all windows that is right, float.
    pub float: Spread,
    /// The same, int8.
    pub int8: Spread,
    /// The same by the ensemble of the seeds' networks.
    pub ensemble: f64,
    /// Windows `[truth][answer]`, float, every seed counted.
    pub confusion: [[u32; 3]; 3],
}

/// Runs or goes on.
///
/// # Errors
///
/// Whatever a training or the folder says.
pub fn study(
    request: &Request,
    cells: &Cells,
    measured: &[Measured],
    left_out: &mut Vec<LeftOut>,
    context: RunContext,
) -> Result<SimToReal, Failure> {
    let mut confusion = [[0; 3]; 3];
    let mut simulated = Vec::new();
    let mut shares: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut results: Vec<RecordingResult> = Vec::new();
    let mut seen = Vec::new();
    for recording in measured {
        let Some(layout) = Layout::of(&recording.signal) else {
            let reason = format!("recognition: slower than {SLOWEST_HZ} Hz");
            left_out.push((recording.name.clone(), reason));
            continue;
        };
        let images = layout.windows(&recording.signal, recording.motion as u8);
        let (mut answers, mut each) = ([0; 3], Vec::new());
        let mut sums = vec![[0.0_f32; 3]; images.len()];
        for seed in request.each_seed() {
            let name = format!("network-{}-{}-seed-{seed}", layout.carrier_hz / 1e3, layout.rate_hz);
            let network: Recogniser =
                cells.get(&name, || Recogniser::learn(request, layout, seed, context))?;
            if !seen.contains(&name) {
                simulated.push(network.simulated);
                seen.push(name);
            }
            let float = FloatNetwork::new(&network.parameters);
            let mut right = 0;
            for (n, sum) in sums.iter_mut().enumerate() {
                let logits = float.forward(images.image(n), ROWS, &mut |_, _| {});
                sum.iter_mut().zip(&logits).for_each(|(sum, l)| *sum += l);
                let answer = first_maximum(&logits);
                answers[usize::from(answer)] += 1;
                right += usize::from(answer == recording.motion as u8);
            }
            let float = right as f64 / images.len().max(1) as f64;
            let model = std::slice::from_ref(&network.model);
            let int8 = Networks::parse(model, &[layout.second() as u32])?;
            each.push((float, int8.images(std::slice::from_ref(&images)).accuracy(0)));
        }
        let said = format!("{}: {answers:?} of walking, running, still", recording.name);
        context.progress.note("recognise", &said);
        let row: &mut [u32; 3] = &mut confusion[recording.motion as usize];
        row.iter_mut().zip(answers).for_each(|(sum, n)| *sum += n);
        let spread = |of: fn(&(f64, f64)) -> f64| Spread::of(&each.iter().map(of).collect::<Vec<_>>());
        let right = sums.iter().filter(|sum| first_maximum(&sum[..]) == recording.motion as u8).count();
        let ensemble = right as f64 / images.len().max(1) as f64;
        let (name, motion, windows) = (recording.name.clone(), recording.motion, images.len() as u32);
        results.push(RecordingResult {
            name,
            motion,
            windows,
            answers,
            float: spread(|s| s.0),
            int8: spread(|s| s.1),
            ensemble,
        });
        shares.push(each);
    }
    let all: f64 = results.iter().map(|t| f64::from(t.windows)).sum();
    let overall = |of: fn(&(f64, f64)) -> f64| {
        let seed = |s: usize| {
            results.iter().zip(&shares).map(|(t, each)| f64::from(t.windows) * of(&each[s])).sum::<f64>()
                / all.max(1.0)
        };
        Spread::of(&(0..request.seeds as usize).map(seed).collect::<Vec<_>>())
    };
    let (float, int8) = (overall(|s| s.0), overall(|s| s.1));
    let ensemble = results.iter().map(|t| f64::from(t.windows) * t.ensemble).sum::<f64>() / all.max(1.0);
    Ok(SimToReal { simulated: Spread::of(&simulated), recordings: results, float, int8, ensemble, confusion })
}

/// The result in words.
pub fn table(found: &SimToReal) -> String {
    let mut text = format!(
        "\n## From simulation to measurement\n\nNetworks that learned from {TRAIN} simulated seconds of each motion at the recordings' \
         carrier and from nothing measured. Of unseen simulated seconds they recognise {}; of measured ones {} (int8 {}), the ensemble of all seeds (sum of their \
         logits) **{:.3}**. A \
         window is one second, every half second; each is compared with the motion in its file's name, pauses and turns \
         included.\n\n| recording | motion | windows | right | int8 | ensemble |\n|---|---|---|---|---|---|\n",
        found.simulated, found.float, found.int8, found.ensemble
    );
    for t in &found.recordings {
        text += &format!(
            "| {} | {} | {} | {} | {} | {:.3} |\n",
            t.name,
            t.motion.name(),
            t.windows,
            t.float,
            t.int8,
            t.ensemble
        );
    }
    text += "\nWindows, every seed counted:\n\n| truth \\ answer | walking | running | still |\n|---|---|---|---|\n";
    for (motion, [a, b, c]) in Motion::ALL.iter().zip(found.confusion) {
        text += &format!("| {} | {a} | {b} | {c} |\n", motion.name());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Progress;
    use crate::scenario::Scenario;
    use crate::scenario::budget::Budget;

    fn tone(hz: f64, seconds: f64) -> Signal {
        let sample = |n: usize| libm::sin(std::f64::consts::TAU * hz * n as f64 / 44_100.0);
        let samples = Samples::Real((0..(44_100.0 * seconds) as usize).map(sample).collect());
        Signal { samples, rate_hz: 44_100.0, carrier_hz: 24.125e9, title: "tone".into() }
    }

    #[test]
    fn every_half_second_begins_a_window_with_the_label_of_the_file() {
        let signal = tone(300.0, 3.2);
        let layout = Layout::of(&signal).unwrap();
        let images = layout.windows(&signal, Motion::Running as u8);
        // 0, 0.5, 1, 1.5, 2; 79 frames of 64 rows
        assert_eq!((images.len(), images.frames), (5, 79));
        assert!(images.labels.iter().all(|&label| label == 1));
        // 300 Hz of 0..1 kHz in 64 rows: row 19; what lies far from it is black
        let row = |r: usize| images.image(2)[r * 79..(r + 1) * 79].to_vec();
        assert!(row(19).iter().all(|&p| p > 100), "{:?}", row(19));
        assert!(row(40).iter().all(|&p| p == -128), "{:?}", row(40));
    }

    #[test]
    fn level_does_not_matter_and_slow_recordings_have_no_layout() {
        let mut signal = tone(300.0, 2.0);
        let layout = Layout::of(&signal).unwrap();
        let first = layout.windows(&signal, 0);
        if let Samples::Real(x) = &mut signal.samples {
            x.iter_mut().for_each(|x| *x *= 1e-3);
        }
        let second = layout.windows(&signal, 0);
        // but for the rounding of a level at its border
        assert!(second.pixels.iter().zip(&first.pixels).all(|(a, b)| a.abs_diff(*b) <= 1));
        signal.rate_hz = 20.0;
        assert_eq!(Layout::of(&signal), None);
        (signal.rate_hz, signal.carrier_hz) = (48e3, 60e9);
        assert_eq!(Layout::of(&signal).map(|l| l.rate_hz), Some(4000.0));
    }

    #[test]
    fn a_simulated_recording_is_recognised() {
        let mut scenario = Scenario::default();
        (scenario.learning.epochs, scenario.learning.stem_stride) = (8, 2);
        let request = Request { study: "fidelity".into(), seed: 1, seeds: 1, scenario };
        let context = RunContext { progress: Progress::Quiet, workers: 2, budget: Budget::default() };
        let layout = Layout::of(&tone(300.0, 2.0)).unwrap();
        let network = Recogniser::learn_from(&request, layout, 1, (100, 40), context).unwrap();
        assert!(network.simulated > 0.7, "{}", network.simulated);
        // ten seconds of one draw's kind as a file would hold them
        for motion in [Motion::Walking, Motion::Still] {
            let seconds: Vec<f64> = (0..10).flat_map(|n| draw(24.125e9, 2000.0, motion, 9, 2, n)).collect();
            let samples = Samples::Real(seconds);
            let signal = Signal { samples, rate_hz: 2000.0, carrier_hz: 24.125e9, title: "draws".into() };
            let images = layout.windows(&signal, motion as u8);
            let right = FloatNetwork::new(&network.parameters).classify(&images).accuracy();
            assert!(right > 0.6, "{motion:?}: {right}");
        }
    }
}
