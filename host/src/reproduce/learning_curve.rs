//! Accuracy over the number of sensing slots at both carriers: the third panel of the paper's training figure, and its approximation.

use super::made::{Made, number, statement};
use super::settings::Settings;
use super::work::{Learned, Task, Work};
use crate::error::Failure;
use crate::experiments::carriers::CARRIERS_HZ;
use crate::predictor::{Model, fit_all, paper};
use crate::report::panels::THIRD;
use crate::report::plot::{Axis, Plot, STYLES};
use crate::results::{Compared, CurvePoint, Estimate, Prediction, Spread};

pub fn tasks(seeds: &[u64]) -> Vec<Task> {
    let mut all = Vec::new();
    for settings in Settings::BOTH {
        for carrier_hz in CARRIERS_HZ {
            all.extend(seeds.iter().map(|&seed| Task::Networks { settings, carrier_hz, seed }));
        }
    }
    all
}

/// Mean int8 accuracies over N_s; of several seeds with the standard error of the mean, since trainings differ too.
pub fn points(slots: &[u32], seeds: &[Learned]) -> Vec<CurvePoint> {
    let of = |(n, &sensing_slots): (usize, &u32)| {
        let all = || seeds.iter().map(|learned| &learned.accuracy[n]);
        CurvePoint {
            sensing_slots: f64::from(sensing_slots),
            accuracy: all().map(|a| a.int8).sum::<f64>() / seeds.len() as f64,
            tested: Some(all().map(|a| f64::from(a.tested)).sum()),
            std: Spread::of(&all().map(|a| a.int8).collect::<Vec<_>>()).standard_error(),
        }
    };
    slots.iter().enumerate().map(of).collect()
}

/// Whether accuracy increases with N_s; a decrease within two standard errors of the difference counts as none.
pub fn rises(slots: &[u32], seeds: &[Learned]) -> bool {
    let points = points(slots, seeds);
    points.windows(2).all(|pair| {
        let variance = |p: &CurvePoint| p.accuracy * (1.0 - p.accuracy) / p.tested.unwrap_or(1.0);
        let error = (variance(&pair[0]) + variance(&pair[1])).sqrt();
        pair[1].accuracy > pair[0].accuracy - 2.0 * error
    })
}

/// The curve of pow3 through points, if it is among the fits.
fn pow3(prediction: &Prediction) -> Option<impl Fn(f64) -> f64 + '_> {
    let fitted = prediction.models.iter().find(|m| m.name == Model::Pow3.name())?;
    Some(move |n: f64| Model::Pow3.at(&fitted.parameters, n))
}

fn panel(points: &[CurvePoint]) -> String {
    let x = Axis::new(150.0, 1050.0, "sensing slots N_s");
    let low = points.iter().map(|p| p.accuracy).fold(0.75, f64::min) - 0.05;
    let mut plot =
        Plot::new("Accuracy over sensing slots", x, Axis::new(low, 1.0, "accuracy (share, 0 to 1)"));
    let found = plot.series("int8", STYLES[1]);
    points.iter().for_each(|p| plot.dot(found, (p.sensing_slots, p.accuracy), 2.6, ""));
    let prediction = fit_all(points).ok();
    if let Some(at) = prediction.as_ref().and_then(pow3) {
        let curve = plot.series("pow3", STYLES[0]);
        let line: Vec<_> = (0..=80).map(|k| 200.0 + 10.0 * f64::from(k)).map(|n| (n, at(n))).collect();
        let inside: Vec<_> = line.into_iter().filter(|p| (low..=1.0).contains(&p.1)).collect();
        plot.line(curve, &inside, 1.4);
    }
    let printed = plot.series("the paper", STYLES[2]);
    paper::POINTS.iter().for_each(|&(n, a)| plot.dot(printed, (f64::from(n), a), 2.6, ""));
    plot.svg(THIRD)
}

pub fn make(work: &Work<'_>) -> Result<Made, Failure> {
    let slots = &work.base.frame.sensing_slots;
    let mut made = Made {
        caption: "Accuracy over sensing slots with its approximation (Fig. 8, c)",
        columns: 2,
        ..Made::default()
    };
    let mut panels = [Vec::new(), Vec::new()];
    for carrier_hz in CARRIERS_HZ {
        let found = work.both(|settings, seed| work.networks(settings, carrier_hz, seed))?;
        for (n, &sensing_slots) in slots.iter().enumerate() {
            let of = |s: usize| {
                let all: Vec<f64> = found[s].iter().map(|learned| learned.accuracy[n].int8).collect();
                Some(Estimate::of_shares(&all, found[s][0].accuracy[n].tested))
            };
            let paper = paper::POINTS.iter().find(|(slots, _)| *slots == sensing_slots).map(|p| p.1);
            let quantity = format!("{} GHz: accuracy at N_s = {sensing_slots}", carrier_hz / 1e9);
            // who recognises better reaches the paper too
            made.numbers.push(Compared { at_least: true, ..number(&quantity, paper, [of(0), of(1)]) });
        }
        let falls = |s: usize| {
            let points = points(slots, &found[s]);
            let gain = |from: usize, to: usize| points[to].accuracy - points[from].accuracy;
            let middle = slots.len() / 2;
            Some(gain(0, middle) > gain(middle, slots.len() - 1))
        };
        made.statements.push(statement(
            &format!("{} GHz: accuracy rises less and less", carrier_hz / 1e9),
            [falls(0), falls(1)],
        ));
        made.statements.push(statement(
            &format!("{} GHz: a larger N_s gives a better accuracy", carrier_hz / 1e9),
            [0, 1].map(|s| Some(rises(slots, &found[s]))),
        ));
        for (s, settings) in Settings::BOTH.iter().enumerate() {
            let caption = format!("{} GHz, {}", carrier_hz / 1e9, settings.words());
            panels[s].push((caption, panel(&points(slots, &found[s]))));
        }
    }
    made.panels = panels.into_iter().flatten().collect();
    made.notes.push(
        "The paper has one curve and does not say at which carrier. Test recordings begin at the range samples, as those learned from do."
            .into(),
    );
    Ok(made)
}
