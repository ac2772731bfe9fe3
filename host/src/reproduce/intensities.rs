//! Distributions of intensity of experiment, hybrid channel and ray tracing: the lower half of the paper's calibration figure.

use super::kl_divergence::{EXPERIMENT, found, panels, words};
use super::made::{Made, number, statement};
use super::work::{Divergence, ROOMS, Work};
use crate::error::Failure;
use crate::report::panels::THIRD;
use crate::report::plot::{Axis, Plot, STYLES};
use crate::results::Estimate;

/// Half the sum of absolute differences: 0 for equal distributions, 1 for disjoint ones.
fn total_variation(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / 2.0
}

/// Total variation of the hybrid channel and of ray tracing from the experiment.
fn apart(d: &Divergence) -> [f64; 2] {
    [total_variation(&d.shares[0], &d.shares[2]), total_variation(&d.shares[1], &d.shares[2])]
}

fn panel(d: &Divergence) -> String {
    let most = d.shares.iter().flat_map(|shares| shares.iter().skip(1)).copied().fold(1e-3, f64::max);
    let x = Axis::new(1.0, 63.0, "intensity (level, black left out)");
    let y = Axis::new(0.0, 110.0 * most, "share of pixels (%)");
    let mut plot = Plot::new("Intensity shares", x, y);
    for ((name, shares), style) in ["DAHC", "ray tracing", "experiment"].iter().zip(&d.shares).zip(STYLES) {
        let series = plot.series(name, style);
        let points: Vec<_> = shares.iter().enumerate().skip(1).map(|(k, p)| (k as f64, 100.0 * p)).collect();
        plot.line(series, &points, 1.3);
    }
    plot.svg(THIRD)
}

pub fn make(work: &Work<'_>) -> Result<Made, Failure> {
    let found = found(work)?;
    let mut made = Made {
        caption: "Distributions of intensity, walking (Fig. 6, d to f)",
        columns: 3,
        ..Made::default()
    };
    for (room, both) in found.iter().enumerate() {
        for (k, name) in ["hybrid channel", "ray tracing"].iter().enumerate() {
            let of = |settings: usize| {
                Some(Estimate::of_seeds(&both[settings].iter().map(|d| apart(d)[k]).collect::<Vec<_>>()))
            };
            let quantity = format!("{}: total variation of the {name}", words(room));
            made.numbers.push(number(&quantity, None, [of(0), of(1)]));
        }
    }
    let nearer = [0, 1].map(|settings| {
        let mean = |room: usize, k: usize| {
            found[room][settings].iter().map(|d| apart(d)[k]).sum::<f64>() / work.seeds.len() as f64
        };
        Some((0..ROOMS.len()).all(|room| mean(room, 0) < mean(room, 1)))
    });
    made.statements =
        vec![statement("the calibrated hybrid channel is nearer to the experiment than ray tracing", nearer)];
    made.panels = panels(&found, panel);
    made.notes.push(EXPERIMENT.to_owned());
    Ok(made)
}
