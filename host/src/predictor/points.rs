//! Accuracies to be fitted, checked once.

use crate::error::Invalid;
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
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
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
        let slots = p.sensing_slots.is_finite() && p.sensing_slots > 1.0;
        let (std, tested) = (p.std.unwrap_or(0.5), p.tested.unwrap_or(1.0));
        Invalid::unless(slots, "sensing_slots", p.sensing_slots, "a number above 1")
            .and(Invalid::unless((0.0..=1.0).contains(&p.accuracy), "accuracy", p.accuracy, "0 to 1"))
            .and(Invalid::unless(std > 0.0 && std <= 0.5, "std", std, "above 0, at most 0.5"))
            .and(Invalid::unless(tested.is_finite() && tested >= 1.0, "tested", tested, "at least 1"))
            .map_err(|invalid| invalid.at(format!("points, point {}", index + 1)))?;
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
