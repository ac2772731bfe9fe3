//! Confidence bands by the bootstrap: what the curve would be had other recordings been tested.
//!
//! Parametric (Efron and Tibshirani, 1993, section 6.5): right answers are redrawn from their binomial law around the fitted
//! curve, the curve is fitted again, and at every N_s the quantiles of the curves are the band. Points without a count are
//! redrawn with the fit's own residual variance.

use super::fit::fit_coarsely;
use super::models::Model;
use super::points::range;
use super::shape::LEAST;
use crate::numerics::random::Random;
use crate::results::{Band, BandPoint, Curve, CurvePoint};
use rayon::prelude::*;

/// Redrawn curves.
pub const DRAWS: u32 = 400;

/// Intervals between the N_s at which curves and bands are stated.
const STEPS: u32 = 48;

/// Share of the redrawn curves within the band.
pub const COVERAGE: f64 = 0.95;

/// Stream number of the redrawn points.
const STREAM: u64 = 201;

/// The curve fitted to each of [`DRAWS`] redrawn sets of points.
pub fn replicates(curve: &Curve, points: &[CurvePoint], seed: u64) -> Vec<Curve> {
    let Some(model) = Model::by_name(&curve.model) else { return Vec::new() };
    let free = points.len().saturating_sub(model.count()).max(1) as f64;
    let spread = curve.rmse * (points.len() as f64 / free).sqrt();
    (0..DRAWS)
        .into_par_iter()
        .map(|draw| {
            let mut random = Random::new(seed, STREAM, 0, u64::from(draw));
            let redraw = |p: &CurvePoint| {
                let mean = model.at(&curve.parameters, p.sensing_slots).clamp(0.0, 1.0);
                let accuracy = match p.tested {
                    Some(tested) => share(&mut random, mean, tested.round() as u64),
                    None => (mean + spread * random.gaussian()).clamp(0.0, 1.0),
                };
                CurvePoint { accuracy, ..*p }
            };
            let redrawn: Vec<CurvePoint> = points.iter().map(redraw).collect();
            Curve { parameters: fit_coarsely(model, &redrawn), ..curve.clone() }
        })
        .collect()
}

/// Share of right answers among `tested`, each right with probability `mean`.
fn share(random: &mut Random, mean: f64, tested: u64) -> f64 {
    let n = tested.max(1);
    if n > 100_000 {
        // the normal law is exact to far below one answer's share
        let deviation = (mean * (1.0 - mean) / n as f64).sqrt();
        return (mean + deviation * random.gaussian()).clamp(0.0, 1.0);
    }
    let right = (0..n).filter(|_| random.uniform() < mean).count();
    right as f64 / n as f64
}

/// Lower and upper end of the band at N_s.
pub fn interval(replicates: &[Curve], sensing_slots: f64) -> (f64, f64) {
    let values = replicates.iter().filter_map(|c| super::evaluate(c, sensing_slots));
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (share * (values.len().saturating_sub(1)) as f64).round() as usize;
        values.get(index).copied().unwrap_or(f64::NAN)
    };
    (at((1.0 - COVERAGE) / 2.0), at((1.0 + COVERAGE) / 2.0))
}

/// The N_s at which curves and bands are stated: the points' range, down to one window.
pub fn grid(points: &[CurvePoint]) -> Vec<f64> {
    let (low, high) = range(points);
    let low = low.min(LEAST);
    (0..=STEPS).map(|step| low + (high - low) * f64::from(step) / f64::from(STEPS)).collect()
}

/// The band on its grid.
pub fn band(curve: &Curve, points: &[CurvePoint], seed: u64) -> Band {
    let replicates = replicates(curve, points, seed);
    let at = |sensing_slots: f64| {
        let (low, high) = interval(&replicates, sensing_slots);
        BandPoint { sensing_slots, low, high }
    };
    let counted = points.iter().all(|p| p.tested.is_some());
    Band {
        model: curve.model.clone(),
        coverage: COVERAGE,
        draws: DRAWS,
        source: if counted { "test counts" } else { "residuals" }.into(),
        points: grid(points).into_iter().map(at).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{best_curve, fit_all};
    use super::*;

    #[test]
    fn bands_cover_the_truth_as_often_as_they_say() {
        // sets of points drawn from a known curve; each band either covers it at N_s = 350 or not
        let truth = |n: f64| 0.95 - 6e4 * libm::pow(n, -2.43);
        let (mut covered, mut width, sets) = (0, 0.0, 24);
        for set in 0..sets {
            let mut random = Random::new(set, 7, 7, 7);
            let draw = |n| CurvePoint {
                sensing_slots: n,
                accuracy: share(&mut random, truth(n), 500),
                tested: Some(500.0),
            };
            let points: Vec<CurvePoint> = [200.0, 300.0, 400.0, 500.0, 600.0, 1000.0].map(draw).to_vec();
            let parameters = fit_coarsely(Model::Pow3, &points);
            let curve = Curve { model: "pow3".into(), parameters, rmse: 0.0 };
            let (low, high) = interval(&replicates(&curve, &points, set), 350.0);
            covered += u32::from((low..=high).contains(&truth(350.0)));
            width += (high - low) / sets as f64;
        }
        // binomial: 19 or fewer of 24 at 95 % happens in 1 of 170 cases
        assert!((20..=24).contains(&covered), "{covered} of {sets}, width {width}");
        assert!((0.01..0.06).contains(&width), "{width}");
    }

    #[test]
    fn more_tests_make_narrower_bands() {
        let points = |tested| {
            super::super::paper::POINTS
                .map(|(n, accuracy)| CurvePoint { sensing_slots: f64::from(n), accuracy, tested })
                .to_vec()
        };
        let width = |tested| {
            let points = points(tested);
            let band = band(&best_curve(&fit_all(&points).unwrap()), &points, 1);
            // below the points the band soon spans all there is
            let within = band.points.iter().filter(|p| p.sensing_slots >= 200.0);
            within.map(|p| p.high - p.low).sum::<f64>()
        };
        assert!(width(Some(500.0)) > 2.0 * width(Some(5000.0)));
        assert!(width(None) > 0.0);
    }
}
