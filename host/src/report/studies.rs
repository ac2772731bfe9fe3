//! Pictures of the studies.

use super::plot::{Axis, COLOURS, FONTS, Medium, Plot, SOFT, STYLES, escape};
use crate::experiments::baselines::{Baselines, METHODS};
use crate::experiments::learning_curve::LearningCurve;
use crate::experiments::robustness::Robustness;
use crate::predictor::Model;
use crate::predictor::paper;
use std::fmt::Write;

/// Accuracy over N_s: means with their spread over the seeds, every seed, the best curve, and the paper's points.
pub fn learning_curve(found: &LearningCurve) -> String {
    let most = found.rows.iter().map(|r| f64::from(r.sensing_slots)).fold(200.0, f64::max);
    let lowest = found.rows.iter().map(|r| r.int8.mean - r.int8.deviation).fold(0.75, f64::min);
    let x = Axis::new(100.0, most * 1.05, "sensing slots N_s");
    let y = Axis::new((lowest - 0.05).max(0.0), 1.0, "accuracy (share, 0 to 1)");
    let floor = y.low;
    let mut plot = Plot::new("Accuracy over sensing slots, several seeds", x, y);
    let first = found.rows.iter().map(|r| f64::from(r.sensing_slots)).fold(f64::INFINITY, f64::min);
    let best = found.prediction.as_ref().and_then(|p| p.models.first());
    if let Some((best, model)) = best.and_then(|best| Some((best, Model::by_name(&best.name)?))) {
        let points: Vec<_> = (0..=120)
            .map(|k| first + (most - first) * f64::from(k) / 120.0)
            .map(|n| (n, model.at(&best.parameters, n)))
            .filter(|(_, a)| (floor..=1.0).contains(a))
            .collect();
        let series = plot.series(&format!("{} (best fit)", best.name), STYLES[0]);
        plot.line(series, &points, 1.8);
    }
    let each = plot.series("each seed", SOFT);
    let mean = plot.series("int8, mean ± 1 σ of the seeds", STYLES[1]);
    for row in &found.rows {
        let n = f64::from(row.sensing_slots);
        for &seed in &row.each {
            plot.dot(each, (n, seed), 1.5, &format!("N_s = {n}: {seed:.3}"));
        }
        plot.error_bar(mean, n, row.int8.mean - row.int8.deviation, row.int8.mean + row.int8.deviation);
        plot.dot(
            mean,
            (n, row.int8.mean),
            3.2,
            &format!("N_s = {n}: int8 {}, float {}", row.int8, row.float),
        );
    }
    let printed = plot.series("the paper", STYLES[2]);
    for (n, accuracy) in paper::POINTS.iter().filter(|(n, _)| f64::from(*n) <= most) {
        plot.dot(printed, (f64::from(*n), *accuracy), 3.0, &format!("the paper: {accuracy} at N_s = {n}"));
    }
    plot.svg(Medium::SINGLE)
}

/// Accuracy of every method over N_s: means with their spread over the seeds.
pub fn baselines(found: &Baselines) -> String {
    let slots = found.rows.iter().map(|r| f64::from(r.sensing_slots));
    let means = found.rows.iter().flat_map(|r| r.accuracy.iter().map(|a| a.mean - a.deviation));
    let low = (means.fold(1.0, f64::min) - 0.05).max(0.0);
    let mut x = Axis::around(slots, "sensing slots N_s");
    // room for what stands beside the first and the last
    let step = (x.high - x.low) / 100.0;
    (x.low, x.high) = ((x.low - step).max(0.0), x.high + step);
    let y = Axis::new(low, 1.0, "accuracy (float, share)");
    let mut plot = Plot::new("Accuracy of the network and its baselines over sensing slots", x, y);
    for (m, (method, style)) in METHODS.iter().zip(STYLES).enumerate() {
        // beside each other, so that no bar hides another
        let at = |n: u32| f64::from(n) + (m as f64 - 1.0) * step;
        let points: Vec<_> = found.rows.iter().map(|r| (at(r.sensing_slots), r.accuracy[m].mean)).collect();
        let series = plot.series(&format!("{method} ± 1 σ"), style);
        plot.line(series, &points, 1.6);
        for row in &found.rows {
            let (n, a) = (row.sensing_slots, row.accuracy[m]);
            plot.error_bar(series, at(n), a.mean - a.deviation, (a.mean + a.deviation).min(1.0));
            plot.dot(series, (at(n), a.mean), 3.2, &format!("{method}, N_s = {n}: {a}"));
        }
    }
    plot.svg(Medium::SINGLE)
}

