//! The accuracy-throughput region of both placements of the users, with its zones: the paper's last figure.

use super::learning_curve::points;
use super::made::{Made, number, statement};
use super::settings::Settings;
use super::work::Work;
use crate::error::Failure;
use crate::experiments::carriers::CARRIERS_HZ;
use crate::optimizer::{Outcome, Rule, optimise};
use crate::predictor::{best_curve, fit_all};
use crate::report::figures;
use crate::report::plot::Medium;
use crate::results::{Estimate, Zone};

/// A panel of a figure with two columns.
const HALF: Medium = Medium { width: 352.0, height: 236.0, font: 10.5, left: 56.0, bottom: 42.0, mm: 0.0 };

/// Throughput of a case at every N_s shown.
fn throughput(outcome: &Outcome, case: u32) -> Vec<(u32, f64)> {
    let of_case = outcome.region.iter().filter(|p| p.case == case);
    of_case.map(|p| (p.sensing_slots, p.throughput_bit)).collect()
}

pub fn make(work: &Work<'_>) -> Result<Made, Failure> {
    let slots = &work.base.frame.sensing_slots;
    let found = work.both(|settings, seed| work.networks(settings, CARRIERS_HZ[0], seed))?;
    let mut made =
        Made { caption: "Accuracy-throughput region of both cases (Fig. 9)", columns: 2, ..Made::default() };
    let mut outcomes = Vec::new();
    for (settings, seeds) in Settings::BOTH.into_iter().zip(&found) {
        let scenario = work.scenario(settings, CARRIERS_HZ[0]);
        let points = points(slots, seeds);
        let curve = best_curve(&fit_all(&points)?);
        let rule = Rule::Weighted(scenario.optimizer.accuracy_weight);
        let outcome = optimise(&curve, &points, &[], &scenario, rule, work.seeds[0])?;
        let region = figures::region(&outcome.region, &outcome.operating_point, &outcome.cases, &points);
        made.panels.push((settings.words().to_owned(), region.svg(HALF)));
        outcomes.push(outcome);
    }
    let each = |holds: &dyn Fn(&Outcome) -> bool| [0, 1].map(|s| Some(holds(&outcomes[s])));
    let subset = |outcome: &Outcome| {
        let (one, two) = (throughput(outcome, 1), throughput(outcome, 2));
        // A follows from N_s alone: the regions are ordered as their throughputs are
        one.iter().all(|(n, bit)| two.iter().any(|(m, other)| m == n && other > bit))
    };
    let zones = |outcome: &Outcome| {
        [Zone::CommunicationSaturation, Zone::Adversarial, Zone::SensingSaturation]
            .iter()
            .all(|zone| outcome.region.iter().any(|p| p.case == 1 && p.zone == *zone))
    };
    made.statements = vec![
        statement("the region of case 1 is a subset of that of case 2", each(&subset)),
        statement("both have the three zones", each(&zones)),
    ];
    for case in [1, 2] {
        let of = |s: usize| {
            let period_s = outcomes[s].operating_point.period_s;
            let most =
                throughput(&outcomes[s], case).iter().map(|p| p.1).fold(0.0, f64::max) / period_s / 1e6;
            Some(Estimate { mean: most, low: most, high: most })
        };
        made.numbers.push(number(
            &format!("case {case}: largest worst throughput, Mbit/s"),
            None,
            [of(0), of(1)],
        ));
    }
    made.notes.push(
        "Here a sub-carrier carries at most what the largest modulation does: where every user reaches it, both cases are equal. The paper \
         has no such limit."
            .into(),
    );
    Ok(made)
}
