//! The vector figures: KL curve, intensity shares, learning curve, losses, region.

use super::plot::{Axis, COLOURS, INK, Plot, SOFT, STYLES, Style, number, style};
use crate::results::{
    Accuracy, BandPoint, Border, Calibration, Case, CurvePoint, Figures, OperatingPoint, Prediction,
    RegionPoint, Zone,
};

/// What a logarithmic axis shows of 0.
const LEAST_KL: f64 = 1e-5;

/// Where rho = 1 stands on an axis of 1 - rho: left of all others.
fn without_uncertainty(c: &Calibration) -> f64 {
    c.curve.iter().map(|p| 1.0 - p.rho).filter(|&x| x > 1e-12).fold(0.1, f64::min) / 3.0
}

/// KL divergence over 1 - rho.
pub fn kl_curve(c: &Calibration) -> Plot {
    let kl = |kl: f64| kl.max(LEAST_KL);
    let all = || c.curve.iter().flat_map(|p| [kl(p.kl), kl(p.kl_without_floor)]);
    let least = without_uncertainty(c);
    let at = |rho: f64| (1.0 - rho).max(least);
    let mut x = Axis::around(c.curve.iter().map(|p| at(p.rho)), "1 − ρ (no unit)");
    (x.log, x.low, x.high) =
        (true, least / 1.5, c.curve.iter().map(|p| at(p.rho)).fold(least, f64::max) * 1.5);
    let mut y = Axis::around(all(), "KL divergence (nat)");
    (y.log, y.low, y.high) = (true, all().fold(1.0, f64::min) / 1.5, all().fold(0.1, f64::max) * 1.5);
    let mut plot = Plot::new("KL divergence over 1 - rho", x, y);
    for (name, style, value) in [
        ("all intensities", STYLES[0], (|p| p.kl) as fn(&crate::results::KlPoint) -> f64),
        ("without the floor", STYLES[1], |p| p.kl_without_floor),
    ] {
        let series = plot.series(name, style);
        let points: Vec<_> = c.curve.iter().map(|p| (at(p.rho), kl(value(p)))).collect();
        plot.line(series, &points, 1.4);
        for (p, point) in c.curve.iter().zip(&points) {
            plot.dot(series, *point, 2.2, &format!("ρ = {}: KL {}", p.rho, number(value(p))));
        }
    }
    if let Some(best) = c.curve.iter().min_by(|a, b| a.kl.total_cmp(&b.kl)) {
        let ring = plot.series("minimum", INK);
        plot.ring(ring, (at(best.rho), kl(best.kl)), &format!("ρ = {}", number(best.rho)));
    }
    if c.curve.iter().any(|p| 1.0 - p.rho < least) {
        let edge = plot.series("ρ = 1 (no uncertainty)", SOFT);
        plot.mark(edge, least, "ρ = 1");
    }
    plot
}

/// Shares of the intensities above black, of the recording (or what stands for it) and simulated.
pub fn pmf(c: &Calibration) -> Plot {
    let levels = c.measured_pmf.len().max(3);
    let x = Axis::new(
        1.0,
        levels as f64 - 1.0,
        &format!("intensity (level 1 to {}, black left out)", levels - 1),
    );
    let shares = c.measured_pmf.iter().skip(1).chain(c.simulated_pmf.iter().skip(1));
    let y = Axis::new(0.0, 110.0 * shares.copied().fold(1e-3, f64::max), "share of pixels (%)");
    let mut plot = Plot::new("Intensity shares", x, y);
    let other = if c.measured.is_some() { "measured" } else { "surrogate, simulated" };
    for (values, style, name) in
        [(&c.measured_pmf, STYLES[1], other), (&c.simulated_pmf, STYLES[0], "simulated")]
    {
        let black = values.first().copied().unwrap_or(0.0);
        let series = plot.series(&format!("{name} (black {:.0} %)", 100.0 * black), style);
        let points: Vec<_> =
            values.iter().enumerate().skip(1).map(|(level, &share)| (level as f64, 100.0 * share)).collect();
        plot.line(series, &points, 1.4);
    }
    plot
}

