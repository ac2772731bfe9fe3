//! The vector figures: KL curve, intensity shares, learning curve, losses, region.

use super::plot::{Axis, COLOURS, Plot, number};
use crate::results::{BandPoint, Calibration, Figures, RegionPoint, Run, Zone};

/// KL divergence over rho.
pub fn kl_curve(c: &Calibration) -> Plot {
    let mut y = Axis::around(c.curve.iter().map(|p| p.kl.max(1e-5)), "KL divergence (nat)");
    y.log = true;
    y.low = c.curve.iter().map(|p| p.kl.max(1e-5)).fold(1.0, f64::min) / 1.5;
    y.high = c.curve.iter().map(|p| p.kl).fold(0.1, f64::max) * 1.5;
    let x = Axis::around(c.curve.iter().map(|p| p.rho), "rho");
    let mut plot = Plot::new("KL divergence over rho", x, y);
    let points: Vec<_> = c.curve.iter().map(|p| (p.rho, p.kl.max(1e-5))).collect();
    plot.line(&points, COLOURS[0], 2.0, "all intensities");
    let without: Vec<_> = c.curve.iter().map(|p| (p.rho, p.kl_without_black.max(1e-5))).collect();
    plot.line(&without, COLOURS[5], 1.5, "without black");
    if let Some(best) = c.curve.iter().min_by(|a, b| a.kl.total_cmp(&b.kl)) {
        plot.mark(best.rho, &format!("minimum at {}", number(best.rho)));
        plot.dot(best.rho, best.kl.max(1e-5), 5.0, COLOURS[1], &format!("KL {}", number(best.kl)));
    }
    plot
}

/// Shares of the intensities above black, measured and simulated.
pub fn pmf(c: &Calibration) -> Plot {
    let levels = c.measured_pmf.len().max(3);
    let x =
        Axis { low: 1.0, high: levels as f64 - 1.0, name: "intensity (black left out)".into(), log: false };
    let mut y =
        Axis::around(c.measured_pmf.iter().chain(&c.simulated_pmf).copied().filter(|&p| p < 0.3), "share");
    y.low = 0.0;
    y.high =
        c.measured_pmf.iter().skip(1).chain(c.simulated_pmf.iter().skip(1)).copied().fold(1e-3, f64::max)
            * 1.1;
    let mut plot = Plot::new("Intensity shares", x, y);
    for (values, colour, name) in
        [(&c.measured_pmf, COLOURS[1], "measured"), (&c.simulated_pmf, COLOURS[0], "simulated")]
    {
        let points: Vec<_> =
            values.iter().enumerate().skip(1).map(|(level, &share)| (level as f64, share)).collect();
        let black = values.first().copied().unwrap_or(0.0);
        plot.line(&points, colour, 2.0, &format!("{name} (black {:.0} %)", 100.0 * black));
    }
    plot
}

/// Accuracy over N_s: points with their binomial spread, the best curve and the others.
pub fn learning_curve(run: &Run, figures: &Figures) -> Plot {
    let most = run.accuracy.iter().map(|a| f64::from(a.sensing_slots)).fold(200.0, f64::max);
    let x = Axis { low: 100.0, high: most * 1.05, name: "sensing slots N_s".into(), log: false };
    let low = run.accuracy.iter().map(|a| a.int8).fold(1.0, f64::min);
    let y = Axis { low: (low - 0.15).max(0.0), high: 1.0, name: "accuracy".into(), log: false };
    let floor = y.low;
    let mut plot = Plot::new("Accuracy over sensing slots", x, y);
    let prediction = &figures.prediction;
    if let Some(band) = &prediction.band {
        let edge = |end: fn(&BandPoint) -> f64| -> Vec<(f64, f64)> {
            band.points.iter().map(|p| (p.sensing_slots, end(p))).collect()
        };
        plot.band(&edge(|p| p.low), &edge(|p| p.high), COLOURS[0]);
    }
    for (index, fitted) in prediction.models.iter().enumerate().rev() {
        let points: Vec<_> = prediction
            .slots
            .iter()
            .zip(&fitted.accuracy)
            .map(|(&n, &a)| (n, a))
            .filter(|(_, a)| (floor..1.0).contains(a))
            .collect();
        let (colour, width) = if index == 0 { (COLOURS[0], 2.5) } else { ("var(--soft,#999)", 0.8) };
        let name = if index == 0 { format!("{} (best fit), 95 % band", fitted.name) } else { String::new() };
        plot.line(&points, colour, width, &name);
    }
    for a in &run.accuracy {
        let (n, p) = (f64::from(a.sensing_slots), a.int8);
        let spread = (p * (1.0 - p) / f64::from(a.tested.max(1))).sqrt();
        plot.error_bar(n, p - spread, p + spread, COLOURS[1]);
        let says = format!("N_s = {n}: int8 {p:.3}, float {:.3}, {} recordings", a.float, a.tested);
        plot.dot(n, p, 4.5, COLOURS[1], &says);
        plot.dot(n, a.float, 3.0, COLOURS[2], &says);
    }
    plot.entry("the other models", "var(--soft,#999)");
    plot.entry("int8 through the core", COLOURS[1]);
    plot.entry("float", COLOURS[2]);
    plot
}

