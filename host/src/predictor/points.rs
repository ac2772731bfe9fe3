//! Accuracies to be fitted, checked once.

use crate::results::CurvePoint;

/// Most points: seven curves, their leave-one-out and their bands take a minute with so many.
pub const MOST: usize = 1000;

/// Why points cannot be fitted.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum FitError {
    /// Fewer than two points.
    #[error("points: {count} given; at least 2 different numbers of sensing slots are needed")]
    TooFew {
        /// Different N_s given.
        count: usize,
    },
    /// More than [`MOST`].
    #[error("points: {count} given; at most {MOST} are fitted")]
    TooMany {
        /// Points given.
        count: usize,
    },
    /// A value is outside its legal range.
    #[error("points: {field} = {value} in point {index} is outside its legal range: {legal}")]
    Value {
        /// Point, from 1.
        index: usize,
        /// Field.
        field: &'static str,
        /// Value.
        value: f64,
        /// Range.
        legal: &'static str,
    },
}

/// Number of different N_s among legal points.
///
/// # Errors
///
/// [`FitError`] names what is wrong.
pub fn check(points: &[CurvePoint]) -> Result<usize, FitError> {
    if points.len() > MOST {
        return Err(FitError::TooMany { count: points.len() });
    }
    for (index, p) in points.iter().enumerate() {
        let refuse = |field, value, legal| Err(FitError::Value { index: index + 1, field, value, legal });
        if !(p.sensing_slots.is_finite() && p.sensing_slots > 1.0) {
            return refuse("sensing_slots", p.sensing_slots, "a number above 1");
        }
        if !(0.0..=1.0).contains(&p.accuracy) {
            return refuse("accuracy", p.accuracy, "0 to 1");
        }
        if let Some(std) = p.std.filter(|s| !(s.is_finite() && *s > 0.0 && *s <= 0.5)) {
            return refuse("std", std, "above 0, at most 0.5");
        }
        if let Some(tested) = p.tested.filter(|n| !(n.is_finite() && *n >= 1.0)) {
            return refuse("tested", tested, "at least 1");
        }
    }
    let mut slots: Vec<f64> = points.iter().map(|p| p.sensing_slots).collect();
    slots.sort_by(f64::total_cmp);
    slots.dedup();
    if slots.len() < 2 {
        return Err(FitError::TooFew { count: slots.len() });
    }
    Ok(slots.len())
}

/// Least and largest N_s.
pub fn range(points: &[CurvePoint]) -> (f64, f64) {
    let slots = points.iter().map(|p| p.sensing_slots);
    (slots.clone().fold(f64::INFINITY, f64::min), slots.fold(0.0, f64::max))
}
