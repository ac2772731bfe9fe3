//! Which curve to trust: squared error, corrected Akaike criterion, leave-one-out, and Mallows' C_p, which chooses.
//!
//! Six points and four parameters leave a flat valley, so the smallest error says little. AICc estimates the noise from each
//! model's own residuals and is hard on three parameters with six points; leave-one-out is ruled by the first point, which no
//! other foretells. C_p holds all models to one noise: that of the counts, where they are known.

use super::fit::fit;
use super::models::Model;
use super::points::{FitError, check};
use crate::results::{CurvePoint, FittedCurve, Prediction, Ranking};

/// Points that are left out one by one; more are left out in so many parts.
const FOLDS: usize = 64;

/// Fits every model with at most as many parameters as there are different N_s; best first. Curves are not yet drawn.
///
/// # Errors
///
/// [`FitError`] names what is wrong with the points.
pub fn fit_all(points: &[CurvePoint]) -> Result<Prediction, FitError> {
    let different = check(points)?;
    let fitted = |model: Model| {
        let (parameters, sse) = fit(model, points);
        let n = points.len() as f64;
        FittedCurve {
            name: model.name().to_owned(),
            parameters,
            accuracy: Vec::new(),
            sse,
            rmse: (sse / n).sqrt(),
            aicc: aicc(sse, points.len(), model.count()),
            loo: (different > model.count()).then(|| leave_one_out(model, points)).flatten(),
        }
    };
    let usable = Model::ALL.into_iter().filter(|model| model.count() <= different);
    let mut models: Vec<FittedCurve> = usable.map(fitted).filter(|m| m.sse.is_finite()).collect();
    let noise = noise(&models, points);
    let cp = |m: &FittedCurve| m.sse / noise + 2.0 * parameters(m) as f64;
    models.sort_by(|a, b| cp(a).total_cmp(&cp(b)));
    let best = models.first().map(|m| m.name.clone()).unwrap_or_default();
    let by = |value: &dyn Fn(&FittedCurve) -> Option<f64>| {
        let mut ranked: Vec<_> = models.iter().filter_map(|m| Some((value(m)?, m.name.clone()))).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        ranked.into_iter().map(|(_, name)| name).collect()
    };
    let ranking = Ranking {
        sse: by(&|m| Some(m.sse)),
        aicc: by(&|m| m.aicc),
        loo: by(&|m| m.loo),
        cp: by(&|m| Some(cp(m))),
    };
    Ok(Prediction { best, points: points.to_vec(), slots: Vec::new(), models, ranking, band: None })
}

fn parameters(m: &FittedCurve) -> usize {
    Model::by_name(&m.name).map_or(0, Model::count)
}

/// Variance of an accuracy: the mean over the points of the stated or else the binomial one if all have either, else what the
/// model with the least residual variance leaves.
fn noise(models: &[FittedCurve], points: &[CurvePoint]) -> f64 {
    let n = points.len();
    let known: Option<f64> = points
        .iter()
        .map(|p| {
            if let Some(std) = p.std {
                return Some(std * std / n as f64);
            }
            // one right and one wrong answer more: all right is no proof of certainty
            let tested = p.tested?;
            let share = (p.accuracy * tested + 1.0) / (tested + 2.0);
            Some(share * (1.0 - share) / tested / n as f64)
        })
        .sum();
    let left = |m: &FittedCurve| {
        let free = n.saturating_sub(parameters(m));
        (free > 0).then(|| m.sse / free as f64)
    };
    let residual = models.iter().filter_map(left).fold(f64::INFINITY, f64::min);
    let least = 1e-12;
    known.unwrap_or(if residual.is_finite() { residual } else { least }).max(least)
}

/// Hurvich and Tsai's corrected criterion (1989) for least squares; the variance counts as a parameter. `None` if there are
/// too few points for it.
fn aicc(sse: f64, points: usize, parameters: usize) -> Option<f64> {
    let (n, k) = (points as f64, parameters as f64 + 1.0);
    let left = n - k - 1.0;
    (left > 0.0).then(|| n * libm::log((sse / n).max(1e-300)) + 2.0 * k + 2.0 * k * (k + 1.0) / left)
}

/// Root mean squared error at each point of the curve fitted to the others; of more than [`FOLDS`] points, to those of other folds.
fn leave_one_out(model: Model, points: &[CurvePoint]) -> Option<f64> {
    let mut sum = 0.0;
    for fold in 0..points.len().min(FOLDS) {
        let inside = |(i, _): &(usize, &CurvePoint)| i % FOLDS == fold;
        let rest: Vec<CurvePoint> =
            points.iter().enumerate().filter(|p| !inside(p)).map(|(_, p)| *p).collect();
        let (parameters, _) = fit(model, &rest);
        for (_, point) in points.iter().enumerate().filter(inside) {
            let at = model.at(&parameters, point.sensing_slots).clamp(0.0, 1.0);
            sum += (at - point.accuracy).powi(2);
        }
    }
    let rms = (sum / points.len() as f64).sqrt();
    rms.is_finite().then_some(rms)
}