/// Training loss of every network.
pub fn losses(figures: &Figures) -> Plot {
    let epochs = figures.training.iter().map(|t| t.epochs.len()).max().unwrap_or(1);
    let x = Axis { low: 0.0, high: epochs as f64, name: "epoch".into(), log: false };
    let all = figures.training.iter().flat_map(|t| t.epochs.iter().map(|e| e.loss));
    let mut y = Axis::around(all, "training loss (nat)");
    y.low = y.low.min(0.0);
    let mut plot = Plot::new("Training loss", x, y);
    for (index, training) in figures.training.iter().enumerate() {
        let points: Vec<_> =
            training.epochs.iter().enumerate().map(|(k, e)| (k as f64 + 1.0, e.loss)).collect();
        plot.line(&points, COLOURS[index % 7], 1.8, &format!("N_s = {}", training.sensing_slots));
    }
    plot
}

fn zone_colour(zone: Zone) -> (&'static str, &'static str) {
    match zone {
        Zone::CommunicationSaturation => (COLOURS[4], "communication saturation"),
        Zone::Adversarial => (COLOURS[2], "adversarial"),
        Zone::SensingSaturation => (COLOURS[3], "sensing saturation"),
    }
}

/// The accuracy-throughput region: the cases' boundaries over the zones, the first one's band, and the operating point.
pub fn region(run: &Run, figures: &Figures) -> Plot {
    let x = Axis::around(run.region.iter().map(|p| p.accuracy), "recognition accuracy A");
    let y = Axis::around(run.region.iter().map(|p| p.throughput_bit / 1e6), "throughput R (Mbit per period)");
    let (low, high) = (x.low, x.high);
    let mut plot = Plot::new("Accuracy-throughput region", x, y);
    let mut cases: Vec<u32> = run.region.iter().map(|p| p.case).collect();
    cases.dedup();
    for (index, case) in cases.iter().enumerate() {
        let points: Vec<&RegionPoint> = run.region.iter().filter(|p| p.case == *case).collect();
        let at = |accuracy: f64, p: &RegionPoint| (accuracy, p.throughput_bit / 1e6);
        if index == 0 {
            // A follows from N_s alone: the zones are the same in every case
            zones(&mut plot, &points, (low, high));
            let borders = figures.cases.iter().filter(|c| c.case == *case).flat_map(|c| &c.borders);
            for border in borders {
                let nearest = points.iter().min_by_key(|p| p.sensing_slots.abs_diff(border.sensing_slots));
                if let Some(p) = nearest {
                    plot.mark(p.accuracy, &format!("N_s = {}", border.sensing_slots));
                }
            }
            let edge = |end: fn(&RegionPoint) -> Option<f64>| -> Vec<(f64, f64)> {
                points.iter().filter_map(|p| Some(at(end(p)?, p))).collect()
            };
            plot.band(&edge(|p| p.accuracy_low), &edge(|p| p.accuracy_high), COLOURS[0]);
        }
        let (colour, band) = (COLOURS[index % 2], if index == 0 { ", 95 % band" } else { "" });
        let line: Vec<_> = points.iter().map(|p| at(p.accuracy, p)).collect();
        plot.line(&line, colour, 2.5, &format!("case {case}{band}"));
        for p in &points {
            let says = format!(
                "case {case}: N_s = {}, A = {:.4}, R = {:.0} bit, {}",
                p.sensing_slots,
                p.accuracy,
                p.throughput_bit,
                zone_colour(p.zone).1
            );
            plot.dot(p.accuracy, p.throughput_bit / 1e6, 1.5, colour, &says);
        }
    }
    for zone in [Zone::CommunicationSaturation, Zone::Adversarial, Zone::SensingSaturation] {
        let (colour, name) = zone_colour(zone);
        plot.entry(name, colour);
    }
    let p = &run.operating_point;
    let (px, py) = plot.at(p.accuracy, p.throughput_bit / 1e6);
    plot.raw(&format!(
        "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"8\" fill=\"none\" stroke=\"var(--ink,#222)\" stroke-width=\"2\"/>\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">N_s = {}</text>",
        px - 12.0,
        py + 22.0,
        p.sensing_slots
    ));
    plot
}

/// Every zone as a strip over the accuracies of its points, the outer ones up to the picture's edge.
fn zones(plot: &mut Plot, points: &[&RegionPoint], (low, high): (f64, f64)) {
    let mut from = low;
    for (k, p) in points.iter().enumerate() {
        let next = points.get(k + 1);
        if next.is_none_or(|next| next.zone != p.zone) {
            let to = next.map_or(high, |next| next.accuracy);
            let (colour, name) = zone_colour(p.zone);
            plot.strip((from, to), colour, name);
            from = to;
        }
    }
}
