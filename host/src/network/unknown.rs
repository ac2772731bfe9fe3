//! The confidence below which a window is of none of the classes, and how well it separates.

use crate::results::Unknown;

/// From the confidences of windows of known classes and of windows of a class that the network never learned: the threshold with the
/// largest sum of known windows kept and unknown ones refused (Youden's index), the lowest of equals, and the area under the ROC curve,
/// ties counted half (Fawcett, 2006). `None` without both kinds. Cost: that of sorting them.
pub fn unknown(mut known: Vec<f64>, mut foreign: Vec<f64>) -> Option<Unknown> {
    if known.is_empty() || foreign.is_empty() {
        return None;
    }
    known.sort_by(f64::total_cmp);
    foreign.sort_by(f64::total_cmp);
    let below = |of: &[f64], limit: f64| of.partition_point(|&confidence| confidence < limit);
    let up_to = |of: &[f64], limit: f64| of.partition_point(|&confidence| confidence <= limit);
    let share = |count: usize, of: &[f64]| count as f64 / of.len() as f64;
    // in whole numbers, so that equals are equal
    let index = |limit: f64| {
        (below(&foreign, limit) * known.len()) as i64 - (below(&known, limit) * foreign.len()) as i64
    };
    let least_confidence =
        known.iter().fold(0.0, |best, &limit| if index(limit) > index(best) { limit } else { best });
    // a known window's share of unknown ones that are less sure
    let less_sure = |&limit: &f64| 0.5 * share(below(&foreign, limit) + up_to(&foreign, limit), &foreign);
    Some(Unknown {
        least_confidence,
        known_kept: share(known.len() - below(&known, least_confidence), &known),
        unknown_refused: share(below(&foreign, least_confidence), &foreign),
        auroc: known.iter().map(less_sure).sum::<f64>() / known.len() as f64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separable_equal_and_reversed_confidences() {
        let apart = unknown(vec![0.9, 0.8, 0.95], vec![0.4, 0.6]).unwrap();
        assert_eq!(
            (apart.least_confidence, apart.known_kept, apart.unknown_refused, apart.auroc),
            (0.8, 1.0, 1.0, 1.0)
        );
        let equal = unknown(vec![0.5; 4], vec![0.5; 3]).unwrap();
        assert_eq!(
            (equal.least_confidence, equal.known_kept, equal.unknown_refused, equal.auroc),
            (0.0, 1.0, 0.0, 0.5)
        );
        // 0.4 keeps all and refuses 1 of 3, 0.6 keeps 2 and refuses 2: equals
        let tied = unknown(vec![0.4, 0.6, 0.8], vec![0.3, 0.5, 0.9]).unwrap();
        assert_eq!((tied.least_confidence, tied.known_kept), (0.4, 1.0));
        // 5 of 6 pairs in order
        let mixed = unknown(vec![0.9, 0.5, 0.7], vec![0.6, 0.3]).unwrap();
        assert!((mixed.auroc - 5.0 / 6.0).abs() < 1e-12, "{mixed:?}");
        assert_eq!(unknown(vec![0.1], vec![0.9]).unwrap().auroc, 0.0);
        assert!(unknown(vec![], vec![0.9]).is_none() && unknown(vec![0.9], vec![]).is_none());
    }
}
