//! From simulation to measurement: networks that learned from simulated Doppler alone classify measured walking, running and still.
//!
//! The networks learn from draws of [`crate::simulator::randomised`]; no measured sample is learned from. Every second of a recording
//! has the motion of the recording's name, pauses and changes of direction included; seconds do not overlap. Baselines are scored on the same seconds:
//! the majority class, the same networks on white noise, networks that learned from the other recordings (leave one recording out), and
//! with the feature `svm` a support vector machine on simulated seconds. Networks are also fine-tuned on the other recordings. The
//! model of the first seed is written for each carrier and rate: `sdp3 classify` takes it.

mod recogniser;
mod seconds;

use super::cells::Cells;
use super::labelled::{LeftOut, Measured, left_out_section};
use super::score::{Predictions, balanced_accuracy};
use super::{Request, RunContext, Spread};
use crate::error::Failure;
#[cfg(feature = "svm")]
use crate::network::baselines::svm::{Machine, choose};
use crate::network::float_network::first_maximum;
use crate::network::parameters::{Images, Parameters};
use crate::results::Estimate;
use crate::simulator::randomised::Motion;
use crate::store::digest::sha256;
use recogniser::Recogniser;
use schemars::JsonSchema;
use seconds::{Layout, SLOWEST_HZ};
use serde::{Deserialize, Serialize};

/// Simulated seconds of each motion to learn from, for every recording that the scenario learns from.
const SECONDS: u32 = 6;
/// Part of them that the support vector machine learns from: its time grows with their square.
#[cfg(feature = "svm")]
const MACHINE_PART: u32 = 4;
/// The prediction of a network that has nothing to learn from: no motion.
const NO_MOTION: u8 = u8::MAX;

/// A method, and its predictions for the seconds of a recording, `[network][second]`.
type Predicted = (&'static str, Vec<Vec<u8>>);

/// The score of a method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Score {
    /// The method.
    pub method: String,
    /// Balanced accuracy: the mean over the motions of the share of their seconds that is recognised.
    pub balanced: Estimate,
    /// Share of every recording's seconds that is recognised.
    pub recordings: Vec<f64>,
}

/// A recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Recording {
    /// Its path below the folder.
    pub name: String,
    /// What its name says.
    pub motion: Motion,
    /// Seconds.
    pub seconds: u32,
}

/// The result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SimToReal {
    /// Share of unseen simulated seconds that the float networks recognise.
    pub simulated: Spread,
    /// Every recording.
    pub recordings: Vec<Recording>,
    /// Every method, the int8 networks first.
    pub scores: Vec<Score>,
    /// Seconds `[motion][predicted]` of the int8 networks, every seed counted, in the order walking, running, still.
    pub confusion: [[u32; 3]; 3],
    /// Files not used, and why.
    pub left_out: Vec<LeftOut>,
}

/// Simulated seconds of each motion to learn from.
fn training_seconds(request: &Request) -> u32 {
    SECONDS * request.scenario.learning.train_per_class
}

/// A recording with the images of its seconds.
struct Labelled<'a> {
    measured: &'a Measured,
    layout: Layout,
    images: Images,
}

/// The study.
struct Work<'a> {
    request: &'a Request,
    cells: &'a Cells<'a>,
    context: RunContext,
    recordings: Vec<Labelled<'a>>,
}

