//! The learning curve A(N_s): seven parametric models fitted to measured accuracies.
//!
//! Section IV-B of the paper, Tables II and III and eq. (fitting1). [`shape`] says which curves are admitted, [`fit`] finds the
//! best, [`ranking`] chooses among the models, [`bootstrap`] says how sure that is.

pub mod bootstrap;
pub mod fit;
pub(crate) mod models;
pub mod paper;
pub(crate) mod points;
pub(crate) mod ranking;
pub(crate) mod shape;

pub use models::Model;
pub use points::FitError;
pub use ranking::fit_all;

use crate::results::{Curve, CurvePoint, Prediction};

/// All curves through the points, drawn on a grid, and the best one's confidence band.
///
/// # Errors
///
/// [`FitError`] names what is wrong with the points.
pub fn predict(points: &[CurvePoint], seed: u64) -> Result<Prediction, FitError> {
    let mut prediction = fit_all(points)?;
    prediction.slots = bootstrap::grid(points);
    for fitted in &mut prediction.models {
        let model = Model::by_name(&fitted.name);
        let at = |&n: &f64| model.map_or(0.0, |model| within(model.at(&fitted.parameters, n)));
        fitted.accuracy = prediction.slots.iter().map(at).collect();
    }
    prediction.band = bootstrap::band(&best_curve(&prediction), points, seed);
    Ok(prediction)
}

/// A at `sensing_slots`, clamped to 0 to 1, 0 below the model's domain; `None` if the curve's model is unknown.
pub fn evaluate(curve: &Curve, sensing_slots: f64) -> Option<f64> {
    Some(within(Model::by_name(&curve.model)?.at(&curve.parameters, sensing_slots)))
}

/// What is an accuracy of a model's value.
fn within(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) }
}

/// dA/dN_s, 0 where A is clamped; `None` if the curve's model is unknown.
pub fn slope(curve: &Curve, sensing_slots: f64) -> Option<f64> {
    let model = Model::by_name(&curve.model)?;
    let inside = (0.0..=1.0).contains(&model.at(&curve.parameters, sensing_slots));
    Some(if inside { model.slope(&curve.parameters, sensing_slots).max(0.0) } else { 0.0 })
}

/// The best model of a prediction as a curve.
pub fn best_curve(prediction: &Prediction) -> Curve {
    let best = prediction.models.first();
    Curve {
        model: prediction.best.clone(),
        parameters: best.map(|m| m.parameters).unwrap_or_default(),
        rmse: best.map_or(0.0, |m| m.rmse),
    }
}
