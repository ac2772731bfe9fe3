//! Accuracy over epochs of networks that learned from the experiment, from the hybrid channel and from ray tracing, each tested with
//! other recordings of its own origin: the paper's comparison of recognition accuracy.

use super::kl_divergence::EXPERIMENT;
use super::made::{Made, number, statement};
use super::settings::Settings;
use super::work::{DOMAINS, Learned, Task, Work};
use crate::error::Failure;
use crate::experiments::carriers::CARRIERS_HZ;
use crate::report::panels::THIRD;
use crate::report::plot::{Axis, Plot, STYLES};
use crate::results::Estimate;

/// The paper's differences from the experiment at each carrier: hybrid channel, ray tracing.
const PAPER: [[f64; 2]; 2] = [[0.02, 0.0533], [0.04, 0.067]];

/// How its recordings become images.
const SEEN: &str = "It is seen by a real module's front end. Its images have this tool's spectrogram on both sides: as printed only its training is.";

pub fn tasks(seeds: &[u64]) -> Vec<Task> {
    let mut all = Vec::new();
    for settings in Settings::BOTH {
        for carrier_hz in CARRIERS_HZ {
            for domain in 0..DOMAINS.len() {
                all.extend(seeds.iter().map(|&seed| Task::Domain { settings, carrier_hz, domain, seed }));
            }
        }
    }
    all
}

/// Mean accuracy after each tested epoch.
fn mean(seeds: &[Learned]) -> Vec<(f64, f64)> {
    let Some(first) = seeds.first().and_then(|learned| learned.tested.first()) else { return Vec::new() };
    let at = |k: usize| {
        let all = seeds.iter().filter_map(|learned| Some(learned.tested.first()?.get(k)?.1));
        all.sum::<f64>() / seeds.len() as f64
    };
    first.iter().enumerate().map(|(k, (epoch, _))| (f64::from(*epoch), at(k))).collect()
}

fn panel(domains: &[Vec<Learned>]) -> String {
    let curves: Vec<_> = domains.iter().map(|seeds| mean(seeds)).collect();
    let last = curves.iter().flatten().map(|p| p.0).fold(1.0, f64::max);
    let x = Axis { whole: true, ..Axis::new(0.0, last * 1.02, "epoch") };
    let mut plot = Plot::new("Accuracy over epochs", x, Axis::new(0.0, 1.02, "accuracy (share, 0 to 1)"));
    for ((name, points), style) in ["DAHC", "ray tracing", "experiment"].iter().zip(&curves).zip(STYLES) {
        let series = plot.series(name, style);
        plot.line(series, points, 1.4);
        points.iter().for_each(|&point| plot.dot(series, point, 2.0, ""));
    }
    plot.svg(THIRD)
}

pub fn make(work: &Work<'_>) -> Result<Made, Failure> {
    let mut made = Made {
        caption: "Accuracy over epochs of networks of three origins (Fig. 7)",
        columns: 2,
        ..Made::default()
    };
    let mut panels = [Vec::new(), Vec::new()];
    for (c, carrier_hz) in CARRIERS_HZ.into_iter().enumerate() {
        // [settings][domain][seed]
        let mut found: [Vec<Vec<Learned>>; 2] = Default::default();
        for (s, settings) in Settings::BOTH.into_iter().enumerate() {
            for domain in 0..DOMAINS.len() {
                let of = |&seed: &u64| work.domain(settings, carrier_hz, domain, seed);
                found[s].push(work.seeds.iter().map(of).collect::<Result<_, _>>()?);
            }
            let caption = format!("{} GHz, {}", carrier_hz / 1e9, settings.words());
            panels[s].push((caption, panel(&found[s])));
        }
        let last = |learned: &Learned| learned.accuracy[0].float;
        let all = |s: usize, domain: usize| found[s][domain].iter().map(last).collect::<Vec<f64>>();
        // the experiment has people of its own: its seeds are no pairs of the others'
        let apart = |s: usize, domain: usize| Estimate::apart(&all(s, domain), &all(s, 2));
        for domain in 0..2 {
            let of = |s: usize| Some(apart(s, domain));
            let quantity =
                format!("{} GHz: difference of {} from the experiment", carrier_hz / 1e9, DOMAINS[domain]);
            made.numbers.push(number(&quantity, Some(PAPER[c][domain]), [of(0), of(1)]));
        }
        let tested = found[0][0][0].accuracy[0].tested;
        for (domain, name) in DOMAINS.iter().enumerate() {
            let of = |s: usize| Some(Estimate::of_shares(&all(s, domain), tested));
            let quantity = format!("{} GHz: accuracy of {name}", carrier_hz / 1e9);
            made.numbers.push(number(&quantity, None, [of(0), of(1)]));
        }
        let nearer = |s: usize| Some(apart(s, 0).high < apart(s, 1).low);
        made.statements.push(statement(
            &format!(
                "{} GHz: the hybrid channel's accuracy is nearer to the experiment's than ray tracing's, beyond both intervals",
                carrier_hz / 1e9
            ),
            [nearer(0), nearer(1)],
        ));
    }
    made.panels = panels.into_iter().flatten().collect();
    made.notes.push(EXPERIMENT.to_owned());
    made.notes.push(SEEN.to_owned());
    Ok(made)
}
