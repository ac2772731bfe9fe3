//! Tables II and III: seven curves through the paper's points and through those found here, and their errors.

use super::learning_curve::points;
use super::made::{Made, number, statement};
use super::work::Work;
use crate::error::Failure;
use crate::experiments::carriers::CARRIERS_HZ;
use crate::predictor::{fit_all, paper};
use crate::results::{CurvePoint, Estimate, Prediction};

/// What a printed error may differ by: its last digit.
const PRINTED: f64 = 0.02;

/// The models by their error, the smallest first.
fn order(prediction: &Prediction) -> Vec<String> {
    let mut models: Vec<_> = prediction.models.iter().collect();
    models.sort_by(|a, b| a.sse.total_cmp(&b.sse));
    models.iter().map(|m| m.name.clone()).collect()
}

pub fn make(work: &Work<'_>) -> Result<Made, Failure> {
    let printed = paper::POINTS.map(|(n, accuracy)| CurvePoint {
        sensing_slots: f64::from(n),
        accuracy,
        tested: None,
        std: None,
    });
    let refitted = fit_all(&printed)?;
    let slots = &work.base.frame.sensing_slots;
    let found = work.both(|settings, seed| work.networks(settings, CARRIERS_HZ[0], seed))?;
    let fits = found.map(|seeds| fit_all(&points(slots, &seeds)).ok());
    let mut made =
        Made { caption: "Learning curves and their errors (Tables II and III)", ..Made::default() };
    let error = |prediction: &Prediction, name: &str| {
        let fitted = prediction.models.iter().find(|m| m.name == name)?;
        Some(Estimate { mean: fitted.sse, low: fitted.sse, high: fitted.sse })
    };
    let mut consistent = true;
    for row in &paper::TABLE_III {
        let name = row.model.name();
        let parameters = row.model.parameters(row.parameters);
        let off = |&(n, a): &(u32, f64)| row.model.at(&parameters, f64::from(n)) - a;
        let sse: f64 = paper::POINTS.iter().map(|point| off(point) * off(point)).sum();
        let agrees = (sse / row.sse - 1.0).abs() < PRINTED;
        consistent &= agrees;
        if !agrees {
            made.notes.push(format!(
                "{name}: the printed parameters have the error {sse:.4} on the paper's points, not {}.",
                row.sse
            ));
        }
        if let Some(best) = error(&refitted, name) {
            made.notes.push(format!(
                "{name}: printed error {:.4e}, least error on the same points {:.4e}.",
                row.sse, best.mean
            ));
        }
        let of = |s: usize| fits[s].as_ref().and_then(|prediction| error(prediction, name));
        made.numbers.push(number(
            &format!("{name}: sum of squared errors on the points found"),
            None,
            [of(0), of(1)],
        ));
    }
    let best = |prediction: &Option<Prediction>| {
        let order = order(prediction.as_ref()?);
        Some(order.first().is_some_and(|name| name == "pow3"))
    };
    let three = |prediction: &Option<Prediction>| {
        let order = order(prediction.as_ref()?);
        Some(
            ["pow3", "log_power", "exp4"]
                .iter()
                .all(|name| order[..4.min(order.len())].iter().any(|n| n == name)),
        )
    };
    made.statements = vec![
        statement(
            "the printed parameters have the printed errors on the paper's points",
            [None, Some(consistent)],
        ),
        statement("pow3 has the least error", [best(&fits[0]), best(&fits[1])]),
        statement("pow3, log power and exp4 are among the four best", [three(&fits[0]), three(&fits[1])]),
    ];
    Ok(made)
}
