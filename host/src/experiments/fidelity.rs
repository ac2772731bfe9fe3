//! How near simulated recordings are to others: the paper's Figs. 6 and 7, on a surrogate and on measured recordings.
//!
//! Three domains at the largest N_s. `dahc`: the paper's channel, its rho calibrated on the surrogate. `ray-tracing`: the same
//! people without uncertainty. `surrogate` takes the experiment's place where nobody measured: other people (another seed), and a
//! richer room and radar than either: 802.11ay clusters with blockage, rays of geometry that keep their phase and diffuse
//! ones that do not ([`SURROGATE_RHO`]), an oscillator with phase noise, I and Q out of balance, speeds that scatter twice as much.

use super::cells::Cells;
use super::labelled::{LeftOut, Measured, left_out_section};
use super::trained::{images, train};
use super::{Request, RunContext, Spread};
use crate::error::{Failure, Invalid};
use crate::network::spectrograms::Part;
use crate::scenario::{ArMode, Class, Clusters, Model, Scenario};
use crate::simulator::calibration::conditioning::clutter_free;
use crate::simulator::calibration::divergence::{Counts, EVALUATIONS, divergence, search, shares};
use crate::simulator::calibration::intensity::{Intensity, LEVELS, histogram};
use crate::simulator::calibration::{calibrate_measured, divergence_measured};
use crate::simulator::channel::Complex64;
use crate::simulator::dataset::{Set, beats};
use crate::simulator::randomised::Motion;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::cell::OnceCell;

/// Names of the domains, in the order of every array here.
pub const DOMAINS: [&str; 3] = ["dahc", "ray-tracing", "surrogate"];
/// The paper's gaps to the experiment in accuracy: (carrier in GHz, DAHC, ray tracing).
pub const PAPER: [(f64, f64, f64); 2] = [(3.5, 0.02, 0.0533), (60.0, 0.04, 0.067)];
/// AR(1) coefficient rho of the surrogate's diffuse rays.
pub const SURROGATE_RHO: f64 = 0.995;
/// What is added to a seed for the surrogate's own people.
const OTHERS: u64 = 1 << 40;
/// Recordings behind a distribution of intensities, and slots before each: measured rooms have no beginning.
const PEOPLE: u32 = 100;
const SETTLE_SLOTS: u32 = 300;

/// Divergence of the domains' intensities from the surrogate's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct IntensityDivergence {
    /// The calibrated rho.
    pub rho: f64,
    /// D(surrogate || DAHC at rho) in nats.
    pub dahc: f64,
    /// D(surrogate || DAHC at rho = 1).
    pub without_uncertainty: f64,
    /// D(surrogate || ray tracing).
    pub ray_tracing: f64,
    /// Shares of the intensities of every domain.
    pub pmf: [Vec<f64>; 3],
}

/// Divergence of simulated intensities from a measured recording's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredIntensities {
    /// The recording.
    pub name: String,
    /// What it shows.
    pub motion: Motion,
    /// Divergences, and the shares of DAHC, ray tracing and the recording.
    pub intensities: IntensityDivergence,
}

/// The study's result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Fidelity {
    /// N_s.
    pub sensing_slots: u32,
    /// Intensities against the surrogate.
    pub intensities: IntensityDivergence,
    /// Accuracy in float, `[trained on][tested on]`.
    pub float: [[Spread; 3]; 3],
    /// Accuracy of the int8 networks.
    pub int8: [[Spread; 3]; 3],
    /// Intensities against measured recordings.
    pub measured: Vec<MeasuredIntensities>,
    /// Files not used, and why.
    pub left_out: Vec<LeftOut>,
}

/// The scenario of a domain.
pub fn domain(usual: &Scenario, domain: usize) -> Scenario {
    let mut s = usual.clone();
    s.frame.sensing_slots = vec![usual.largest_sensing_slots()];
    match DOMAINS[domain] {
        "dahc" => s.channel.model = Model::Dahc,
        "ray-tracing" => s.channel.model = Model::RayTracing,
        _ => {
            s.channel.model = Model::Dahc;
            (s.channel.clusters, s.channel.mode) = (Clusters::Ieee80211ay, ArMode::Consistent);
            s.channel.blockage = true;
            s.radar.phase_noise_deg = 1.0;
            (s.radar.iq_gain_db, s.radar.iq_phase_deg) = (Some(0.5), Some(2.0));
            s.target.speed_jitter = (2.0 * s.target.speed_jitter).min(0.5);
        }
    }
    s
}

