//! Early exits beside static sensing: picture and table.

use super::plot::{Axis, COLOURS, Plot};
use crate::results::AnytimeResult;
use std::fmt::Write;

/// Accuracy against throughput of both, for every user placement.
pub fn region(found: &AnytimeResult) -> String {
    let accuracies = found.region.iter().map(|p| p.point.accuracy);
    let x = Axis::around(
        accuracies.chain(found.static_region.iter().map(|p| p.accuracy)),
        "recognition accuracy A (test recordings)",
    );
    let bits = found.region.iter().map(|p| p.throughput_bit);
    let y = Axis::around(
        bits.chain(found.static_region.iter().map(|p| p.throughput_bit)).map(|bit| bit / 1e6),
        "worst throughput R (Mbit per period)",
    );
    let mut plot = Plot::new("Accuracy-throughput region with early exits and static", x, y);
    let mut cases: Vec<u32> = found.static_region.iter().map(|p| p.case).collect();
    cases.dedup();
    for (index, case) in cases.into_iter().enumerate() {
        let (colour, other) = (COLOURS[index % 7], COLOURS[(index + 4) % 7]);
        let still = found.static_region.iter().filter(|p| p.case == case);
        let line: Vec<_> = still.map(|p| (p.accuracy, p.throughput_bit / 1e6)).collect();
        plot.line(&line, other, 1.5, &format!("static, case {case}"));
        for p in found.static_region.iter().filter(|p| p.case == case) {
            let says = format!("N_s = {}: A = {:.3}", p.sensing_slots, p.accuracy);
            plot.dot(p.accuracy, p.throughput_bit / 1e6, 4.0, other, &says);
        }
        // the envelope was chosen on other recordings: points that turned out dominated stay dots
        let points: Vec<_> = found.region.iter().filter(|p| p.case == case).collect();
        let mut most = f64::NEG_INFINITY;
        let mut line = Vec::new();
        for p in &points {
            if p.point.accuracy > most {
                most = p.point.accuracy;
                line.push((p.point.accuracy, p.throughput_bit / 1e6));
            }
            let says = format!(
                "threshold {:.3}, at most {}: A = {:.3} with {:.0} slots",
                p.point.threshold, p.point.most_sensing_slots, p.point.accuracy, p.point.sensing_slots
            );
            plot.dot(p.point.accuracy, p.throughput_bit / 1e6, 2.5, colour, &says);
        }
        plot.line(&line, colour, 2.0, &format!("early exits, case {case}"));
    }
    plot.standalone()
}

/// The gains in plain text.
pub fn table(found: &AnytimeResult) -> String {
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
        let a = &gain.anytime;
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
        "operating point of case {}: threshold {:.3}, at most {} slots: accuracy {:.3}, {:.0} slots, {:.0} bit per period",
        p.case,
        p.point.threshold,
        p.point.most_sensing_slots,
        p.point.accuracy,
        p.point.sensing_slots,
        p.throughput_bit
    );
    text
}
