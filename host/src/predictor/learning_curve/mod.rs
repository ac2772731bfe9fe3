//! The learning curve A(N_s): seven parametric models fitted to measured accuracies.
//!
//! Section IV-B of the paper, Table II and eq. (fitting1). Fits are ranked by squared error; AICc and leave-one-out
//! stand beside it, since with six points the valley is flat.

pub mod fit;
pub mod models;

pub use fit::{FitError, fit_all};
pub use models::Model;

use crate::results::Curve;

/// A at `sensing_slots`, clamped to 0..=1; `None` if the curve's model is unknown.
pub fn evaluate(curve: &Curve, sensing_slots: f64) -> Option<f64> {
    Some(Model::by_name(&curve.model)?.at(&curve.parameters, sensing_slots).clamp(0.0, 1.0))
}

/// The smallest N_s, in steps of one slot, whose accuracy reaches `accuracy`; `None` if none up to `most` does.
pub fn inverse(curve: &Curve, accuracy: f64, most: u32) -> Option<u32> {
    let reaches = |n: u32| evaluate(curve, f64::from(n)).is_some_and(|a| a >= accuracy);
    if !reaches(most) {
        return None;
    }
    let (mut low, mut high) = (0, most);
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if reaches(middle) { high = middle } else { low = middle }
    }
    Some(high)
}