/// Intensities of people of every class, through noise and impairments.
fn counts(s: &Scenario, rho: f64, seed: u64, set: Set) -> Counts {
    let settings = &s.spectrogram;
    let hop = usize::from(settings.hop);
    let intensity = Intensity::new(usize::from(settings.window), hop);
    let one = |n: u32| {
        let (class, index) = (Class::ALL[n as usize % Class::ALL.len()], n / Class::ALL.len() as u32);
        let slots = SETTLE_SLOTS + s.largest_sensing_slots();
        let (beats, _) = beats(s, rho, seed, set, class, index, slots);
        let complex = |z: &sdp3_core::dims::Beat| z.map(|z| Complex64::new(f64::from(z.re), f64::from(z.im)));
        let beats: Vec<_> = beats[SETTLE_SLOTS as usize..].iter().map(complex).collect();
        histogram(&intensity.decibels(&clutter_free(&beats), false))
    };
    let each: Vec<Counts> = (0..PEOPLE).into_par_iter().map(one).collect();
    std::array::from_fn(|level| each.iter().map(|counts| counts[level]).sum())
}

/// Calibrates DAHC on the surrogate and compares ray tracing with it.
fn intensities(request: &Request, context: RunContext) -> IntensityDivergence {
    let [dahc, traced, surrogate] = [0, 1, 2].map(|d| domain(&request.scenario, d));
    let stage = context.progress.stage("calibrate", "DAHC on the surrogate");
    let target = counts(&surrogate, SURROGATE_RHO, request.seed + OTHERS, Set::Surrogate);
    let (curve, simulated, best) = search(&target, |rho| {
        stage.step(EVALUATIONS);
        counts(&dahc, rho, request.seed, Set::Calibration)
    });
    let rays = counts(&traced, 1.0, request.seed, Set::Calibration);
    stage.finish(&format!("rho = {} on the surrogate", curve[best].rho));
    IntensityDivergence {
        rho: curve[best].rho,
        dahc: curve[best].kl,
        without_uncertainty: curve.last().map_or(f64::NAN, |p| p.kl),
        ray_tracing: divergence(&target, &rays, 0),
        pmf: [shares(&simulated[best]), shares(&rays), shares(&target)],
    }
}

/// A network's accuracy on every domain: (float, int8).
type Row = [(f64, f64); 3];

/// Accuracy of every network on every domain, seed by seed: `[trained on][seed][tested on]`.
fn matrix(request: &Request, cells: &Cells, rho: f64, context: RunContext) -> Result<[Vec<Row>; 3], Failure> {
    let domains = [0, 1, 2].map(|d| domain(&request.scenario, d));
    let rhos = [rho, 1.0, SURROGATE_RHO];
    let seed_of = |seed: u64, d: usize| if d == 2 { seed + OTHERS } else { seed };
    let mut found = [const { Vec::new() }; 3];
    for seed in request.each_seed() {
        let tests: [OnceCell<_>; 3] = Default::default();
        for (d, scenario) in domains.iter().enumerate() {
            let name = format!("seed-{seed}-trained-on-{}", DOMAINS[d]);
            let row = cells.get(&name, || {
                let own = images(scenario, rhos[d], seed_of(seed, d), Part::Train, context);
                let network = train(scenario, seed, &own, context)?;
                let mut row = [(0.0, 0.0); 3];
                for (t, cell) in row.iter_mut().enumerate() {
                    let draw = || images(&domains[t], rhos[t], seed_of(seed, t), Part::Test, context);
                    let accuracy = &network.test(scenario, tests[t].get_or_init(draw))?[0];
                    *cell = (accuracy.float, accuracy.int8);
                }
                Ok(row)
            })?;
            found[d].push(row);
        }
    }
    Ok(found)
}

/// Divergences from a measured recording.
///
/// # Errors
///
/// A recording that cannot be calibrated on.
pub fn measured_intensities(
    s: &Scenario,
    recording: &Measured,
    seed: u64,
    context: RunContext,
) -> Result<IntensityDivergence, Invalid> {
    let (class, signal) = (recording.motion.class(), &recording.signal);
    let stage = context.progress.stage("calibrate", &recording.name);
    let found = calibrate_measured(s, signal, class, seed, &|done, all| stage.at(done, all))?;
    let mut traced = s.clone();
    traced.channel.model = Model::RayTracing;
    let (ray_tracing, rays) = divergence_measured(&traced, signal, class, seed, 1.0)?;
    stage.finish(&format!("{}: rho = {}", recording.name, found.rho));
    Ok(IntensityDivergence {
        rho: found.rho,
        dahc: found.kl.unwrap_or(f64::NAN),
        without_uncertainty: found.kl_without_uncertainty.unwrap_or(f64::NAN),
        ray_tracing,
        pmf: [found.simulated_pmf, rays, found.measured_pmf],
    })
}

