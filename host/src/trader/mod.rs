//! Commands that trade: `predict`, `optimize`, `anytime`, `schedule`.

mod schedule;

use crate::cli::RuleArgs;
use crate::{RUN_FIRST, model_name, print, resolved};
use sdp3::formats::points;
use sdp3::optimizer::sweep::{self, Sweep};
use sdp3::optimizer::{Outcome, Rule};
use sdp3::pipeline::{Failure, Job};
use sdp3::predictor::learning_curve::{best_curve, fit_all, predict};
use sdp3::report;
use sdp3::results::{Curve, CurvePoint, Run, SweepRow};
use sdp3::scenario::Scenario;
use sdp3::simulator::calibration::stored_rho;
use std::fmt::Write;
use std::path::{Path, PathBuf};

pub use schedule::schedule;

/// The accuracies of `--out`'s run.
pub fn stored_points(job: &Job) -> Result<Vec<CurvePoint>, Failure> {
    let run: Run = job.output.read_json("run.json", RUN_FIRST)?;
    let point = |a: &sdp3::results::Accuracy| CurvePoint {
        sensing_slots: f64::from(a.sensing_slots),
        accuracy: a.int8,
        tested: Some(f64::from(a.tested)),
    };
    Ok(run.accuracy.iter().map(point).collect())
}

pub fn predict_file(file: &Path, seed: u64, json: bool) -> Result<bool, Failure> {
    let prediction = predict(&points::read(file)?, seed).map_err(|e| format!("{}: {e}", file.display()))?;
    print(json, &prediction, || report::tables::prediction(&prediction));
    Ok(true)
}

/// The rule that the command line or else the scenario states.
pub fn rule(args: &RuleArgs, scenario: &Scenario) -> Result<Rule, Failure> {
    let share = |name: &str, value: f64| match (0.0..=1.0).contains(&value) {
        true => Ok(value),
        false => Err(format!("command line: {name} = {value} is outside its legal range: 0..=1")),
    };
    let positive = |name: &str, value: f64| match value.is_finite() && value >= 0.0 {
        true => Ok(value),
        false => {
            Err(format!("command line: {name} = {value} is outside its legal range: a number of at least 0"))
        }
    };
    if let Some(a) = args.accuracy {
        return Ok(Rule::AccuracyAtLeast(share("--accuracy", a)?));
    }
    if let Some(r) = args.throughput {
        return Ok(Rule::ThroughputAtLeast(positive("--throughput", r)?));
    }
    if let Some((a, r)) = args.weights {
        return Ok(Rule::Weights(positive("--weights (WA)", a)?, positive("--weights (WR)", r)?));
    }
    Ok(Rule::Weighted(share("--weight", args.weight.unwrap_or(scenario.trade.accuracy_weight))?))
}

/// What `optimize` is asked.
pub struct Question {
    /// File of points, or those of the run.
    pub points: Option<PathBuf>,
    /// Name of the curve, or the best.
    pub curve: Option<String>,
    /// How the point is chosen.
    pub rule: Rule,
    /// What is varied.
    pub sweep: Vec<Sweep>,
}

pub fn optimize(job: &Job, ask: Question, json: bool) -> Result<bool, Failure> {
    let (points, origin) = match &ask.points {
        Some(file) => (points::read(file)?, format!("{}: ", file.display())),
        None => (stored_points(job)?, String::new()),
    };
    let prediction = fit_all(&points).map_err(|e| format!("{origin}{e}"))?;
    let curve = match &ask.curve {
        None => best_curve(&prediction),
        Some(name) => {
            let found = prediction.models.iter().find(|m| m.name == *name);
            let m = found.ok_or_else(|| {
                let names: Vec<&str> = prediction.models.iter().map(|m| m.name.as_str()).collect();
                format!("command line: --curve = {name} is outside its legal range: {}", names.join(", "))
            })?;
            Curve { model: m.name.clone(), parameters: m.parameters, rmse: m.rmse }
        }
    };
    if !ask.sweep.is_empty() {
        if job.scenario.communication.slot_bit.is_some() {
            return Err(
                "command line: --sweep varies channels; communication.slot_bit states links without one"
                    .into(),
            );
        }
        let rows = sweep::rows(&job.scenario, &curve, ask.rule, &ask.sweep, job.seed)?;
        job.output.write("sweep.csv", sweep_table(&rows, ",").as_bytes())?;
        print(json, &rows, || sweep_table(&rows, "\t").trim_end().to_owned());
        return Ok(true);
    }
    let outcome = job.trade(&curve, &points, ask.rule)?;
    let value = serde_json::json!({
        "curve": curve, "region": outcome.region, "operating_point": outcome.operating_point,
        "weighted": outcome.weighted, "cases": outcome.cases, "spacings": outcome.spacings,
        "zone_ratio": job.scenario.trade.zone_ratio,
    });
    job.output.write("boundary.csv", outcome.boundary.as_bytes())?;
    job.output.write_json("optimize.json", &value)?;
    print(json, &value, || words(&outcome, &curve, job.scenario.trade.zone_ratio));
    Ok(true)
}