/// Accuracy over N_s: the measured points with their spread, the best curve with its band, and the other models. `tested` are the
/// points of a run, with both arithmetics.
pub fn learning_curve(prediction: &Prediction, tested: &[Accuracy]) -> Plot {
    let slots = || prediction.points.iter().map(|p| p.sensing_slots);
    let (first, most) = (slots().fold(f64::INFINITY, f64::min), slots().fold(1.0, f64::max));
    let low = prediction.points.iter().map(|p| p.accuracy).fold(1.0, f64::min);
    let x = Axis::new((0.5 * first).min(100.0), most * 1.05, "sensing slots N_s");
    let floor = (low - 0.15).max(0.0);
    let mut plot =
        Plot::new("Accuracy over sensing slots", x, Axis::new(floor, 1.0, "accuracy (share, 0 to 1)"));
    let best = plot.series(&format!("{} (best fit)", prediction.best), STYLES[0]);
    let extrapolated = plot.series("extrapolated", STYLES[0]);
    if let Some(band) = &prediction.band {
        let id = plot.series("95 % band of the curve", STYLES[0]);
        let within = || band.points.iter().filter(|p| p.sensing_slots >= first);
        let edge = |end: fn(&BandPoint) -> f64| -> Vec<(f64, f64)> {
            within().map(|p| (p.sensing_slots, end(p))).collect()
        };
        plot.band(id, &edge(|p| p.low), &edge(|p| p.high));
    }
    let others = plot.series("other models", SOFT);
    for (index, fitted) in prediction.models.iter().enumerate().rev() {
        let points = prediction.slots.iter().zip(&fitted.accuracy).map(|(&n, &a)| (n, a));
        let points: Vec<_> = points.filter(|(_, a)| (floor..=1.0).contains(a)).collect();
        let (series, width) = if index == 0 { (best, 1.8) } else { (others, 0.7) };
        // up to the first measured point the curves say what nobody measured
        let split = points.iter().position(|(n, _)| *n >= first).unwrap_or(points.len());
        let unmeasured = if index == 0 { extrapolated } else { others };
        plot.line(series, &points[split..], width);
        plot.dotted(unmeasured, &points[..(split + 1).min(points.len())], width);
    }
    let spread = |p: &CurvePoint| {
        p.std.or_else(|| Some((p.accuracy * (1.0 - p.accuracy) / p.tested?.max(1.0)).sqrt()))
    };
    let has_spread = prediction.points.iter().any(|p| spread(p).is_some());
    let name = if tested.is_empty() { "points" } else { "int8" };
    let series = plot.series(&if has_spread { format!("{name} ± 1 σ") } else { name.into() }, STYLES[1]);
    for p in &prediction.points {
        let (n, a) = (p.sensing_slots, p.accuracy);
        if let Some(sigma) = spread(p) {
            plot.error_bar(series, n, (a - sigma).max(floor), (a + sigma).min(1.0));
        }
        plot.dot(series, (n, a), 3.2, &format!("N_s = {n}: {a:.3}"));
    }
    if !tested.is_empty() {
        let float = plot.series("float", STYLES[2]);
        for a in tested {
            plot.dot(float, (f64::from(a.sensing_slots), a.float), 2.6, &format!("float {:.3}", a.float));
        }
    }
    plot
}

/// Training loss of every network.
pub fn losses(figures: &Figures) -> Plot {
    let epochs = figures.training.iter().map(|t| t.epochs.len()).max().unwrap_or(1);
    let all = figures.training.iter().flat_map(|t| t.epochs.iter().map(|e| e.loss));
    let mut y = Axis::around(all, "training loss (nat)");
    y.low = y.low.min(0.0);
    let x = Axis { whole: true, ..Axis::new(0.0, epochs as f64, "epoch") };
    let mut plot = Plot::new("Training loss", x, y);
    for (index, training) in figures.training.iter().enumerate() {
        let series = plot.series(&format!("N_s = {}", training.sensing_slots), style(index));
        let points: Vec<_> =
            training.epochs.iter().enumerate().map(|(k, e)| (k as f64 + 1.0, e.loss)).collect();
        plot.line(series, &points, 1.4);
        for point in points.iter().step_by(epochs.div_ceil(6)) {
            plot.dot(series, *point, 2.4, &format!("epoch {}: {:.3}", point.0, point.1));
        }
    }
    plot
}

/// Tint, opacity and name of a zone.
fn zone_tint(zone: Zone) -> (&'static str, f64, &'static str) {
    match zone {
        Zone::CommunicationSaturation => (COLOURS[6], 0.5, "communication saturation"),
        Zone::Adversarial => (COLOURS[2], 0.1, "adversarial"),
        Zone::SensingSaturation => (COLOURS[5], 0.35, "sensing saturation"),
    }
}