/// Runs or goes on; measured recordings may be none.
///
/// # Errors
///
/// Whatever a training or the folder says.
pub fn study(
    request: &Request,
    cells: &Cells,
    (recordings, mut left_out): (Vec<Measured>, Vec<LeftOut>),
    context: RunContext,
) -> Result<Fidelity, Failure> {
    let mut measured = Vec::new();
    for recording in &recordings {
        let found = cells.get(&format!("intensities-{}", recording.key), || {
            Ok(measured_intensities(&request.scenario, recording, request.seed, context)
                .map_err(|e| e.to_string()))
        })?;
        match found {
            Ok(intensities) => measured.push(MeasuredIntensities {
                name: recording.name.clone(),
                motion: recording.motion,
                intensities,
            }),
            Err(reason) => left_out.push((recording.name.clone(), format!("intensities: {reason}"))),
        }
    }
    let intensities = cells.get("intensities", || Ok(intensities(request, context)))?;
    let found = matrix(request, cells, intensities.rho, context)?;
    let spread = |of: fn(&(f64, f64)) -> f64| {
        let one =
            |d: usize, t: usize| Spread::of(&found[d].iter().map(|row| of(&row[t])).collect::<Vec<_>>());
        std::array::from_fn(|d| std::array::from_fn(|t| one(d, t)))
    };
    let found = Fidelity {
        sensing_slots: request.scenario.largest_sensing_slots(),
        intensities,
        float: spread(|cell| cell.0),
        int8: spread(|cell| cell.1),
        measured,
        left_out,
    };
    cells.output.write_result("fidelity.json", &found)?;
    cells.output.write("fidelity.md", table(request, &found).as_bytes())?;
    Ok(found)
}

/// Differences in accuracy from the surrogate's network on the surrogate: (each on its own test set, each on the surrogate's).
pub fn gaps(accuracy: &[[Spread; 3]; 3]) -> [(f64, f64); 2] {
    let experiment = accuracy[2][2].mean;
    [0, 1].map(|d| ((accuracy[d][d].mean - experiment).abs(), (accuracy[d][2].mean - experiment).abs()))
}

/// The result in words.
pub fn table(request: &Request, found: &Fidelity) -> String {
    let l = &request.scenario.learning;
    let mut text = format!(
        "# How near simulated recordings are to others\n\n{:.3} GHz, N_s = {}, {} recordings per class to train, {} to test, {}, {} \
         epochs. Surrogate for an experiment: other people, 802.11ay clusters with blockage, `consistent` correlation \
         at rho = {SURROGATE_RHO}, phase noise 1 degree, I/Q off by 0.5 dB and 2 degrees, twice the spread of speeds.\n\n## Intensities ({LEVELS})\n\n\
         | compared with | rho | KL of calibrated DAHC | KL at rho = 1 | KL of ray tracing |\n|---|---|---|---|---|\n",
        request.scenario.radar.carrier_hz / 1e9,
        found.sensing_slots,
        l.train_per_class,
        l.test_per_class,
        request.seeds_label(),
        l.epochs
    );
    let mut line = |name: &str, l: &IntensityDivergence| {
        text += &format!(
            "| {name} | {} | {:.3} | {:.3} | {:.3} |\n",
            l.rho, l.dahc, l.without_uncertainty, l.ray_tracing
        );
    };
    line("surrogate", &found.intensities);
    found.measured.iter().for_each(|m| line(&format!("{} ({})", m.name, m.motion.name()), &m.intensities));
    text += "\n## Accuracy\n\n| trained on | tested on dahc | on ray-tracing | on the surrogate |\n|---|---|---|---|\n";
    for (name, [a, b, c]) in DOMAINS.iter().zip(&found.int8) {
        text += &format!("| {name} | {a} | {b} | {c} |\n");
    }
    text += "\nint8; float differs by ";
    let differences = found.float.iter().flatten().zip(found.int8.iter().flatten());
    let most = differences.map(|(f, i)| (f.mean - i.mean).abs()).fold(0.0, f64::max);
    text += &format!(
        "{most:.3} at most.\n\n| gap to the surrogate's own network | each on its own recordings | each on the \
         surrogate's | the paper, 3.5 GHz | 60 GHz |\n|---|---|---|---|---|\n"
    );
    let paper = [PAPER.map(|p| p.1), PAPER.map(|p| p.2)];
    for ((name, (own, transfer)), [low, high]) in DOMAINS.iter().zip(gaps(&found.int8)).zip(paper) {
        text += &format!("| {name} | {own:.3} | {transfer:.3} | {low} | {high} |\n");
    }
    text + &left_out_section(&found.left_out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn domains_differ_and_are_legal() {
        let usual = Scenario::default();
        let all = [0, 1, 2].map(|d| domain(&usual, d));
        for (k, s) in all.iter().enumerate() {
            s.check(DOMAINS[k]).unwrap();
            assert_eq!(s.frame.sensing_slots, [1000]);
        }
        assert_ne!(all[0], all[1]);
        assert_ne!(all[0], all[2]);
    }

    #[test]
    fn gaps_are_taken_from_the_surrogates_own_network() {
        let accuracy = |v: f64| Spread { mean: v, deviation: 0.0, seeds: 5 };
        let matrix = [[0.95, 0.9, 0.91], [0.8, 0.99, 0.7], [0.9, 0.9, 0.93]].map(|row| row.map(accuracy));
        let [(a, b), (c, d)] = gaps(&matrix);
        for (found, exact) in [(a, 0.02), (b, 0.02), (c, 0.06), (d, 0.23)] {
            assert!((found - exact).abs() < 1e-12);
        }
    }
}
