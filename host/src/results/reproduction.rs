//! Tables and figures of the paper, made again: its numbers and statements beside those found, and a verdict.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// What was found of a table or figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Every number within its interval, every statement true.
    Reproduced,
    /// Every statement true, but not every number within its interval.
    OrderOnly,
    /// A statement is false.
    NotReproduced,
    /// Nothing here can be compared with what the paper shows.
    NotTestable,
}

impl Display for Verdict {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        f.write_str(match self {
            Verdict::Reproduced => "reproduced",
            Verdict::OrderOnly => "reproduced in order only",
            Verdict::NotReproduced => "not reproduced",
            Verdict::NotTestable => "cannot be tested here",
        })
    }
}

/// A number with its interval of 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Estimate {
    /// Its value.
    pub mean: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// 97.5 % quantiles of Student's t for 1 to 9 degrees of freedom.
const STUDENT: [f64; 9] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262];
/// That of the normal distribution.
const NORMAL: f64 = 1.960;

impl Estimate {
    /// The mean over seeds with Student's interval; of one seed the number alone.
    pub fn of_seeds(values: &[f64]) -> Self {
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0).max(1.0);
        let quantile = match values.len() {
            0 | 1 => 0.0,
            many => STUDENT.get(many - 2).copied().unwrap_or(NORMAL),
        };
        let half = quantile * (variance / n).sqrt();
        Estimate { mean, low: mean - half, high: mean + half }
    }

    /// How far the mean of `own` is from that of `other`, both over seeds that are independent: without its sign, with Welch's interval
    /// at the fewer degrees of freedom. An interval that holds 0 begins there.
    pub fn apart(own: &[f64], other: &[f64]) -> Self {
        let [a, b] = [own, other].map(Estimate::of_seeds);
        let (difference, half) = (a.mean - b.mean, libm::hypot(a.high - a.mean, b.high - b.mean));
        let (near, far) = ((difference.abs() - half).max(0.0), difference.abs() + half);
        Estimate { mean: difference.abs(), low: near, high: far }
    }

    /// A share of `tested` recordings of each seed: Student's interval of several seeds, the binomial one of a single seed.
    pub fn of_shares(values: &[f64], tested: u32) -> Self {
        let Estimate { mean, low, high } = Estimate::of_seeds(values);
        if values.len() > 1 {
            return Estimate { mean, low, high };
        }
        let half = NORMAL * (mean * (1.0 - mean) / f64::from(tested.max(1))).sqrt();
        Estimate { mean, low: mean - half, high: mean + half }
    }
}

/// A number of the paper beside those found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Compared {
    /// What it is of, with its unit.
    pub quantity: String,
    /// The paper's; absent: it states none.
    pub paper: Option<f64>,
    /// Whether a larger number agrees too.
    pub at_least: bool,
    /// What an interval is widened by on either side: the resolution of the method.
    pub tolerance: f64,
    /// With the settings as printed.
    pub as_printed: Option<Estimate>,
    /// With the settings of the scenario.
    pub here: Option<Estimate>,
}

impl Compared {
    /// Whether an estimate agrees with the paper; `None` where one of them is missing.
    fn agrees(&self, found: Option<Estimate>) -> Option<bool> {
        let (paper, found) = (self.paper?, found?);
        let above = found.high + self.tolerance >= paper;
        Some(above && (self.at_least || found.low - self.tolerance <= paper))
    }
}

/// A statement of the paper, and whether it is true.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Statement {
    /// The statement.
    pub text: String,
    /// With the settings as printed; absent: it cannot be tested.
    pub as_printed: Option<bool>,
    /// With the settings of the scenario.
    pub here: Option<bool>,
}

/// A table or figure of the paper, made again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Reproduction {
    /// Its name on the command line.
    pub item: String,
    /// The paper's caption, shortened.
    pub caption: String,
    /// `quick` or `paper`.
    pub size: String,
    /// What the seeds may be used for: `development` or `final`.
    pub seed_set: String,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// The verdict on the settings as printed.
    pub verdict_as_printed: Verdict,
    /// The verdict on those of the scenario.
    pub verdict: Verdict,
    /// Its numbers.
    pub numbers: Vec<Compared>,
    /// Its statements.
    pub statements: Vec<Statement>,
    /// What the reader has to know beside.
    pub notes: Vec<String>,
    /// Names of the figures, without their extension.
    pub figures: Vec<String>,
}

