//! Early exits beside static sensing: picture and table.

use super::plot::{Axis, Plot, style};
use crate::results::EarlyExitResult;
use std::fmt::Write;

/// Accuracy against throughput of both, for every user placement; a period lasts `period_s`.
pub fn region(found: &EarlyExitResult, period_s: f64) -> Plot {
    let rate = |bit: f64| bit / period_s / 1e6;
    let accuracies = found.region.iter().map(|p| p.point.accuracy);
    let accuracies = accuracies.chain(found.static_region.iter().map(|p| p.accuracy));
    let bits = found.region.iter().map(|p| p.throughput_bit);
    let bits = bits.chain(found.static_region.iter().map(|p| p.throughput_bit));
    let x = Axis::around(accuracies, "recognition accuracy A (share, test recordings)");
    let y = Axis::around(bits.map(rate), "worst throughput R (Mbit/s)");
    let mut plot = Plot::new("Accuracy-throughput region with early exits and static", x, y);
    let mut cases: Vec<u32> = found.static_region.iter().map(|p| p.case).collect();
    cases.dedup();
    for (index, case) in cases.into_iter().enumerate() {
        let of = |k: usize| style(2 * index + k);
        let still = plot.series(&format!("static, case {case}"), of(1));
        let own = || found.static_region.iter().filter(|p| p.case == case);
        plot.line(still, &own().map(|p| (p.accuracy, rate(p.throughput_bit))).collect::<Vec<_>>(), 1.4);
        for p in own() {
            let says = format!("N_s = {}: A = {:.3}", p.sensing_slots, p.accuracy);
            plot.dot(still, (p.accuracy, rate(p.throughput_bit)), 3.2, &says);
        }
        // the envelope was chosen on other recordings: points that turned out dominated stay dots
        let early = plot.series(&format!("early exits, case {case}"), of(0));
        let (mut most, mut line) = (f64::NEG_INFINITY, Vec::new());
        for p in found.region.iter().filter(|p| p.case == case) {
            let at = (p.point.accuracy, rate(p.throughput_bit));
            if p.point.accuracy > most {
                most = p.point.accuracy;
                line.push(at);
            }
            let says = format!(
                "threshold {:.3}, at most {}: A = {:.3} with {:.0} slots",
                p.point.threshold, p.point.most_sensing_slots, p.point.accuracy, p.point.sensing_slots
            );
            plot.dot(early, at, 2.0, &says);
        }
        plot.line(early, &line, 1.4);
    }
    plot
}

/// The gains in plain text.
pub fn table(found: &EarlyExitResult, period_s: f64) -> String {
    let mut text = format!(
        "weights and thresholds from {} recordings, figures from {} others\n{:>9}{:>10}{:>8}{:>11}{:>8}{:>10}{:>12}{:>8}{:>12}\n",
        found.calibrated_on,
        found.tested,
        "static",
        "accuracy",
        "fused",
        "threshold",
        "at most",
        "accuracy",
        "confidence",
        "slots",
        "slots saved"
    );
    for (gain, fused) in found.gains.iter().zip(&found.fused_accuracy) {
        let a = &gain.early_exit;
        let threshold = if a.threshold > 1.0 { "never".to_owned() } else { format!("{:.3}", a.threshold) };
        let _ = writeln!(
            text,
            "{:>9}{:>10.3}{fused:>8.3}{threshold:>11}{:>8}{:>10.3}{:>12.3}{:>8.0}{:>11.1}%",
            gain.static_slots,
            gain.static_accuracy,
            a.most_sensing_slots,
            a.accuracy,
            a.confidence,
            a.sensing_slots,
            100.0 * gain.saved
        );
    }
    let p = &found.operating_point;
    let _ = write!(
        text,
        "operating point of case {}: threshold {:.3}, at most {} slots: accuracy {:.3}, {:.0} slots, {:.0} bit per period ({:.3} Mbit/s)\n{}",
        p.case,
        p.point.threshold,
        p.point.most_sensing_slots,
        p.point.accuracy,
        p.point.sensing_slots,
        p.throughput_bit,
        p.throughput_bit / period_s / 1e6,
        found.channels
    );
    text
}
