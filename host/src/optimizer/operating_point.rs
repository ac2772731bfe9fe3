//! Choosing a point on the boundary: by weights, by a least accuracy, or by a least throughput.
//!
//! Problem P of the paper: max w_A A + w_R R, either as printed (R in bits per period) or with both divided by their span over
//! the boundary so that weights compare.

use super::region::Point;

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
                format!("largest {w} A + {} R, both over their span on the boundary", 1.0 - w)
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
                let low = points.iter().map(value).fold(f64::INFINITY, f64::min);
                let high = points.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
                (low, (high - low).max(1e-300))
            };
            let (a, r) = (range(|p| p.accuracy), range(|p| p.throughput_bit));
            best(&|p| Some(w * (p.accuracy - a.0) / a.1 + (1.0 - w) * (p.throughput_bit - r.0) / r.1))
        }
        Rule::Weights(a, r) => best(&|p| Some(a * p.accuracy + r * p.throughput_bit)),
        Rule::AccuracyAtLeast(least) => best(&|p| (p.accuracy >= least).then_some(p.throughput_bit)),
        Rule::ThroughputAtLeast(least) => best(&|p| (p.throughput_bit >= least).then_some(p.accuracy)),
    }
}