impl Work<'_> {
    fn network(&self, layout: &Layout, seed: u64) -> Result<Recogniser, Failure> {
        self.cells.get(&format!("network-{layout}-seed-{seed}"), || {
            let images = layout.simulated(seed, 0, training_seconds(self.request), self.context);
            Recogniser::learn(self.request, layout, images, None, seed, self.context)
        })
    }

    /// Share of unseen simulated seconds that a network recognises, in float.
    fn simulated(&self, layout: &Layout, seed: u64) -> Result<f64, Failure> {
        self.cells.get(&format!("simulated-{layout}-seed-{seed}"), || {
            let count = self.request.scenario.learning.test_per_class;
            let images = layout.simulated(seed, 1, count, self.context);
            let predicted = self.network(layout, seed)?.float(&images);
            let correct =
                predicted.iter().zip(&images.labels).filter(|(predicted, label)| predicted == label);
            Ok(correct.count() as f64 / images.len() as f64)
        })
    }

    /// Predictions for a recording by a network that learned from all other recordings of its layout, after the simulated seconds
    /// (`fine-tuned`) or alone (`leave-out`).
    fn leave_out(
        &self,
        how: &str,
        start: Option<&Parameters>,
        recording: &Labelled<'_>,
        seed: u64,
    ) -> Result<Vec<u8>, Failure> {
        let layout = &recording.layout;
        let mut images = Images { labels: Vec::new(), pixels: Vec::new(), ..recording.images.clone() };
        let mut keys = vec![recording.measured.key.as_bytes()];
        for Labelled { measured, .. } in self
            .recordings
            .iter()
            .filter(|r| r.layout == *layout && r.measured.name != recording.measured.name)
        {
            // overlapping seconds, each an image of its own
            let seconds = layout.seconds(&measured.signal, layout.second() / 8, measured.motion as u8);
            images.pixels.extend(seconds.pixels);
            images.labels.extend(seconds.labels);
            keys.push(measured.key.as_bytes());
        }
        if images.is_empty() {
            return Ok(vec![NO_MOTION; recording.images.len()]);
        }
        self.cells.get(&format!("{how}-{}-seed-{seed}", &sha256(keys)[..12]), || {
            let network = Recogniser::learn(self.request, layout, images, start, seed, self.context)?;
            network.int8(layout, &recording.images)
        })
    }

    /// Predictions of the support vector machine of a layout for all of its recordings, in their order.
    #[cfg(feature = "svm")]
    fn machine(&self, layout: &Layout) -> Result<Vec<Vec<u8>>, Failure> {
        let of_layout = || self.recordings.iter().filter(|r| r.layout == *layout);
        let keys = sha256(of_layout().map(|r| r.measured.key.as_bytes()));
        self.cells.get(&format!("machine-{layout}-{}", &keys[..12]), || {
            let count = training_seconds(self.request) / MACHINE_PART;
            let images = layout.simulated(self.request.seed, 0, count, self.context);
            let machine = Machine::train(&images, choose(&images).map_err(|e| e.to_string())?);
            let machine = machine.map_err(|e| e.to_string())?;
            Ok(of_layout().map(|r| machine.classify(&r.images)).collect())
        })
    }

    /// The predictions of every method for a recording, the int8 networks first.
    fn predictions(&self, recording: &Labelled<'_>, majority: Motion) -> Result<Vec<Predicted>, Failure> {
        let (layout, images) = (&recording.layout, &recording.images);
        let [mut int8, mut float, mut noise, mut leave_out, mut fine_tuned] = [const { Vec::new() }; 5];
        let mut sums = vec![[0.0_f32; 3]; images.len()];
        for seed in self.request.each_seed() {
            let network = self.network(layout, seed)?;
            let logits = network.logits(images);
            for (sum, logits) in sums.iter_mut().zip(&logits) {
                sum.iter_mut().zip(logits).for_each(|(sum, logit)| *sum += logit);
            }
            int8.push(network.int8(layout, images)?);
            float.push(logits.iter().map(|logits| first_maximum(logits)).collect());
            noise.push(network.int8(layout, &layout.noise(seed, images.len() as u32))?);
            leave_out.push(self.leave_out("leave-out", None, recording, seed)?);
            fine_tuned.push(self.leave_out("fine-tuned", Some(&network.parameters), recording, seed)?);
        }
        #[allow(unused_mut, reason = "with the feature `svm` there is one more")]
        let mut all = vec![
            ("network, int8", int8),
            ("network, float", float),
            ("ensemble: sum of the seeds' logits", vec![sums.iter().map(|sum| first_maximum(sum)).collect()]),
            ("majority class", vec![vec![majority as u8; images.len()]]),
            ("network, int8, on white noise", noise),
            ("network, int8, leave one recording out", leave_out),
            ("network, int8, fine-tuned, leave one recording out", fine_tuned),
        ];
        #[cfg(feature = "svm")]
        {
            let before = self.recordings.iter().take_while(|r| r.measured.name != recording.measured.name);
            let index = before.filter(|r| r.layout == *layout).count();
            all.push(("support vector machine", vec![self.machine(layout)?.swap_remove(index)]));
        }
        Ok(all)
    }
}