#[cfg(test)]
mod tests {
    use super::super::fit::sse;
    use super::super::paper::{POINTS, TABLE_III, printed};
    use super::*;

    fn paper() -> Vec<CurvePoint> {
        let point =
            |(n, accuracy)| CurvePoint { sensing_slots: f64::from(n), accuracy, tested: None, std: None };
        POINTS.map(point).to_vec()
    }

    #[test]
    fn of_many_points_some_are_left_out_together() {
        let model = Model::by_name("vapor_pressure").unwrap();
        let truth = paper();
        let (parameters, _) = fit(model, &truth);
        // seventy points of one curve and one that is 0.1 off: no curve predicts that one
        let point = |k: u32| {
            let sensing_slots = 200.0 + 10.0 * f64::from(k);
            let accuracy = model.at(&parameters, sensing_slots) - if k == 35 { 0.1 } else { 0.0 };
            CurvePoint { sensing_slots, accuracy, tested: None, std: None }
        };
        let points: Vec<CurvePoint> = (0..71).map(point).collect();
        let found = leave_one_out(model, &points).unwrap();
        assert!((found - 0.1 / 71.0_f64.sqrt()).abs() < 2e-3, "{found}");
    }

    #[test]
    fn printed_parameters_give_the_printed_errors() {
        for row in TABLE_III.iter().filter(|row| row.consistent) {
            let found = sse(row.model, &row.model.parameters(row.parameters), &paper());
            assert!((found / row.sse - 1.0).abs() < 0.01, "{}: {found} {}", row.model.name(), row.sse);
        }
    }

    #[test]
    fn fits_are_never_worse_than_the_printed_ones() {
        let prediction = fit_all(&paper()).unwrap();
        assert_eq!(prediction.models.len(), 7);
        let of = |model: Model| prediction.models.iter().find(|m| m.name == model.name()).unwrap();
        assert_eq!(prediction.best, "pow3");
        for model in Model::ALL {
            let row = printed(model).unwrap();
            let printed = match row.consistent {
                true => sse(model, &model.parameters(row.parameters), &paper()),
                false => row.sse,
            };
            assert!(of(model).sse <= printed, "{}: {} {printed}", model.name(), of(model).sse);
            let own = sse(model, &of(model).parameters, &paper());
            assert!((own / of(model).sse - 1.0).abs() < 1e-6, "{}: {own}", model.name());
        }
        let pow3 = of(Model::Pow3);
        assert!((pow3.sse - 3.32e-4).abs() < 2e-6, "{}", pow3.sse);
        assert!((2.4..=2.7).contains(&pow3.parameters.beta), "{:?}", pow3.parameters);
        assert!((0.945..=0.952).contains(&pow3.parameters.gamma.unwrap()));
        assert!(of(Model::Pow4).sse <= pow3.sse && of(Model::Exp4).sse <= pow3.sse * 1.001);
        assert!((of(Model::Ilog2).sse - 3.0286e-3).abs() < 1e-7);
    }

    #[test]
    fn bad_points_are_named() {
        assert_eq!(fit_all(&[]), Err(FitError::TooFew { count: 0 }));
        let many = vec![paper()[0]; 1001];
        assert_eq!(fit_all(&many), Err(FitError::TooMany { count: 1001 }));
        let mut points = paper();
        points[1].accuracy = 1.2;
        assert!(fit_all(&points).unwrap_err().to_string().contains("points, point 2: accuracy is 1.2"));
        points[1].accuracy = f64::NAN;
        assert!(fit_all(&points).is_err());
    }

    #[test]
    fn flat_and_falling_points_get_flat_curves() {
        let flat: Vec<CurvePoint> = paper().into_iter().map(|p| CurvePoint { accuracy: 0.9, ..p }).collect();
        for m in fit_all(&flat).unwrap().models {
            assert!(m.sse < 1e-9, "{m:?}");
        }
        let falling: Vec<CurvePoint> =
            paper().into_iter().map(|p| CurvePoint { accuracy: 1.0 - p.accuracy, ..p }).collect();
        for m in fit_all(&falling).unwrap().models {
            let model = Model::by_name(&m.name).unwrap();
            let (a, b) = (model.at(&m.parameters, 200.0), model.at(&m.parameters, 1000.0));
            assert!(b >= a && b - a < 1e-4, "{m:?}");
        }
    }
}