/// One bar per condition and way of training, conditions under the name of what they change.
pub fn robustness(found: &Robustness) -> String {
    const LEFT: f64 = 390.0;
    const WIDTH: f64 = 380.0;
    const TOP: f64 = 28.0;
    const STEP: f64 = 21.0;
    const GAP: f64 = 9.0;
    let begins = |k: usize| k > 0 && found.rows[k].factor != found.rows[k - 1].factor;
    let groups = |k: usize| (0..=k).filter(|&k| begins(k)).count() as f64;
    let top = |k: usize| TOP + STEP * k as f64 + GAP * groups(k);
    let bottom = found.rows.len().checked_sub(1).map_or(TOP, |last| top(last) + STEP);
    let height = bottom + 40.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 800 {height}\" width=\"180mm\" height=\"{:.1}mm\" \
         font-family=\"{FONTS}\" font-size=\"12\" fill=\"var(--ink,#222)\" role=\"img\"><title>Accuracy under changed \
         conditions</title>",
        height * 180.0 / 800.0
    );
    let at = |accuracy: f64| LEFT + WIDTH * accuracy.clamp(0.0, 1.0);
    for tick in 0..=5 {
        let accuracy = f64::from(tick) / 5.0;
        let x = at(accuracy);
        let _ = write!(
            svg,
            "<line x1=\"{x}\" x2=\"{x}\" y1=\"{}\" y2=\"{bottom}\" stroke=\"var(--soft,#ddd)\"/><text x=\"{x}\" y=\"{}\" \
             text-anchor=\"middle\">{accuracy}</text>",
            TOP - 4.0,
            bottom + 16.0
        );
    }
    let _ = write!(
        svg,
        "<text class=\"axis-x\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">accuracy (int8, share), N_s = {}; bars: mean, lines: ± 1 σ</text>",
        at(0.5),
        bottom + 33.0,
        found.sensing_slots
    );
    for (k, row) in found.rows.iter().enumerate() {
        let (y, value) = (top(k), escape(&row.value));
        if k == 0 || begins(k) {
            let factor = escape(&row.factor);
            let _ = write!(svg, "<text x=\"8\" y=\"{}\">{factor}</text>", y + 12.0);
        }
        let _ =
            write!(svg, "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{value}</text>", LEFT - 8.0, y + 12.0);
        let bars = [(Some(row.transfer), COLOURS[0]), (row.matched, COLOURS[1])];
        for (bar, (spread, colour)) in bars.into_iter().enumerate() {
            let Some(s) = spread else { continue };
            let (y, x) = (y + 8.0 * bar as f64, at(s.mean));
            let _ = write!(
                svg,
                "<rect x=\"{LEFT}\" y=\"{y}\" width=\"{:.1}\" height=\"7\" fill=\"{colour}\"><title>{}: {value}: {s}</title>\
                 </rect><line x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{m}\" y2=\"{m}\" stroke=\"var(--ink,#222)\"/>",
                x - LEFT,
                escape(&row.factor),
                at(s.mean - s.deviation),
                at(s.mean + s.deviation),
                m = y + 3.5
            );
        }
    }
    let legend = [("trained in the default room", COLOURS[0]), ("trained under the condition", COLOURS[1])];
    for (k, (name, colour)) in legend.into_iter().enumerate() {
        let x = LEFT + 180.0 * k as f64;
        let _ = write!(
            svg,
            "<g class=\"entry\" data-series=\"{k}\"><rect x=\"{x}\" y=\"6\" width=\"10\" height=\"8\" fill=\"{colour}\"/>\
             <text x=\"{}\" y=\"14\">{name}</text></g>",
            x + 14.0
        );
    }
    svg + "</svg>"
}
