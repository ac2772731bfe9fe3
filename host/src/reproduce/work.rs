//! What several items need, computed once and kept: channel properties, divergences, trained networks.

use super::Size;
use super::settings::{OTHERS, Settings, experiment, ray_tracing, scenario};
use crate::error::Failure;
use crate::experiments::RunContext;
use crate::experiments::cells::Cells;
use crate::experiments::fidelity::{IntensityDivergence, measured_intensities};
use crate::experiments::labelled::Measured;
use crate::experiments::trained::{images, parameters_of, train_watched};
use crate::network::float_network::FloatNetwork;
use crate::network::recipe::Recipe;
use crate::network::spectrograms::Part;
use crate::results::{Accuracy, ChannelTable, Epoch, KlPoint};
use crate::scenario::{Class, Learning, Model, Scenario};
use crate::simulator::calibration::divergence::{EVALUATIONS, divergence, search, shares};
use crate::simulator::calibration::rho_of;
use crate::simulator::calibration::sensor::SensorSimulation;
use crate::simulator::channel::properties;
use crate::simulator::dataset::Set;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// Carriers and whether a second person walks: the paper's three panels.
pub const ROOMS: [(f64, bool); 3] = [(3.5e9, false), (60e9, false), (60e9, true)];
/// Where recordings come from.
pub const DOMAINS: [&str; 3] = ["dahc", "ray-tracing", "experiment"];
/// N_s of a comparison of domains.
const COMPARED_SLOTS: u32 = 1000;
/// Tests over a training, its last epoch included.
const TESTS: u32 = 12;

/// One computation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Task {
    Properties { seed: u64 },
    Divergence { settings: Settings, room: usize, seed: u64 },
    Networks { settings: Settings, carrier_hz: f64, seed: u64 },
    Domain { settings: Settings, carrier_hz: f64, domain: usize, seed: u64 },
}

/// Divergence from the experiment over rho, and the distributions behind it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Divergence {
    pub rho: f64,
    pub curve: Vec<KlPoint>,
    pub ray_tracing: f64,
    /// Shares of the intensities of [`DOMAINS`].
    pub shares: [Vec<f64>; 3],
}

/// Networks of every N_s, their training and their tests.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Learned {
    pub accuracy: Vec<Accuracy>,
    pub epochs: Vec<Vec<Epoch>>,
    /// Of each network: epochs and float accuracy after them.
    pub tested: Vec<Vec<(u32, f64)>>,
}

/// Where items are made, and how large.
pub struct Work<'a> {
    pub base: Scenario,
    pub size: Size,
    pub seeds: Vec<u64>,
    pub cells: Cells<'a>,
    pub context: RunContext,
    /// Measured recordings to set beside the experiment.
    pub measured: Vec<Measured>,
}

