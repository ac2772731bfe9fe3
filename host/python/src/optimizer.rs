//! `fit`, `optimize`.

use crate::{object, parsed, refused};
use pyo3::prelude::*;
use sdp3::optimizer::{Rule, optimise};
use sdp3::predictor::bootstrap::replicates;
use sdp3::predictor::{best_curve, fit_all, predict};
use sdp3::results::CurvePoint;

/// (sensing slots, accuracy[, tested]).
fn points(rows: &[Vec<f64>]) -> PyResult<Vec<CurvePoint>> {
    let point = |(n, row): (usize, &Vec<f64>)| match row[..] {
        [sensing_slots, accuracy] => Ok(CurvePoint { sensing_slots, accuracy, tested: None, std: None }),
        [sensing_slots, accuracy, tested] => {
            Ok(CurvePoint { sensing_slots, accuracy, tested: Some(tested), std: None })
        }
        _ => Err(refused(
            sdp3::error::Invalid::new("numbers", row.len(), "2 or 3").at(format!("point {}", n + 1)),
        )),
    };
    rows.iter().enumerate().map(point).collect()
}

/// The seven learning curves.
#[pyfunction]
#[pyo3(signature = (points, *, seed = 1))]
pub fn fit<'py>(py: Python<'py>, points: Vec<Vec<f64>>, seed: u64) -> PyResult<Bound<'py, PyAny>> {
    let points = self::points(&points)?;
    let found = py.detach(|| predict(&points, seed));
    object(py, &found.map_err(refused)?)
}

fn rule(accuracy: Option<f64>, throughput: Option<f64>, weight: Option<f64>, default: f64) -> PyResult<Rule> {
    let share = |name: &str, value: f64| match (0.0..=1.0).contains(&value) {
        true => Ok(value),
        false => Err(refused(sdp3::error::Invalid::new(name, value, "0 to 1"))),
    };
    match (accuracy, throughput, weight) {
        (Some(accuracy), None, None) => Ok(Rule::AccuracyAtLeast(share("accuracy", accuracy)?)),
        (None, Some(bits), None) if bits.is_finite() && bits >= 0.0 => Ok(Rule::ThroughputAtLeast(bits)),
        (None, Some(bits), None) => {
            Err(refused(sdp3::error::Invalid::new("throughput", bits, "a number of at least 0")))
        }
        (None, None, weight) => Ok(Rule::Weighted(share("weight", weight.unwrap_or(default))?)),
        _ => Err(refused("accuracy, throughput and weight: at most one of them")),
    }
}

/// Region, zones, operating point.
#[pyfunction]
#[pyo3(signature = (points, scenario = "", *, accuracy = None, throughput = None, weight = None, seed = 1))]
pub fn optimize<'py>(
    py: Python<'py>,
    points: Vec<Vec<f64>>,
    scenario: &str,
    accuracy: Option<f64>,
    throughput: Option<f64>,
    weight: Option<f64>,
    seed: u64,
) -> PyResult<Bound<'py, PyAny>> {
    let scenario = parsed(scenario)?;
    let points = self::points(&points)?;
    let rule = rule(accuracy, throughput, weight, scenario.optimizer.accuracy_weight)?;
    let found = py.detach(|| {
        let curve = best_curve(&fit_all(&points).map_err(|e| e.to_string())?);
        let outcome = optimise(&curve, &points, &replicates(&curve, &points, seed), &scenario, rule, seed);
        outcome.map(|outcome| (curve, outcome)).map_err(|e| e.to_string())
    });
    let (curve, outcome) = found.map_err(refused)?;
    let value = serde_json::json!({
        "curve": curve, "region": outcome.region, "operating_point": outcome.operating_point,
        "weighted": outcome.weighted, "cases": outcome.cases,
        "zone_ratio": scenario.optimizer.zone_ratio,
    });
    object(py, &value)
}