/// Runs or goes on.
///
/// # Errors
///
/// No recording that is fast enough; whatever a training or the folder says.
pub fn study(
    request: &Request,
    cells: &Cells,
    (recordings, mut left_out): (Vec<Measured>, Vec<LeftOut>),
    context: RunContext,
) -> Result<SimToReal, Failure> {
    let mut labelled = Vec::new();
    for measured in &recordings {
        let layout = Layout::of(&measured.signal);
        let images = layout.map(|l| {
            let images = l.seconds(&measured.signal, l.second(), measured.motion as u8);
            (l, images)
        });
        match images {
            Some((layout, images)) if !images.is_empty() => {
                labelled.push(Labelled { measured, layout, images });
            }
            Some(_) => left_out.push((measured.name.clone(), "shorter than a second".into())),
            None => left_out.push((measured.name.clone(), format!("slower than {SLOWEST_HZ} Hz"))),
        }
    }
    if labelled.is_empty() {
        return Err("--measured: no recording is a second long and fast enough".into());
    }
    let seconds = |motion| -> usize {
        labelled.iter().filter(|r| r.measured.motion == motion).map(|r| r.images.len()).sum()
    };
    // the first of equals
    let majority = Motion::ALL.into_iter().rev().max_by_key(|&motion| seconds(motion));
    let majority = majority.unwrap_or(Motion::Walking);
    let work = Work { request, cells, context, recordings: labelled };
    let predicted: Vec<Vec<Predicted>> =
        work.recordings.iter().map(|r| work.predictions(r, majority)).collect::<Result<_, _>>()?;
    let mut simulated = Vec::new();
    let mut layouts: Vec<&Layout> = Vec::new();
    for recording in &work.recordings {
        if !layouts.contains(&&recording.layout) {
            layouts.push(&recording.layout);
            for seed in request.each_seed() {
                simulated.push(work.simulated(&recording.layout, seed)?);
            }
            let first = work.network(&recording.layout, request.seed)?;
            cells.output.write(&format!("models/motions-{}.sdp3", recording.layout), &first.model)?;
        }
    }
    let score = |(m, (method, _)): (usize, &Predicted)| {
        let of = |(recording, methods): (&Labelled<'_>, &Vec<Predicted>)| Predictions {
            label: recording.measured.motion as u8,
            each: methods[m].1.clone(),
        };
        let all: Vec<Predictions> = work.recordings.iter().zip(&predicted).map(of).collect();
        Score {
            method: (*method).to_owned(),
            balanced: balanced_accuracy(&all, request.seed),
            recordings: all.iter().map(Predictions::share).collect(),
        }
    };
    let mut confusion = [[0; 3]; 3];
    for (recording, methods) in work.recordings.iter().zip(&predicted) {
        let row: &mut [u32; 3] = &mut confusion[recording.measured.motion as usize];
        methods[0].1.iter().flatten().for_each(|&motion| row[usize::from(motion)] += 1);
    }
    let recording = |r: &Labelled<'_>| Recording {
        name: r.measured.name.clone(),
        motion: r.measured.motion,
        seconds: r.images.len() as u32,
    };
    let found = SimToReal {
        simulated: Spread::of(&simulated),
        recordings: work.recordings.iter().map(recording).collect(),
        scores: predicted[0].iter().enumerate().map(score).collect(),
        confusion,
        left_out,
    };
    cells.output.write_result("sim-to-real.json", &found)?;
    cells.output.write("sim-to-real.md", table(request, &found).as_bytes())?;
    Ok(found)
}

/// The result in words.
pub fn table(request: &Request, found: &SimToReal) -> String {
    let mut text = format!(
        "# From simulation to measurement\n\nNetworks that learned from {} simulated seconds of each motion at the recordings' carrier \
         and from nothing measured, {}. Of unseen simulated seconds they recognise {}. Balanced accuracy: the mean over the motions of \
         the share of their seconds that is recognised; in brackets its 95 % interval by redrawn recordings, seconds and networks.\n\n",
        training_seconds(request),
        request.seeds_label(),
        found.simulated
    );
    let names: Vec<String> = found
        .recordings
        .iter()
        .map(|r| format!("{} ({}, {} s)", r.name, r.motion.name(), r.seconds))
        .collect();
    text += &format!("| method | balanced accuracy | {} |\n", names.join(" | "));
    text += &format!("|---|---|{}\n", "---|".repeat(names.len()));
    for score in &found.scores {
        let Estimate { mean, low, high } = score.balanced;
        let shares: Vec<String> = score.recordings.iter().map(|share| format!("{share:.3}")).collect();
        text += &format!("| {} | {mean:.3} [{low:.3}, {high:.3}] | {} |\n", score.method, shares.join(" | "));
    }
    text += "\nSeconds by the int8 networks, every seed counted:\n\n| motion \\ predicted | walking | running | still |\n|---|---|---|---|\n";
    for (motion, [a, b, c]) in Motion::ALL.iter().zip(found.confusion) {
        text += &format!("| {} | {a} | {b} | {c} |\n", motion.name());
    }
    text + &left_out_section(&found.left_out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Progress;
    use crate::recordings::{Samples, Signal};
    use crate::scenario::Scenario;
    use crate::scenario::budget::Budget;
    use crate::simulator::randomised::draw;

    #[test]
    fn a_simulated_recording_is_recognised() {
        let mut scenario = Scenario::default();
        (scenario.learning.epochs, scenario.learning.stem_stride) = (8, 2);
        let request = Request { study: "sim-to-real".into(), seed: 1, seeds: 1, scenario };
        let context = RunContext { progress: Progress::Quiet, workers: 2, budget: Budget::default() };
        // ten seconds of one draw's kind as a file would hold them
        let signal = |motion| {
            let seconds: Vec<f64> = (0..10).flat_map(|n| draw(24.125e9, 2000.0, motion, 9, 2, n)).collect();
            let samples = Samples::Real(seconds);
            Signal {
                samples,
                rate_hz: 2000.0,
                carrier_hz: 24.125e9,
                title: "draws".into(),
                power_db: 0.0,
                about: Default::default(),
            }
        };
        let layout = Layout::of(&signal(Motion::Still)).unwrap();
        let images = layout.simulated(1, 0, 100, context);
        let network = Recogniser::learn(&request, &layout, images, None, 1, context).unwrap();
        for motion in [Motion::Walking, Motion::Still] {
            let images = layout.seconds(&signal(motion), layout.second(), motion as u8);
            assert_eq!(images.len(), 10);
            for predicted in [network.float(&images), network.int8(&layout, &images).unwrap()] {
                let correct = predicted.iter().filter(|&&predicted| predicted == motion as u8).count();
                assert!(correct > 6, "{motion:?}: {predicted:?}");
            }
        }
    }
}