fn sweep_table(rows: &[SweepRow], comma: &str) -> String {
    let head = [
        "carrier_hz",
        "power_w",
        "receivers",
        "distance",
        "case",
        "sensing_slots",
        "accuracy",
        "throughput_bit",
    ];
    let mut text = head.join(comma) + "\n";
    for r in rows {
        let some = |x: Option<f64>| x.map_or_else(String::new, |x| format!("{x}"));
        let cells = [
            r.carrier_hz.to_string(),
            r.power_w.to_string(),
            r.receivers.to_string(),
            r.distance.to_string(),
            r.case.to_string(),
            some(r.sensing_slots.map(f64::from)),
            some(r.accuracy),
            some(r.throughput_bit),
        ];
        text += &(cells.join(comma) + "\n");
    }
    text
}

fn words(outcome: &Outcome, curve: &Curve, ratio: f64) -> String {
    let p = &outcome.operating_point;
    let mut text = format!("{} by {}, rmse {:.4}\n", p.rule, curve.model, curve.rmse);
    for case in &outcome.cases {
        match &case.operating_point {
            None => text += &format!("case {}: no point\n", case.case),
            Some(p) => {
                let band =
                    outcome.region.iter().find(|r| r.case == p.case && r.sensing_slots == p.sensing_slots);
                let band =
                    band.and_then(|r| Some(format!(" ({:.3}..={:.3})", r.accuracy_low?, r.accuracy_high?)));
                let _ = writeln!(
                    text,
                    "case {}: N_s = {}, N_c = {:?}, accuracy {:.4}{}, {:.0} bit per period, {}",
                    p.case,
                    p.sensing_slots,
                    p.communication_slots,
                    p.accuracy,
                    band.unwrap_or_default(),
                    p.throughput_bit,
                    p.zone.name()
                );
            }
        }
        for b in &case.borders {
            let _ = writeln!(text, "  {} from N_s = {}", b.to.name(), b.sensing_slots);
        }
    }
    let _ = write!(
        text,
        "zones: |dA / dR|, both over their span, above {:.3}, between, below {ratio}; every N_s in boundary.csv",
        1.0 / ratio
    );
    text
}

/// The scenario that --out's networks were trained in; one given on the command line goes before it.
pub fn trained(job: &Job, given: bool) -> Result<Scenario, Failure> {
    if given { Ok(job.scenario.clone()) } else { resolved(job) }
}

fn models(job: &Job) -> Result<Vec<Vec<u8>>, Failure> {
    const QUANTIZE_FIRST: &str = "`sdp3 run` or `sdp3 quantize` with the same --out makes it";
    let slots = &job.scenario.frame.sensing_slots;
    slots.iter().map(|n| Ok(job.output.read(&model_name(*n), QUANTIZE_FIRST)?)).collect()
}

fn rho(scenario: &Scenario) -> f64 {
    scenario.channel.rho.unwrap_or_else(|| stored_rho(scenario).0)
}

pub fn anytime(job: &Job, per_class: u32, rule: Rule, json: bool) -> Result<bool, Failure> {
    let found = job.anytime(rho(&job.scenario), &models(job)?, per_class, rule)?;
    job.output.write_json("anytime.json", &found)?;
    job.output.write("anytime.svg", report::anytime::region(&found).as_bytes())?;
    print(json, &found, || report::anytime::table(&found));
    Ok(true)
}
