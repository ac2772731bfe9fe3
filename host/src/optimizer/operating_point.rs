//! Choosing a point on the boundary: by weights, by a least accuracy, or by a least throughput.
//!
//! Problem P of the paper: max w_A A + w_R R, either as printed (R in bits per period) or with both divided by their span over
//! the boundary so that weights compare.

use super::region::Point;
use super::zones::LEAST_RISE;

/// How the operating point is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rule {
    /// Weight of accuracy; throughput has the rest; both over their span.
    Weighted(f64),
    /// w_A and w_R as printed: accuracy in 0 to 1, throughput in bits per period.
    Weights(f64, f64),
    /// The fewest sensing slots that reach this accuracy.
    AccuracyAtLeast(f64),
    /// The most sensing slots that leave this throughput in bits per period.
    ThroughputAtLeast(f64),
}

impl Rule {
    /// The rule in words.
    pub fn words(self) -> String {
        match self {
            Rule::Weighted(w) => {
                let rest = ((1.0 - w) * 1e9).round() / 1e9;
                format!("largest {w} A + {rest} R, both over their span on the boundary")
            }
            Rule::Weights(a, r) => format!("largest {a} A + {r} R, R in bit per period"),
            Rule::AccuracyAtLeast(a) => format!("most throughput with accuracy at least {a}"),
            Rule::ThroughputAtLeast(r) => {
                format!("most accuracy with throughput at least {r} bit per period")
            }
        }
    }
}

/// Index of the chosen point, the first of equals; `None` if no point satisfies the rule.
pub fn choose(points: &[Point], rule: Rule) -> Option<usize> {
    choose_within(points, points, rule)
}

/// As [`choose`], with the spans of [`Rule::Weighted`] those of `all`.
pub fn choose_within(points: &[Point], all: &[Point], rule: Rule) -> Option<usize> {
    let best = |score: &dyn Fn(&Point) -> Option<f64>| {
        let mut found: Option<(usize, f64)> = None;
        for (index, point) in points.iter().enumerate() {
            if let Some(score) = score(point).filter(|&s| found.is_none_or(|(_, most)| s > most)) {
                found = Some((index, score));
            }
        }
        found.map(|(index, _)| index)
    };
    match rule {
        Rule::Weighted(w) => {
            let range = |value: fn(&Point) -> f64| {
                let low = all.iter().map(value).fold(f64::INFINITY, f64::min);
                let high = all.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
                (low, high - low)
            };
            let (a, r) = (range(|p| p.accuracy), range(|p| p.throughput_bit));
            // what does not change has no span to be compared by
            let share = |value: f64, (low, span): (f64, f64), least: f64| {
                if span < least { 0.0 } else { (value - low) / span }
            };
            best(&|p| {
                let accuracy = share(p.accuracy, a, LEAST_RISE);
                Some(w * accuracy + (1.0 - w) * share(p.throughput_bit, r, f64::MIN_POSITIVE))
            })
        }
        Rule::Weights(a, r) => best(&|p| Some(a * p.accuracy + r * p.throughput_bit)),
        Rule::AccuracyAtLeast(least) => best(&|p| (p.accuracy >= least).then_some(p.throughput_bit)),
        Rule::ThroughputAtLeast(least) => best(&|p| (p.throughput_bit >= least).then_some(p.accuracy)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(sensing_slots: u32, accuracy: f64) -> Point {
        let throughput_bit = f64::from(4000 - sensing_slots);
        Point { sensing_slots, shares: Vec::new(), accuracy, throughput_bit }
    }

    #[test]
    fn an_accuracy_that_does_not_change_is_worth_no_slots() {
        let noise = |k: u32| 1e-12 * f64::from((k * 7) % 5);
        let flat: Vec<Point> = (0..20).map(|k| point(200 + 10 * k, 0.5 + noise(k))).collect();
        assert_eq!(choose(&flat, Rule::Weighted(0.9)), Some(0));
        let rising: Vec<Point> = (0..20).map(|k| point(200 + 10 * k, 0.5 + 0.02 * f64::from(k))).collect();
        assert_eq!(choose(&rising, Rule::Weighted(0.9)), Some(19));
    }

    #[test]
    fn the_spans_of_more_points_may_make_another_point_the_best() {
        // of these two the first has all the throughput, of all three nearly as much as the second
        let all = [point(100, 0.50), point(200, 0.51), point(3000, 0.505)];
        assert_eq!(choose(&all[..2], Rule::Weighted(0.4)), Some(0));
        assert_eq!(choose_within(&all[..2], &all, Rule::Weighted(0.4)), Some(1));
    }
}
