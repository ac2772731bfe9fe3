//! The three zones of the boundary, by normalised marginal rates.
//!
//! Section VI-D of the paper describes them; here they are defined. With accuracy and throughput each divided by its span over the
//! boundary, let s = |dA / dR| along it; since R falls linearly in N_s (Theorem 1), s is the curve's slope over its mean slope.
//! s < `optimizer.zone_ratio`: sensing is saturated (a step of throughput costs hardly any accuracy). s > 1 / `zone_ratio`:
//! communication is saturated. Between: adversarial.

use crate::predictor::{evaluate, slope};
use crate::results::{Border, Curve, Zone};

/// Accuracies that rise less than this over the boundary do not depend on N_s: one answer in a thousand.
pub const LEAST_RISE: f64 = 1e-3;

/// The zones of a curve over a range of N_s.
#[derive(Debug, Clone)]
pub struct Zones<'a> {
    curve: &'a Curve,
    range: (u32, u32),
    /// N_s between the first and the last measured point.
    measured: (f64, f64),
    ratio: f64,
    /// Nothing where the accuracy does not depend on N_s.
    mean_slope: Option<f64>,
}

impl<'a> Zones<'a> {
    /// Zones of `curve`, fitted to points of N_s between `measured`, over `range` with the thresholds `ratio` and 1 / `ratio`.
    pub fn new(curve: &'a Curve, range: (u32, u32), measured: (f64, f64), ratio: f64) -> Self {
        let at = |n: u32| evaluate(curve, f64::from(n)).unwrap_or(0.0);
        let span = f64::from(range.1 - range.0).max(1.0);
        let rise = at(range.1) - at(range.0);
        Zones { curve, range, measured, ratio, mean_slope: (rise >= LEAST_RISE).then_some(rise / span) }
    }

    /// Whether N_s lies outside the points that the curve was fitted to.
    pub fn extrapolated(&self, sensing_slots: u32) -> bool {
        !(self.measured.0..=self.measured.1).contains(&f64::from(sensing_slots))
    }

    /// |dA / dR| at N_s, both normalised; 0 where the accuracy does not depend on N_s.
    pub fn marginal(&self, sensing_slots: f64) -> f64 {
        self.mean_slope.map_or(0.0, |mean| slope(self.curve, sensing_slots).unwrap_or(0.0) / mean)
    }

    pub fn at(&self, sensing_slots: u32) -> Zone {
        let marginal = self.marginal(f64::from(sensing_slots));
        if marginal < self.ratio {
            Zone::SensingSaturation
        } else if marginal * self.ratio > 1.0 {
            Zone::CommunicationSaturation
        } else {
            Zone::Adversarial
        }
    }

    /// The first N_s of every zone but the first, ascending.
    pub fn borders(&self) -> Vec<Border> {
        let mut borders = Vec::new();
        let mut before = self.at(self.range.0);
        for sensing_slots in self.range.0..=self.range.1 {
            let zone = self.at(sensing_slots);
            if zone != before {
                let marginal = self.marginal(f64::from(sensing_slots));
                let extrapolated = self.extrapolated(sensing_slots);
                borders.push(Border { sensing_slots, from: before, to: zone, marginal, extrapolated });
                before = zone;
            }
        }
        borders
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::Parameters;

    #[test]
    fn borders_lie_where_the_marginal_rate_passes_its_thresholds() {
        let parameters = Parameters { alpha: 61906.0, beta: 2.4297, gamma: Some(0.9499), epsilon: None };
        let curve = Curve { model: "pow3".into(), parameters, rmse: 0.0 };
        let zones = Zones::new(&curve, (128, 1000), (200.0, 1000.0), 0.2);
        let borders = zones.borders();
        assert_eq!(borders.len(), 2);
        for (border, threshold) in borders.iter().zip([5.0, 0.2]) {
            // slope(n) = threshold x mean, solved by hand for n^-3.4297
            let span = 61906.0 * (libm::pow(128.0, -2.4297) - libm::pow(1000.0, -2.4297)) / 872.0;
            let exact = libm::pow(threshold * span / (61906.0 * 2.4297), -1.0 / 3.4297);
            assert_eq!(f64::from(border.sensing_slots), exact.ceil(), "{border:?}");
        }
        assert_eq!(borders.iter().map(|b| b.extrapolated).collect::<Vec<_>>(), [true, false]);
        let flat = Parameters { alpha: 0.0, ..parameters };
        let flat = Curve { parameters: flat, ..curve.clone() };
        let zones = Zones::new(&flat, (128, 1000), (200.0, 1000.0), 0.2);
        assert!(zones.borders().is_empty() && zones.at(400) == Zone::SensingSaturation);
        assert_eq!(borders[0].from, Zone::CommunicationSaturation);
        assert_eq!(borders[1].to, Zone::SensingSaturation);
    }
}