impl Work<'_> {
    /// Does one task, unless its result is kept.
    ///
    /// # Errors
    ///
    /// Whatever a training or the folder says.
    pub fn run(&self, task: Task) -> Result<(), Failure> {
        match task {
            Task::Properties { seed } => self.properties(seed).map(drop),
            Task::Divergence { settings, room, seed } => self.divergence(settings, room, seed).map(drop),
            Task::Networks { settings, carrier_hz, seed } => {
                self.networks(settings, carrier_hz, seed).map(drop)
            }
            Task::Domain { settings, carrier_hz, domain, seed } => {
                self.domain(settings, carrier_hz, domain, seed).map(drop)
            }
        }
    }

    pub fn scenario(&self, settings: Settings, carrier_hz: f64) -> Scenario {
        scenario(&self.base, self.size, settings, carrier_hz)
    }

    pub fn properties(&self, seed: u64) -> Result<ChannelTable, Failure> {
        self.cells.get(&format!("properties-{seed}"), || {
            let stage = self.context.progress.stage("channels", "models through the property tests");
            let table = properties::table(&self.base, seed, &|done, all| stage.at(done, all));
            stage.finish(&format!("{} models", table.models.len()));
            Ok(table)
        })
    }

    /// Walking adults: the hybrid channel over rho and ray tracing against the experiment.
    pub fn divergence(&self, settings: Settings, room: usize, seed: u64) -> Result<Divergence, Failure> {
        let (carrier_hz, interferer) = ROOMS[room];
        let name = format!("divergence-{}-{}-{seed}", settings.name(), room + 1);
        self.cells.get(&name, || {
            let people = match self.size {
                Size::Quick => 30,
                Size::Paper => 100,
            };
            let stage = self.context.progress.stage("calibrate", &name);
            let counts = |scenario: &Scenario, rho: f64, set: Set, seed: u64| {
                let mut scenario = scenario.clone();
                scenario.channel.interferer = interferer && set == Set::Surrogate;
                SensorSimulation::new(&scenario, seed, Class::AdultWalking, false, COMPARED_SLOTS)
                    .counts(rho, set, people)
            };
            let mut simulated = self.scenario(settings, carrier_hz);
            simulated.channel.model = Model::Dahc;
            let real = experiment(&self.base, self.size, carrier_hz);
            let target = counts(&real, 1.0, Set::Surrogate, seed + OTHERS);
            let (curve, dahc, best) = search(&target, |rho| {
                stage.step(EVALUATIONS);
                counts(&simulated, rho, Set::Calibration, seed)
            });
            let rays = counts(&ray_tracing(simulated.clone()), 1.0, Set::Calibration, seed);
            let rho = curve[best].rho;
            stage.finish(&format!("{name}: rho = {rho}"));
            let ray_tracing = divergence(&target, &rays, 0);
            Ok(Divergence {
                rho,
                curve,
                ray_tracing,
                shares: [shares(&dahc[best]), shares(&rays), shares(&target)],
            })
        })
    }

    /// Divergences from a measured recording, with the scenario's settings.
    pub fn measured(&self, recording: &Measured) -> Result<IntensityDivergence, Failure> {
        self.cells.get(&format!("measured-{}", recording.key), || {
            Ok(measured_intensities(&self.base, recording, self.seeds[0], self.context)?)
        })
    }

    /// Networks of every N_s in the hybrid channel.
    pub fn networks(&self, settings: Settings, carrier_hz: f64, seed: u64) -> Result<Learned, Failure> {
        let name = format!("networks-{}-{}-{seed}", settings.name(), carrier_hz / 1e9);
        self.cells.get(&name, || self.learn(&self.scenario(settings, carrier_hz), seed, seed))
    }

    /// A network that learned from recordings of a domain, tested with others of them.
    pub fn domain(
        &self,
        settings: Settings,
        carrier_hz: f64,
        domain: usize,
        seed: u64,
    ) -> Result<Learned, Failure> {
        let name = format!("domain-{}-{}-{}-{seed}", settings.name(), carrier_hz / 1e9, DOMAINS[domain]);
        self.cells.get(&name, || {
            let mut scenario = match DOMAINS[domain] {
                "experiment" => experiment(&self.base, self.size, carrier_hz),
                _ => self.scenario(settings, carrier_hz),
            };
            match DOMAINS[domain] {
                "dahc" => scenario.channel.model = Model::Dahc,
                "ray-tracing" => scenario = ray_tracing(scenario),
                _ => (),
            }
            // 600 samples of five classes
            scenario.learning.train_per_class = scenario.learning.train_per_class.min(120);
            if settings == Settings::AsPrinted {
                let printed = self.scenario(settings, carrier_hz).learning;
                let train_per_class = scenario.learning.train_per_class;
                scenario.learning = Learning { train_per_class, ..printed };
                Recipe::PaperMomentum.apply(&mut scenario.learning);
            }
            scenario.frame.sensing_slots = vec![COMPARED_SLOTS];
            let people = if DOMAINS[domain] == "experiment" { seed + OTHERS } else { seed };
            self.learn(&scenario, people, seed)
        })
    }

    /// Simulates, trains and tests: recordings of one seed, weights and shuffling of another.
    fn learn(&self, scenario: &Scenario, people: u64, seed: u64) -> Result<Learned, Failure> {
        let rho = rho_of(scenario);
        let learned = images(scenario, rho, people, Part::Train, self.context);
        let shown = images(scenario, rho, people, Part::Calibration, self.context);
        let every = scenario.learning.epochs.div_ceil(TESTS);
        let tested = Mutex::new(vec![Vec::new(); scenario.frame.sensing_slots.len()]);
        let watch = |job: usize, state: &dyn Fn() -> _, epochs: &[Epoch]| {
            let epoch = epochs.len() as u32;
            if epoch.is_multiple_of(every) || epoch == scenario.learning.epochs {
                let parameters = parameters_of(&state(), &scenario.learning)?;
                let accuracy = FloatNetwork::new(&parameters).classify(&shown.images[job]).accuracy();
                tested.lock().unwrap_or_else(PoisonError::into_inner)[job].push((epoch, accuracy));
            }
            Ok(())
        };
        let networks = train_watched(scenario, seed, &learned, self.context, &watch)?;
        let accuracy = networks.test(scenario, &shown)?;
        let tested = tested.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(Learned { accuracy, epochs: networks.epochs, tested })
    }

    /// What every seed says of both settings.
    pub fn both<T>(&self, of: impl Fn(Settings, u64) -> Result<T, Failure>) -> Result<[Vec<T>; 2], Failure> {
        let each = |settings| -> Result<Vec<T>, Failure> {
            self.seeds.iter().map(|&seed| of(settings, seed)).collect()
        };
        let [printed, here] = Settings::BOTH;
        Ok([each(printed)?, each(here)?])
    }
}
