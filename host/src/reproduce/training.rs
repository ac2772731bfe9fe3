//! Training loss and test accuracy over epochs for every number of sensing slots: the first two panels of the paper's training figure.

use super::learning_curve::rises;
use super::made::{Made, statement};
use super::settings::Settings;
use super::work::{Learned, Task, Work};
use crate::error::Failure;
use crate::experiments::carriers::CARRIERS_HZ;
use crate::report::panels::THIRD;
use crate::report::plot::{Axis, Plot, style};

pub fn tasks(seeds: &[u64]) -> Vec<Task> {
    let carrier_hz = CARRIERS_HZ[0];
    let task = |settings| seeds.iter().map(move |&seed| Task::Networks { settings, carrier_hz, seed });
    Settings::BOTH.into_iter().flat_map(task).collect()
}

fn plot(title: &str, y: Axis, slots: &[u32], curves: &[Vec<(f64, f64)>]) -> String {
    let last = curves.iter().flatten().map(|p| p.0).fold(1.0, f64::max);
    let mut plot = Plot::new(title, Axis { whole: true, ..Axis::new(0.0, last * 1.02, "epoch") }, y);
    for (index, (n, points)) in slots.iter().zip(curves).enumerate() {
        let series = plot.series(&format!("N_s = {n}"), style(index));
        plot.line(series, points, 1.2);
        for &point in points.iter().step_by(points.len().div_ceil(6).max(1)) {
            plot.dot(series, point, 2.0, "");
        }
    }
    plot.svg(THIRD)
}

/// Whether a loss has converged: over its last fifth it falls by less than a twentieth of what it fell by before.
fn converged(losses: &[f64]) -> bool {
    let fifth = (losses.len() / 5).max(1);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len().max(1) as f64;
    let (first, rest) = losses.split_at(losses.len().saturating_sub(2 * fifth));
    let (before, last) = rest.split_at(rest.len().saturating_sub(fifth));
    let start = first.first().copied().unwrap_or(f64::INFINITY);
    mean(before) - mean(last) < 0.05 * (start - mean(last))
}

pub fn make(work: &Work<'_>) -> Result<Made, Failure> {
    let found = work.both(|settings, seed| work.networks(settings, CARRIERS_HZ[0], seed))?;
    let slots = &work.base.frame.sensing_slots;
    let mut made = Made {
        caption: "Training loss and test accuracy over epochs for every N_s (Fig. 8, a and b)",
        columns: 2,
        ..Made::default()
    };
    let all = |s: usize, holds: &dyn Fn(&Learned) -> bool| Some(found[s].iter().all(holds));
    let converges = |learned: &Learned| {
        let losses = learned.epochs.iter().map(|epochs| epochs.iter().map(|e| e.loss).collect::<Vec<_>>());
        losses.into_iter().all(|losses| converged(&losses))
    };
    made.statements = vec![
        statement("the training loss converges for every N_s", [all(0, &converges), all(1, &converges)]),
        statement(
            "a larger N_s gives a better accuracy (within twice the error of the test)",
            [0, 1].map(|s| Some(rises(slots, &found[s]))),
        ),
    ];
    for (settings, seeds) in Settings::BOTH.iter().zip(&found) {
        let learned = &seeds[0];
        let losses: Vec<Vec<(f64, f64)>> = learned
            .epochs
            .iter()
            .map(|epochs| epochs.iter().enumerate().map(|(k, e)| (k as f64 + 1.0, e.loss)).collect())
            .collect();
        let most = losses.iter().flatten().map(|p| p.1).fold(0.1, f64::max);
        let tested: Vec<Vec<(f64, f64)>> = learned
            .tested
            .iter()
            .map(|points| points.iter().map(|&(epoch, a)| (f64::from(epoch), a)).collect())
            .collect();
        let words = settings.words();
        let loss = Axis::new(0.0, 1.05 * most, "training loss (nat)");
        made.panels.push((format!("training loss, {words}"), plot("Training loss", loss, slots, &losses)));
        let accuracy = Axis::new(0.0, 1.02, "test accuracy (share, 0 to 1)");
        made.panels
            .push((format!("test accuracy, {words}"), plot("Test accuracy", accuracy, slots, &tested)));
    }
    Ok(made)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn convergence_differs_from_a_fall() {
        let exponential: Vec<f64> = (0..60).map(|k| 1.6 * libm::exp(-f64::from(k) / 8.0)).collect();
        let linear: Vec<f64> = (0..60).map(|k| 1.6 - 0.02 * f64::from(k)).collect();
        assert!(converged(&exponential) && !converged(&linear));
    }
}
