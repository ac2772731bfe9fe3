//! The three zones of the boundary, by normalised marginal rates.
//!
//! Section VI-D of the paper describes them; here they are defined. With accuracy and throughput each divided by its
//! span, let s = |dA / dR| along the boundary. s < `trade.zone_ratio`: sensing is saturated (a step of throughput costs hardly
//! any accuracy). s > 1 / `zone_ratio`: communication is saturated. Between: adversarial.

use super::region::Point;
use crate::results::Zone;

/// Zone of every point of a boundary (N_s ascending), by central differences.
pub fn zones(points: &[Point], ratio: f64) -> Vec<Zone> {
    let span = |value: fn(&Point) -> f64| match (points.first(), points.last()) {
        (Some(a), Some(b)) => (value(b) - value(a)).abs().max(1e-300),
        _ => 1.0,
    };
    let (accuracy, throughput) = (span(|p| p.accuracy), span(|p| p.throughput_bit));
    (0..points.len())
        .map(|i| {
            let (a, b) = (&points[i.saturating_sub(1)], &points[(i + 1).min(points.len() - 1)]);
            let gained = (b.accuracy - a.accuracy) / accuracy;
            let paid = (a.throughput_bit - b.throughput_bit) / throughput;
            if gained < ratio * paid {
                Zone::SensingSaturation
            } else if gained * ratio > paid {
                Zone::CommunicationSaturation
            } else {
                Zone::Adversarial
            }
        })
        .collect()
}
