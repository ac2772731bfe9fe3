//! The deep spectrogram network against a plain convolutional network and a support vector machine, on the same recordings.
//!
//! Paper, section I: a support vector machine, a convolutional network that did better, and section IV's network. Whether the order
//! holds is asked at every N_s, seed by seed.

use super::cells::Cells;
use super::paired::{Difference, difference, spread};
use super::seeds::DEVELOPMENT_SEED;
use super::trained::{Marked, images, mark, marks, train};
use super::{Request, RunContext, Spread};
use crate::error::Failure;
use crate::network::baselines::Settings;
use crate::network::baselines::cnn::{Cnn, rates, validate};
#[cfg(feature = "svm")]
use crate::network::baselines::svm::{Machine, choose};
use crate::network::evaluation::test;
use crate::network::spectrograms::{Collected, Part};
use crate::scenario::{Class, Learning};
use crate::simulator::calibration::rho_of;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::cell::OnceCell;

/// Names of the methods, in the order of every array here. The support vector machine needs the feature `svm`.
pub const METHODS: &[&str] = if cfg!(feature = "svm") { &["DSN", "CNN", "SVM"] } else { &["DSN", "CNN"] };

/// One N_s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// N_s.
    pub sensing_slots: u32,
    /// Accuracy in float of every method, over the seeds.
    pub accuracy: Vec<Spread>,
    /// Accuracy of every method, seed by seed.
    pub each: Vec<Vec<f64>>,
    /// Accuracy of the first method less that of every other one, on the same recordings.
    pub differences: Vec<Difference>,
    /// The support vector machine's settings.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub machine: Option<Settings>,
    /// Test recordings of a seed.
    pub tested: u32,
}

/// The study's result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Baselines {
    /// AR(1) coefficient rho of the room channel.
    pub rho: f64,
    /// The plain network's learning rate.
    pub rate: Rate,
    /// Rows by N_s.
    pub rows: Vec<Row>,
}

/// A learning rate and how it was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Rate {
    /// The chosen one.
    pub rate: f64,
    /// Every rate that was tried, and how many validation images it got right.
    pub tried: Vec<(f64, usize)>,
}

/// A seed's recordings, drawn when the first cell needs them.
struct Recordings<'a> {
    request: &'a Request,
    rho: f64,
    seed: u64,
    context: RunContext,
    train: OnceCell<Collected>,
    test: OnceCell<Collected>,
}

impl Recordings<'_> {
    fn of(&self, part: Part) -> &Collected {
        let cell = if part == Part::Test { &self.test } else { &self.train };
        cell.get_or_init(|| images(&self.request.scenario, self.rho, self.seed, part, self.context))
    }

    /// The plain network's learning rate, found on training recordings at the largest N_s.
    fn rate(&self) -> Result<Rate, Failure> {
        let learning = &self.request.scenario.learning;
        let train = self.of(Part::Train).images.last().ok_or("no sensing slots")?;
        let rates = rates(learning);
        let stage = self.context.progress.stage("train", "the plain network's learning rate");
        let total = rates.len() as u64 * u64::from(learning.epochs);
        let mut tried = Vec::new();
        for rate in rates {
            let learning = Learning { learning_rate: rate, ..learning.clone() };
            let (seed, workers) = (self.seed, self.context.workers);
            let right = validate(train, &learning, Class::ALL.len(), seed, workers, &|| stage.step(total))?;
            tried.push((rate, right));
        }
        let (rate, _) = tried.iter().fold(tried[0], |best, &now| if now.1 > best.1 { now } else { best });
        stage.finish(&format!("the plain network learns at {rate}"));
        Ok(Rate { rate, tried })
    }

    /// The support vector machine's settings, by cross-validation on training recordings.
    #[cfg(feature = "svm")]
    fn settings(&self, n: usize) -> Result<Settings, Failure> {
        let stage = self.context.progress.stage("train", "the support vector machine's settings");
        let found = choose(&self.of(Part::Train).images[n])?;
        let slots = self.request.scenario.frame.sensing_slots[n];
        stage.finish(&format!("C = {}, gamma = {:.3e} at N_s = {slots}", found.c, found.gamma));
        Ok(found)
    }

    fn dsn(&self) -> Result<Marked, Failure> {
        let s = &self.request.scenario;
        let trained = train(s, self.seed, self.of(Part::Train), self.context)?;
        let shown = &self.of(Part::Test).images;
        let tested = test(&trained.parameters, &trained.models, &s.frame.sensing_slots, shown)?;
        Ok(tested
            .iter()
            .zip(shown)
            .map(|(tested, shown)| mark(&tested.float.classes, &shown.labels))
            .collect())
    }

    fn cnn(&self, n: usize, rate: f64) -> Result<String, Failure> {
        let s = &self.request.scenario;
        let learning = Learning { learning_rate: rate, ..s.learning.clone() };
        let slots = s.frame.sensing_slots[n];
        let stage = self.context.progress.stage("train", "a plain network");
        let tick = || stage.step(u64::from(learning.epochs));
        let (seed, workers) = (self.seed ^ (u64::from(slots) << 32), self.context.workers);
        let train = &self.of(Part::Train).images[n];
        let network = Cnn::train(train, &learning, Class::ALL.len(), seed, workers, &tick)?;
        let shown = &self.of(Part::Test).images[n];
        let found = mark(&network.classify(shown, workers)?, &shown.labels);
        stage.finish(&format!("plain network, N_s = {slots}, seed {}", self.seed));
        Ok(found)
    }

    #[cfg(feature = "svm")]
    fn svm(&self, n: usize, settings: Settings) -> Result<String, Failure> {
        let stage = self.context.progress.stage("train", "a support vector machine");
        let (train, shown) = (&self.of(Part::Train).images[n], &self.of(Part::Test).images[n]);
        let found = mark(&Machine::train(train, settings)?.classify(shown), &shown.labels);
        let slots = self.request.scenario.frame.sensing_slots[n];
        stage.finish(&format!("support vector machine, N_s = {slots}, seed {}", self.seed));
        Ok(found)
    }
}

