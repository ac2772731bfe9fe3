//! From simulation to measurement: networks that learned from simulated Doppler alone classify measured walking, running and still.
//!
//! The networks learn from draws of [`crate::simulator::randomised`]; no measured sample is learned from. Every second of a recording
//! has the motion of the recording's name, pauses and turns included; seconds do not overlap. Other ways to answer stand beside them
//! ([`METHODS`]).

mod recogniser;
mod score;
mod seconds;

use super::cells::Cells;
use super::labelled::{LeftOut, Measured};
use super::{Request, RunContext, Spread};
use crate::error::Failure;
#[cfg(feature = "svm")]
use crate::network::baselines::svm::{Machine, choose};
use crate::network::float_network::first_maximum;
use crate::network::parameters::Images;
use crate::results::Estimate;
use crate::simulator::randomised::Motion;
use crate::store::digest::sha256;
use recogniser::Recogniser;
use schemars::JsonSchema;
use score::{Answers, balanced_accuracy};
use seconds::{Layout, SLOWEST_HZ};
use serde::{Deserialize, Serialize};

/// Simulated seconds of each motion to learn from, for every recording that the scenario learns from; and the machine's share of them.
const SECONDS: u32 = 6;
#[cfg(feature = "svm")]
const MACHINE_SHARE: u32 = 4;

/// Ways to answer; the support vector machine needs the feature `svm`.
pub const METHODS: &[&str] = &[
    "network, int8",
    "network, float",
    "ensemble: the sum of the seeds' logits",
    "always the most frequent motion",
    "network, shown white noise instead",
    "network that learned from the other recordings",
    #[cfg(feature = "svm")]
    "support vector machine on the same simulated seconds",
];

/// What one way to answer scores.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Score {
    /// The way.
    pub method: String,
    /// Balanced accuracy: the mean over the motions of the share of their seconds that is right.
    pub balanced: Estimate,
    /// Share of every recording's seconds that is right.
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
    /// Every way to answer.
    pub scores: Vec<Score>,
    /// Seconds `[truth][answer]` of the int8 networks, every seed counted, in the order walking, running, still.
    pub confusion: [[u32; 3]; 3],
    /// Files not used, and why.
    pub left_out: Vec<LeftOut>,
}

/// Simulated seconds of each motion to learn from.
fn learned(request: &Request) -> u32 {
    SECONDS * request.scenario.learning.train_per_class
}

/// A recording with its images.
struct Shown<'a> {
    measured: &'a Measured,
    layout: Layout,
    images: Images,
}

/// The study.
struct Work<'a> {
    request: &'a Request,
    cells: &'a Cells<'a>,
    context: RunContext,
    shown: Vec<Shown<'a>>,
}