/// The accuracy-throughput region: the boundary of every case with its band, the zones, the measured points and the operating
/// point. Where nothing was measured boundaries are dotted, and there are no zones.
pub fn region(all: &[RegionPoint], p: &OperatingPoint, cases: &[Case], measured: &[CurvePoint]) -> Plot {
    let rate = |bit: f64| bit / p.period_s / 1e6;
    let accuracies = all.iter().map(|p| p.accuracy).chain(measured.iter().map(|p| p.accuracy));
    let x = Axis::around(accuracies, "recognition accuracy A (share, 0 to 1)");
    let y = Axis::around(all.iter().map(|p| rate(p.throughput_bit)), "worst throughput R (Mbit/s)");
    let mut plot = Plot::new("Accuracy-throughput region", x, y);
    let mut numbers: Vec<u32> = all.iter().map(|p| p.case).collect();
    numbers.dedup();
    let first: Vec<&RegionPoint> = all.iter().filter(|p| numbers.first() == Some(&p.case)).collect();
    // A follows from N_s alone: the zones are the same in every case
    zones(&mut plot, &first);
    borders(&mut plot, &first, cases.first().map_or(&[], |case| &case.borders));
    for (index, case) in numbers.iter().enumerate() {
        let points: Vec<&RegionPoint> = all.iter().filter(|p| p.case == *case).collect();
        let style = STYLES[index % 2].solid();
        let at = |p: &RegionPoint| (p.accuracy, rate(p.throughput_bit));
        let inside: Vec<&RegionPoint> = points.iter().filter(|p| !p.extrapolated).copied().collect();
        let edge = |end: fn(&RegionPoint) -> Option<f64>| -> Vec<(f64, f64)> {
            inside.iter().filter_map(|p| Some((end(p)?, rate(p.throughput_bit)))).collect()
        };
        let (low, high) = (edge(|p| p.accuracy_low), edge(|p| p.accuracy_high));
        if !low.is_empty() {
            let band = plot.series(&format!("95 % band, case {case}"), style);
            plot.band(band, &low, &high);
        }
        // between the measured points, and beyond them; without any the whole line is beyond
        let from = points.iter().position(|p| !p.extrapolated);
        let to = points.iter().rposition(|p| !p.extrapolated);
        let series = plot.series(
            &format!("case {case}, {}", if from.is_some() { "fitted" } else { "extrapolated" }),
            style,
        );
        if from.is_some() {
            plot.line(series, &inside.iter().map(|p| at(p)).collect::<Vec<_>>(), 1.8);
        }
        for m in measured {
            if let Some(p) = points.iter().find(|p| f64::from(p.sensing_slots) == m.sensing_slots) {
                let says = format!("case {case}, N_s = {}: measured {:.3}", p.sensing_slots, m.accuracy);
                plot.dot(series, (m.accuracy, rate(p.throughput_bit)), 3.0, &says);
            }
        }
        let beyond = match (from, to) {
            (Some(from), Some(to)) => vec![&points[..=from], &points[to..]],
            _ => vec![&points[..]],
        };
        let mut dotted = from.is_none().then_some(series);
        for part in beyond.into_iter().filter(|part| part.len() > 1) {
            let dotted =
                *dotted.get_or_insert_with(|| plot.series(&format!("case {case}, extrapolated"), style));
            plot.dotted(dotted, &part.iter().map(|p| at(p)).collect::<Vec<_>>(), 1.8);
        }
    }
    let ring = plot.series("operating point", INK);
    plot.ring(ring, (p.accuracy, rate(p.throughput_bit)), &format!("N_s = {}", p.sensing_slots));
    plot
}

/// Dashed lines where one zone ends and another begins.
fn borders(plot: &mut Plot, points: &[&RegionPoint], borders: &[Border]) {
    let measured = || points.iter().filter(|p| !p.extrapolated);
    let range = measured().map(|p| p.sensing_slots).min().zip(measured().map(|p| p.sensing_slots).max());
    let inside = |b: &&Border| range.is_some_and(|(low, high)| (low..=high).contains(&b.sensing_slots));
    let borders: Vec<&Border> = borders.iter().filter(inside).collect();
    if borders.is_empty() {
        return;
    }
    let series = plot.series("border of zones", SOFT);
    for border in borders {
        if let Some(p) = measured().min_by_key(|p| p.sensing_slots.abs_diff(border.sensing_slots)) {
            plot.mark(series, p.accuracy, &format!("N_s = {}", border.sensing_slots));
        }
    }
}

/// Every zone as a strip over the accuracies of its measured points.
fn zones(plot: &mut Plot, points: &[&RegionPoint]) {
    let points: Vec<&&RegionPoint> = points.iter().filter(|p| !p.extrapolated).collect();
    let Some(first) = points.first() else { return };
    let mut from = first.accuracy;
    for (k, p) in points.iter().enumerate() {
        let next = points.get(k + 1);
        if next.is_none_or(|next| next.zone != p.zone) {
            let to = next.map_or(p.accuracy, |next| next.accuracy);
            let (colour, opacity, name) = zone_tint(p.zone);
            let series = plot.series(name, Style { colour, ..SOFT });
            plot.strip(series, (from, to), opacity, name);
            from = to;
        }
    }
}
