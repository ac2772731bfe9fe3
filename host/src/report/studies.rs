//! Pictures of the studies.

use super::plot::{Axis, COLOURS, Plot, escape};
use crate::predictor::learning_curve::Model;
use crate::predictor::learning_curve::paper;
use crate::studies::learning_curve::LearningCurve;
use crate::studies::robustness::Robustness;
use std::fmt::Write;

/// Accuracy over N_s: means with their spread over the seeds, every seed, the best curve, and the paper's points.
pub fn learning_curve(found: &LearningCurve) -> String {
    let most = found.rows.iter().map(|r| f64::from(r.sensing_slots)).fold(200.0, f64::max);
    let lowest = found.rows.iter().map(|r| r.int8.mean - r.int8.deviation).fold(0.75, f64::min);
    let x = Axis { low: 100.0, high: most * 1.05, name: "sensing slots N_s".into(), log: false };
    let y = Axis { low: (lowest - 0.05).max(0.0), high: 1.0, name: "accuracy".into(), log: false };
    let floor = y.low;
    let mut plot = Plot::new("Accuracy over sensing slots, several seeds", x, y);
    let best = found.prediction.as_ref().and_then(|p| p.models.first());
    if let Some((best, model)) = best.and_then(|best| Some((best, Model::by_name(&best.name)?))) {
        let points: Vec<_> = (0..=120)
            .map(|k| 128.0 + (most - 128.0) * f64::from(k) / 120.0)
            .map(|n| (n, model.at(&best.parameters, n)))
            .filter(|(_, a)| (floor..=1.0).contains(a))
            .collect();
        plot.line(&points, COLOURS[0], 2.0, &format!("{} (best fit)", best.name));
    }
    for row in &found.rows {
        let n = f64::from(row.sensing_slots);
        for &seed in &row.each {
            plot.dot(n, seed, 1.5, COLOURS[6], &format!("N_s = {n}: {seed:.3}"));
        }
        plot.error_bar(n, row.int8.mean - row.int8.deviation, row.int8.mean + row.int8.deviation, COLOURS[1]);
        plot.dot(
            n,
            row.int8.mean,
            4.5,
            COLOURS[1],
            &format!("N_s = {n}: int8 {}, float {}", row.int8, row.float),
        );
    }
    for (n, accuracy) in paper::POINTS.iter().filter(|(n, _)| f64::from(*n) <= most) {
        plot.dot(f64::from(*n), *accuracy, 3.5, COLOURS[2], &format!("the paper: {accuracy} at N_s = {n}"));
    }
    plot.entry("int8 over the seeds", COLOURS[1]);
    plot.entry("the paper", COLOURS[2]);
    plot.svg()
}

/// One bar per condition and way of training.
pub fn robustness(found: &Robustness) -> String {
    const LEFT: f64 = 300.0;
    const WIDTH: f64 = 340.0;
    const STEP: f64 = 22.0;
    let height = 60.0 + STEP * found.rows.len() as f64;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 720 {height}\" font-family=\"sans-serif\" font-size=\"12\" \
         fill=\"var(--ink,#222)\" role=\"img\"><title>Accuracy under changed conditions</title>\
         <rect width=\"720\" height=\"{height}\" fill=\"var(--paper,#fff)\"/>"
    );
    let at = |accuracy: f64| LEFT + WIDTH * accuracy.clamp(0.0, 1.0);
    for tick in 0..=5 {
        let accuracy = f64::from(tick) / 5.0;
        let x = at(accuracy);
        let _ = write!(
            svg,
            "<line x1=\"{x}\" x2=\"{x}\" y1=\"20\" y2=\"{}\" stroke=\"var(--soft,#ccc)\"/><text x=\"{x}\" y=\"{}\" \
             text-anchor=\"middle\">{accuracy}</text>",
            height - 36.0,
            height - 22.0
        );
    }
    let _ = write!(
        svg,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">accuracy (int8)</text>",
        at(0.5),
        height - 6.0
    );
    for (k, row) in found.rows.iter().enumerate() {
        let y = 24.0 + STEP * k as f64;
        let label = escape(&format!("{}: {}", row.factor, row.value));
        let _ =
            write!(svg, "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{label}</text>", LEFT - 8.0, y + 12.0);
        let bars = [(Some(row.transfer), COLOURS[0]), (row.matched, COLOURS[4])];
        for (bar, (spread, colour)) in bars.into_iter().enumerate() {
            let Some(s) = spread else { continue };
            let (y, x) = (y + 8.0 * bar as f64, at(s.mean));
            let _ = write!(
                svg,
                "<rect x=\"{LEFT}\" y=\"{y}\" width=\"{:.1}\" height=\"7\" fill=\"{colour}\"><title>{label}: {s}</title></rect>\
                 <line x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{m}\" y2=\"{m}\" stroke=\"var(--ink,#222)\"/>",
                x - LEFT,
                at(s.mean - s.deviation),
                at(s.mean + s.deviation),
                m = y + 3.5
            );
        }
    }
    for (k, (name, colour)) in [("transfer", COLOURS[0]), ("matched", COLOURS[4])].into_iter().enumerate() {
        let x = LEFT + 90.0 * k as f64;
        let _ = write!(
            svg,
            "<rect x=\"{x}\" y=\"6\" width=\"10\" height=\"8\" fill=\"{colour}\"/><text x=\"{}\" y=\"14\">{name}</text>",
            x + 14.0
        );
    }
    svg + "</svg>"
}