/// Runs or goes on. What cannot be known before is chosen on training recordings of [`DEVELOPMENT_SEED`].
///
/// # Errors
///
/// Whatever a training or the folder says.
pub fn study(request: &Request, cells: &Cells, context: RunContext) -> Result<Baselines, Failure> {
    let s = &request.scenario;
    let slots = &s.frame.sensing_slots;
    let rho = rho_of(s);
    let recordings = |seed: u64| {
        let (train, test) = (OnceCell::new(), OnceCell::new());
        Recordings { request, rho, seed, context, train, test }
    };
    let development = recordings(DEVELOPMENT_SEED);
    let rate = cells.get("cnn-rate", || development.rate())?;
    #[cfg(feature = "svm")]
    let settings: Vec<Settings> = (0..slots.len())
        .map(|n| cells.get(&format!("svm-settings-{}", slots[n]), || development.settings(n)))
        .collect::<Result<_, _>>()?;
    drop(development);
    // marks of every method, `[method][seed][sensing_slots]`
    let mut kept: Vec<Vec<Marked>> = vec![Vec::new(); METHODS.len()];
    for seed in request.each_seed() {
        let recordings = recordings(seed);
        kept[0].push(cells.get(&format!("seed-{seed}-dsn"), || recordings.dsn())?);
        let name = |method: &str, n: usize| format!("seed-{seed}-{method}-{}", slots[n]);
        let cnn = |n| cells.get(&name("cnn", n), || recordings.cnn(n, rate.rate));
        kept[1].push((0..slots.len()).map(cnn).collect::<Result<_, _>>()?);
        #[cfg(feature = "svm")]
        {
            let svm = |n| cells.get(&name("svm", n), || recordings.svm(n, settings[n]));
            kept[2].push((0..slots.len()).map(svm).collect::<Result<_, _>>()?);
        }
    }
    let row = |(n, &sensing_slots): (usize, &u32)| {
        let marks: Vec<_> = kept.iter().map(|seeds| marks(seeds, n)).collect();
        let share = |marks: &Vec<bool>| spread(std::slice::from_ref(marks)).mean;
        Row {
            sensing_slots,
            accuracy: marks.iter().map(|marks| spread(marks)).collect(),
            each: marks.iter().map(|seeds| seeds.iter().map(share).collect()).collect(),
            differences: marks[1..].iter().map(|other| difference(&marks[0], other, request.seed)).collect(),
            #[cfg(feature = "svm")]
            machine: Some(settings[n]),
            #[cfg(not(feature = "svm"))]
            machine: None,
            tested: marks[0].first().map_or(0, Vec::len) as u32,
        }
    };
    let found = Baselines { rho, rate, rows: slots.iter().enumerate().map(row).collect() };
    cells.output.write_result("baselines.json", &found)?;
    cells.output.write("baselines.md", table(request, &found).as_bytes())?;
    Ok(found)
}

/// The result in words.
pub fn table(request: &Request, found: &Baselines) -> String {
    let l = &request.scenario.learning;
    let mut text = format!(
        "# The network and its baselines\n\n{:.3} GHz, rho = {}, heading within {} degrees, {} \
         recordings per class to train, {} new ones to test, {}, {} epochs, C = {}, stem stride {}. Accuracy in \
         float. DSN: the deep spectrogram network. CNN: its convolutions without skips and normalisation, learning rate {} (of {} \
         tried).",
        request.scenario.radar.carrier_hz / 1e9,
        found.rho,
        request.scenario.target.heading_spread_deg,
        l.train_per_class,
        l.test_per_class,
        request.seeds_label(),
        l.epochs,
        l.channels,
        l.stem_stride,
        found.rate.rate,
        found.rate.tried.len()
    );
    text += match METHODS.len() {
        3 => {
            " SVM: Gaussian kernel on mean, deviation, largest and smallest intensity of every Doppler row, C and gamma by \
             cross-validation."
        }
        _ => " This build has no support vector machine (feature `svm`).",
    };
    text += &format!(
        " Both were chosen on training recordings of seed {DEVELOPMENT_SEED}. Differences in points, on the same recordings, with their \
         95 % interval by bootstrap draws of seeds and recordings.\n\n"
    );
    let others: Vec<String> =
        METHODS[1..].iter().map(|method| format!("{} - {method}", METHODS[0])).collect();
    let columns = METHODS.len() + others.len();
    text += &format!(
        "| N_s | {} | {} |\n|---|{}\n",
        METHODS.join(" | "),
        others.join(" | "),
        "---|".repeat(columns)
    );
    for row in &found.rows {
        let mut cells: Vec<String> = row.accuracy.iter().map(Spread::to_string).collect();
        cells.extend(row.differences.iter().map(Difference::to_string));
        text += &format!("| {} | {} |\n", row.sensing_slots, cells.join(" | "));
    }
    text
}