impl Work<'_> {
    fn network(&self, layout: Layout, seed: u64) -> Result<Recogniser, Failure> {
        self.cells.get(&format!("network-{layout}-seed-{seed}"), || {
            let images = layout.simulated(seed, 0, learned(self.request), self.context);
            Recogniser::learn(self.request, layout, images, seed, self.context)
        })
    }

    fn simulated(&self, layout: Layout, seed: u64) -> Result<f64, Failure> {
        self.cells.get(&format!("simulated-{layout}-seed-{seed}"), || {
            let images =
                layout.simulated(seed, 1, self.request.scenario.learning.test_per_class, self.context);
            let answers = self.network(layout, seed)?.float(&images);
            let right = answers.iter().zip(&images.labels).filter(|(answer, label)| answer == label);
            Ok(right.count() as f64 / images.len() as f64)
        })
    }

    /// Answers to a recording of a network that learned from all others of its layout; of none if there are no others.
    fn left_out(&self, shown: &Shown<'_>, seed: u64) -> Result<Vec<u8>, Failure> {
        let others: Vec<&Shown<'_>> = self
            .shown
            .iter()
            .filter(|other| other.layout == shown.layout && other.measured.name != shown.measured.name)
            .collect();
        let mut theirs = Images { labels: Vec::new(), pixels: Vec::new(), ..shown.images.clone() };
        for other in &others {
            // overlapping seconds, each an image of its own
            let step = shown.layout.second() / 8;
            let images = shown.layout.seconds(&other.measured.signal, step, other.measured.motion as u8);
            theirs.pixels.extend(images.pixels);
            theirs.labels.extend(images.labels);
        }
        if theirs.is_empty() {
            return Ok(vec![u8::MAX; shown.images.len()]);
        }
        let keys = others.iter().map(|other| other.measured.key.as_bytes());
        let all = sha256(keys.chain([shown.measured.key.as_bytes()]));
        self.cells.get(&format!("others-{}-seed-{seed}", &all[..12]), || {
            let network = Recogniser::learn(self.request, shown.layout, theirs, seed, self.context)?;
            network.int8(shown.layout, &shown.images)
        })
    }

    #[cfg(feature = "svm")]
    fn machine(&self, shown: &Shown<'_>) -> Result<Vec<u8>, Failure> {
        let name = format!("machine-{}-{}", shown.layout, shown.measured.key);
        self.cells.get(&name, || {
            let images = shown.layout.simulated(
                self.request.seed,
                0,
                learned(self.request) / MACHINE_SHARE,
                self.context,
            );
            let machine = Machine::train(&images, choose(&images).map_err(|e| e.to_string())?);
            Ok(machine.map_err(|e| e.to_string())?.classify(&shown.images))
        })
    }

    /// The answers of every method to a recording, `[method][network][second]`.
    fn answers(&self, shown: &Shown<'_>, most: Motion) -> Result<Vec<Vec<Vec<u8>>>, Failure> {
        let (layout, images) = (shown.layout, &shown.images);
        let mut found = vec![Vec::new(); METHODS.len()];
        let mut sums = vec![[0.0_f32; 3]; images.len()];
        for seed in self.request.each_seed() {
            let network = self.network(layout, seed)?;
            let logits = network.logits(images);
            for (sum, logits) in sums.iter_mut().zip(&logits) {
                sum.iter_mut().zip(logits).for_each(|(sum, logit)| *sum += logit);
            }
            found[0].push(network.int8(layout, images)?);
            found[1].push(logits.iter().map(|logits| first_maximum(logits)).collect());
            found[4].push(network.int8(layout, &layout.noise(seed, images.len() as u32))?);
            found[5].push(self.left_out(shown, seed)?);
        }
        found[2].push(sums.iter().map(|sum| first_maximum(sum)).collect());
        found[3].push(vec![most as u8; images.len()]);
        #[cfg(feature = "svm")]
        found[6].push(self.machine(shown)?);
        Ok(found)
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
    let mut shown = Vec::new();
    for measured in &recordings {
        let layout = Layout::of(&measured.signal);
        let images = layout.map(|l| (l, l.seconds(&measured.signal, l.second(), measured.motion as u8)));
        match images {
            Some((layout, images)) if !images.is_empty() => shown.push(Shown { measured, layout, images }),
            Some(_) => left_out.push((measured.name.clone(), "shorter than a second".into())),
            None => left_out.push((measured.name.clone(), format!("slower than {SLOWEST_HZ} Hz"))),
        }
    }
    if shown.is_empty() {
        return Err("--measured: no recording is a second long and fast enough".into());
    }
    let count = |motion| -> usize {
        shown.iter().filter(|s| s.measured.motion == motion).map(|s| s.images.len()).sum()
    };
    // the first of equals
    let most = Motion::ALL.into_iter().rev().max_by_key(|&motion| count(motion)).unwrap_or(Motion::Walking);
    let work = Work { request, cells, context, shown };
    let each = work.shown.iter().map(|shown| work.answers(shown, most)).collect::<Result<Vec<_>, _>>()?;
    let mut simulated = Vec::new();
    let mut layouts: Vec<Layout> = Vec::new();
    for shown in &work.shown {
        if !layouts.contains(&shown.layout) {
            layouts.push(shown.layout);
            for seed in request.each_seed() {
                simulated.push(work.simulated(shown.layout, seed)?);
            }
        }
    }
    let score = |(m, method): (usize, &&str)| {
        let of = |(shown, answers): (&Shown<'_>, &Vec<Vec<Vec<u8>>>)| Answers {
            motion: shown.measured.motion,
            each: answers[m].clone(),
        };
        let answers: Vec<Answers> = work.shown.iter().zip(&each).map(of).collect();
        Score {
            method: (*method).to_owned(),
            balanced: balanced_accuracy(&answers, request.seed),
            recordings: answers.iter().map(Answers::share).collect(),
        }
    };
    let mut confusion = [[0; 3]; 3];
    for (shown, answers) in work.shown.iter().zip(&each) {
        let row: &mut [u32; 3] = &mut confusion[shown.measured.motion as usize];
        answers[0].iter().flatten().for_each(|&answer| row[usize::from(answer)] += 1);
    }
    let recording = |shown: &Shown<'_>| Recording {
        name: shown.measured.name.clone(),
        motion: shown.measured.motion,
        seconds: shown.images.len() as u32,
    };
    let found = SimToReal {
        simulated: Spread::of(&simulated),
        recordings: work.shown.iter().map(recording).collect(),
        scores: METHODS.iter().enumerate().map(score).collect(),
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
         the share of their seconds that is right; in brackets its 95 % interval by redrawn recordings, seconds and networks.\n\n",
        learned(request),
        request.seeds_label(),
        found.simulated
    );
    let names: Vec<String> = found
        .recordings
        .iter()
        .map(|r| format!("{} ({}, {} s)", r.name, r.motion.name(), r.seconds))
        .collect();
    text += &format!("| answers | balanced accuracy | {} |\n", names.join(" | "));
    text += &format!("|---|---|{}\n", "---|".repeat(names.len()));
    for score in &found.scores {
        let Estimate { mean, low, high } = score.balanced;
        let shares: Vec<String> = score.recordings.iter().map(|share| format!("{share:.3}")).collect();
        text += &format!("| {} | {mean:.3} [{low:.3}, {high:.3}] | {} |\n", score.method, shares.join(" | "));
    }
    text += "\nSeconds by the int8 networks, every seed counted:\n\n| truth \\ answer | walking | running | still |\n|---|---|---|---|\n";
    for (motion, [a, b, c]) in Motion::ALL.iter().zip(found.confusion) {
        text += &format!("| {} | {a} | {b} | {c} |\n", motion.name());
    }
    if !found.left_out.is_empty() {
        text += "\n## Left out\n\n";
        found.left_out.iter().for_each(|(name, why)| text += &format!("- {name}: {why}\n"));
    }
    text
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
            Signal { samples, rate_hz: 2000.0, carrier_hz: 24.125e9, title: "draws".into() }
        };
        let layout = Layout::of(&signal(Motion::Still)).unwrap();
        let images = layout.simulated(1, 0, 100, context);
        let network = Recogniser::learn(&request, layout, images, 1, context).unwrap();
        for motion in [Motion::Walking, Motion::Still] {
            let images = layout.seconds(&signal(motion), layout.second(), motion as u8);
            assert_eq!(images.len(), 10);
            let answers = [network.float(&images), network.int8(layout, &images).unwrap()];
            for answers in answers {
                let right = answers.iter().filter(|&&answer| answer == motion as u8).count();
                assert!(right > 6, "{motion:?}: {answers:?}");
            }
        }
    }
}
