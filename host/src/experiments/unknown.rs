//! The confidence below which a window is of none of the classes, and how well it separates.

use crate::results::Unknown;

/// From the confidences of windows of known classes and of windows of a class that the network never learned: the threshold with the
/// largest sum of known windows kept and unknown ones refused (Youden's index), the lowest of equals, and the area under the ROC curve,
/// ties counted half (Fawcett, 2006). `None` without both kinds.
pub fn unknown(known: &[f64], foreign: &[f64]) -> Option<Unknown> {
    let share = |of: &[f64], holds: &dyn Fn(f64) -> bool| {
        of.iter().filter(|&&confidence| holds(confidence)).count() as f64 / of.len() as f64
    };
    if known.is_empty() || foreign.is_empty() {
        return None;
    }
    let mut thresholds: Vec<f64> = [0.0].iter().chain(known).copied().collect();
    thresholds.sort_by(f64::total_cmp);
    thresholds.dedup();
    let at = |least_confidence: f64| Unknown {
        least_confidence,
        known_kept: share(known, &|confidence| confidence >= least_confidence),
        unknown_refused: share(foreign, &|confidence| confidence < least_confidence),
        auroc: 0.0,
    };
    let index = |found: &Unknown| found.known_kept + found.unknown_refused;
    let mut best = at(0.0);
    for found in thresholds.into_iter().map(at) {
        if index(&found) > index(&best) {
            best = found;
        }
    }
    let above = |confidence: f64| {
        share(foreign, &|other| other < confidence) + 0.5 * share(foreign, &|other| other == confidence)
    };
    let auroc = known.iter().map(|&confidence| above(confidence)).sum::<f64>() / known.len() as f64;
    Some(Unknown { auroc, ..best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separable_equal_and_reversed_confidences() {
        let apart = unknown(&[0.9, 0.8, 0.95], &[0.4, 0.6]).unwrap();
        assert_eq!(
            (apart.least_confidence, apart.known_kept, apart.unknown_refused, apart.auroc),
            (0.8, 1.0, 1.0, 1.0)
        );
        let equal = unknown(&[0.5; 4], &[0.5; 3]).unwrap();
        assert_eq!(
            (equal.least_confidence, equal.known_kept, equal.unknown_refused, equal.auroc),
            (0.0, 1.0, 0.0, 0.5)
        );
        // 5 of 6 pairs in order
        let mixed = unknown(&[0.9, 0.5, 0.7], &[0.6, 0.3]).unwrap();
        assert!((mixed.auroc - 5.0 / 6.0).abs() < 1e-12, "{mixed:?}");
        assert_eq!(unknown(&[0.1], &[0.9]).unwrap().auroc, 0.0);
        assert!(unknown(&[], &[0.9]).is_none() && unknown(&[0.9], &[]).is_none());
    }
}
