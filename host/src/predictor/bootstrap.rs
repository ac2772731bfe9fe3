//! Confidence bands by the bootstrap: what the curve would be had other recordings been tested.
//!
//! Parametric (Efron and Tibshirani, 1993, section 6.5): right answers are redrawn from their binomial law around the fitted
//! curve, the curve is fitted again, and at every N_s the quantiles of the curves are the band. Points with a stated standard
//! deviation are redrawn with it. Points with neither are redrawn with the fit's own residual deviation, widened by Student's t for
//! its degrees of freedom; without a degree of freedom there is no band.

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

/// Student's t at 97.5 % for 1 to 30 degrees of freedom.
const STUDENT: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
    2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
];
/// The same of the normal law.
const NORMAL: f64 = 1.960;

/// Deviation of points without one of their own; `None` if the residuals leave no degree of freedom.
fn residual(curve: &Curve, model: Model, points: &[CurvePoint]) -> Option<f64> {
    let free = points.len().checked_sub(model.count()).filter(|free| *free > 0)?;
    let student = STUDENT.get(free - 1).copied().unwrap_or(NORMAL);
    Some(curve.rmse * (points.len() as f64 / free as f64).sqrt() * student / NORMAL)
}

/// The curve fitted to each of [`DRAWS`] redrawn sets of points; none where nothing says how sure the points are.
pub fn replicates(curve: &Curve, points: &[CurvePoint], seed: u64) -> Vec<Curve> {
    let Some(model) = Model::by_name(&curve.model) else { return Vec::new() };
    let known = points.iter().all(|p| p.tested.or(p.std).is_some());
    let spread = match residual(curve, model, points) {
        None if !known => return Vec::new(),
        spread => spread.unwrap_or(0.0),
    };
    (0..DRAWS)
        .into_par_iter()
        .map(|draw| {
            let mut random = Random::new(seed, STREAM, 0, u64::from(draw));
            let redraw = |p: &CurvePoint| {
                let mean = model.at(&curve.parameters, p.sensing_slots).clamp(0.0, 1.0);
                let accuracy = match (p.std, p.tested) {
                    (Some(std), _) => (mean + std * random.gaussian()).clamp(0.0, 1.0),
                    (None, Some(tested)) => {
                        // all right is no proof of certainty: one more answer might be wrong
                        let least = 1.0 / (tested + 2.0);
                        share(&mut random, mean.clamp(least, 1.0 - least), tested.round() as u64)
                    }
                    (None, None) => (mean + spread * random.gaussian()).clamp(0.0, 1.0),
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

/// The band on its grid, if there is one.
pub fn band(curve: &Curve, points: &[CurvePoint], seed: u64) -> Option<Band> {
    let replicates = replicates(curve, points, seed);
    if replicates.is_empty() {
        return None;
    }
    let at = |sensing_slots: f64| {
        let (low, high) = interval(&replicates, sensing_slots);
        BandPoint { sensing_slots, low, high }
    };
    let source = if points.iter().all(|p| p.std.is_some()) {
        "stated deviations"
    } else if points.iter().all(|p| p.std.or(p.tested).is_some()) {
        "test counts"
    } else {
        "residuals"
    };
    Some(Band {
        model: curve.model.clone(),
        coverage: COVERAGE,
        draws: DRAWS,
        source: source.into(),
        points: grid(points).into_iter().map(at).collect(),
    })
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
                std: None,
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
                .map(|(n, accuracy)| CurvePoint { sensing_slots: f64::from(n), accuracy, tested, std: None })
                .to_vec()
        };
        let width = |tested| {
            let points = points(tested);
            let band = band(&best_curve(&fit_all(&points).unwrap()), &points, 1).unwrap();
            // below the points the band soon spans all there is
            let within = band.points.iter().filter(|p| p.sensing_slots >= 200.0);
            within.map(|p| p.high - p.low).sum::<f64>()
        };
        assert!(width(Some(500.0)) > 2.0 * width(Some(5000.0)));
        assert!(width(None) > 0.0);
    }

    #[test]
    fn a_band_has_a_width_where_every_recording_was_right() {
        let points = [200.0, 300.0, 400.0, 600.0, 1000.0].map(|sensing_slots| CurvePoint {
            sensing_slots,
            accuracy: 1.0,
            tested: Some(20.0),
            std: None,
        });
        let curve = best_curve(&fit_all(&points).unwrap());
        let band = band(&curve, &points, 1).unwrap();
        assert!(band.points.iter().all(|p| p.low < 0.99 && p.high - p.low > 0.01), "{band:?}");
    }

    #[test]
    fn few_points_have_an_honest_band_or_none() {
        let points = |std| {
            [(200.0, 0.78), (400.0, 0.91), (1000.0, 0.95)]
                .map(|(sensing_slots, accuracy)| CurvePoint { sensing_slots, accuracy, tested: None, std })
                .to_vec()
        };
        let of = |model: Model, points: &[CurvePoint]| {
            let all = fit_all(points).unwrap();
            let m = all.models.iter().find(|m| m.name == model.name()).unwrap();
            let curve = Curve { model: m.name.clone(), parameters: m.parameters, rmse: m.rmse };
            (m.rmse, band(&curve, points, 1))
        };
        assert_eq!(of(Model::Pow3, &points(None)).1, None);
        let width = |band: Option<Band>| band.unwrap().points.last().map(|p| p.high - p.low).unwrap();
        // one degree of freedom: t = 12.7
        let (rmse, found) = of(Model::VaporPressure, &points(None));
        assert!(width(found) > 4.0 * rmse);
        let stated = of(Model::Pow3, &points(Some(0.02))).1;
        assert_eq!(stated.as_ref().map(|b| b.source.as_str()), Some("stated deviations"));
        assert!((0.02..0.12).contains(&width(stated)));
    }
}