impl Reproduction {
    /// The verdicts that numbers and statements give.
    pub fn judged(mut self) -> Self {
        let verdict = |found: fn(&Compared) -> Option<Estimate>, holds: fn(&Statement) -> Option<bool>| {
            let numbers: Vec<bool> = self.numbers.iter().filter_map(|n| n.agrees(found(n))).collect();
            let statements: Vec<bool> = self.statements.iter().filter_map(holds).collect();
            match (numbers.iter().all(|&agrees| agrees), statements.iter().all(|&holds| holds)) {
                _ if numbers.is_empty() && statements.is_empty() => Verdict::NotTestable,
                (true, true) => Verdict::Reproduced,
                (false, true) if !statements.is_empty() => Verdict::OrderOnly,
                _ => Verdict::NotReproduced,
            }
        };
        let printed = verdict(|n| n.as_printed, |s| s.as_printed);
        let here = verdict(|n| n.here, |s| s.here);
        (self.verdict_as_printed, self.verdict) = (printed, here);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(paper: f64, here: Estimate) -> Compared {
        Compared {
            quantity: "a".into(),
            paper: Some(paper),
            at_least: false,
            tolerance: 0.0,
            as_printed: None,
            here: Some(here),
        }
    }

    fn verdict(numbers: Vec<Compared>, statements: &[bool]) -> Verdict {
        let of = |&holds: &bool| Statement { text: "b".into(), as_printed: None, here: Some(holds) };
        let item = Reproduction {
            item: String::new(),
            caption: String::new(),
            size: String::new(),
            seed_set: String::new(),
            seeds: Vec::new(),
            verdict_as_printed: Verdict::Reproduced,
            verdict: Verdict::Reproduced,
            numbers,
            statements: statements.iter().map(of).collect(),
            notes: Vec::new(),
            figures: Vec::new(),
        }
        .judged();
        assert_eq!(item.verdict_as_printed, Verdict::NotTestable);
        item.verdict
    }

    #[test]
    fn verdicts_follow_from_numbers_and_statements() {
        let found = Estimate { mean: 0.9, low: 0.88, high: 0.92 };
        assert_eq!(verdict(vec![number(0.91, found)], &[true]), Verdict::Reproduced);
        assert_eq!(verdict(vec![number(0.93, found)], &[true]), Verdict::OrderOnly);
        assert_eq!(verdict(vec![number(0.93, found)], &[]), Verdict::NotReproduced);
        assert_eq!(verdict(vec![number(0.91, found)], &[true, false]), Verdict::NotReproduced);
        assert_eq!(verdict(Vec::new(), &[]), Verdict::NotTestable);
        let reached = |paper| vec![Compared { at_least: true, ..number(paper, found) }];
        assert_eq!(verdict(reached(0.7), &[true]), Verdict::Reproduced);
        assert_eq!(verdict(reached(0.93), &[true]), Verdict::OrderOnly);
        let coarse = Compared { tolerance: 0.02, ..number(0.93, found) };
        assert_eq!(verdict(vec![coarse], &[true]), Verdict::Reproduced);
    }

    #[test]
    fn intervals_are_students_and_the_binomial() {
        let five = Estimate::of_seeds(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        // mean 3, standard error sqrt(2.5 / 5), quantile 2.776
        assert!((five.high - 3.0 - 2.776 * 0.5_f64.sqrt()).abs() < 1e-12 && (five.mean - 3.0).abs() < 1e-12);
        let one = Estimate::of_shares(&[0.9], 400);
        assert!((one.high - 0.9 - 1.96 * 0.015).abs() < 1e-12, "{one:?}");
        assert_eq!(Estimate::of_seeds(&[0.5]), Estimate { mean: 0.5, low: 0.5, high: 0.5 });
        // two means, 3 and 5.5: the errors' squares add
        let apart = Estimate::apart(&[1.0, 2.0, 3.0, 4.0, 5.0], &[3.5, 4.5, 5.5, 6.5, 7.5]);
        assert!((apart.mean - 2.5).abs() < 1e-12 && (apart.high - 2.5 - 2.776).abs() < 1e-12, "{apart:?}");
        assert_eq!(apart.low, 0.0);
        // differences of both signs cancel: the mean of their sizes would not
        assert!(Estimate::apart(&[1.0, -1.0], &[0.0, 0.0]).mean.abs() < 1e-12);
    }
}
