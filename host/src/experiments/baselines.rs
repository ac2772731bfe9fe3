//! The deep spectrogram network against a plain convolutional network and a support vector machine, on the same recordings.
//!
//! Paper, section I: a support vector machine, a convolutional network that did better, and section IV's network. Whether the order
//! holds is asked at every N_s, seed by seed.

use super::cells::Cells;
use super::trained::{images, train};
use super::{Request, RunContext, Spread};
use crate::error::Failure;
use crate::network::baselines::Settings;
use crate::network::baselines::accuracy;
use crate::network::baselines::cnn::{Cnn, rates, validate};
#[cfg(feature = "svm")]
use crate::network::baselines::svm::{Machine, choose};
use crate::network::spectrograms::{Collected, Part};
use crate::results::Accuracy;
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
    /// The support vector machine's settings, seed by seed.
    pub machines: Vec<Settings>,
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

/// What the machine got right, and with which settings.
#[cfg(feature = "svm")]
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Vectors {
    accuracy: f64,
    settings: Settings,
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

    fn dsn(&self) -> Result<Vec<Accuracy>, Failure> {
        let s = &self.request.scenario;
        train(s, self.seed, self.of(Part::Train), self.context)?.test(s, self.of(Part::Test))
    }

    fn cnn(&self, n: usize, rate: f64) -> Result<f64, Failure> {
        let s = &self.request.scenario;
        let learning = Learning { learning_rate: rate, ..s.learning.clone() };
        let slots = s.frame.sensing_slots[n];
        let stage = self.context.progress.stage("train", "a plain network");
        let tick = || stage.step(u64::from(learning.epochs));
        let (seed, workers) = (self.seed ^ (u64::from(slots) << 32), self.context.workers);
        let images = &self.of(Part::Train).images[n];
        let network = Cnn::train(images, &learning, Class::ALL.len(), seed, workers, &tick)?;
        let test = &self.of(Part::Test).images[n];
        let found = accuracy(&network.classify(test, workers)?, test);
        stage.finish(&format!("plain network, N_s = {slots}, seed {}: {found:.3}", self.seed));
        Ok(found)
    }

    #[cfg(feature = "svm")]
    fn svm(&self, n: usize) -> Result<Vectors, Failure> {
        let stage = self.context.progress.stage("train", "a support vector machine");
        let (train, test) = (&self.of(Part::Train).images[n], &self.of(Part::Test).images[n]);
        let settings = choose(train)?;
        let accuracy = accuracy(&Machine::train(train, settings)?.classify(test), test);
        let slots = self.request.scenario.frame.sensing_slots[n];
        stage.finish(&format!("support vector machine, N_s = {slots}, seed {}: {accuracy:.3}", self.seed));
        Ok(Vectors { accuracy, settings })
    }
}

/// Runs or goes on.
///
/// # Errors
///
/// Whatever a training or the folder says.
pub fn study(request: &Request, cells: &Cells, context: RunContext) -> Result<Baselines, Failure> {
    let s = &request.scenario;
    let slots = &s.frame.sensing_slots;
    let rho = rho_of(s);
    let mut rows: Vec<Row> = slots
        .iter()
        .map(|&sensing_slots| Row {
            sensing_slots,
            accuracy: Vec::new(),
            each: vec![Vec::new(); METHODS.len()],
            machines: Vec::new(),
            tested: 0,
        })
        .collect();
    let mut rate = None;
    for seed in request.each_seed() {
        let (train, test) = (OnceCell::new(), OnceCell::new());
        let recordings = Recordings { request, rho, seed, context, train, test };
        let rate = match &rate {
            Some(rate) => rate,
            None => rate.insert(cells.get("cnn-rate", || recordings.rate())?),
        };
        let dsn = cells.get(&format!("seed-{seed}-dsn"), || recordings.dsn())?;
        for (n, (row, dsn)) in rows.iter_mut().zip(dsn).enumerate() {
            let name = |method: &str| format!("seed-{seed}-{method}-{}", slots[n]);
            let cnn = cells.get(&name("cnn"), || recordings.cnn(n, rate.rate))?;
            row.tested = dsn.tested;
            row.each[0].push(dsn.float);
            row.each[1].push(cnn);
            #[cfg(feature = "svm")]
            {
                let svm = cells.get(&name("svm"), || recordings.svm(n))?;
                row.machines.push(svm.settings);
                row.each[2].push(svm.accuracy);
            }
        }
    }
    rows.iter_mut().for_each(|row| row.accuracy = row.each.iter().map(|each| Spread::of(each)).collect());
    let found = Baselines { rho, rate: rate.ok_or("no seed")?, rows };
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
             cross-validation.\n\n"
        }
        _ => " This build has no support vector machine (feature `svm`).\n\n",
    };
    text += &format!("| N_s | {} |\n|---|{}\n", METHODS.join(" | "), "---|".repeat(METHODS.len()));
    for row in &found.rows {
        let cells: Vec<String> = row.accuracy.iter().map(Spread::to_string).collect();
        text += &format!("| {} | {} |\n", row.sensing_slots, cells.join(" | "));
    }
    text
}
