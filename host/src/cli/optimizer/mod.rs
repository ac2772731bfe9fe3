//! Commands of the optimizer: `predict`, `optimize`, `anytime`, `schedule`.

mod schedule;

use super::context::{Context, count, one_of, stored_models};
use super::{job, simulator};
use crate::error::{Failure, Invalid};
use crate::formats::points;
use crate::optimizer::Rule;
use crate::optimizer::sweep::{self, Sweep};
use crate::pipeline::Job;
use crate::predictor::{Model, best_curve, fit_all, predict as fitted};
use crate::report::{self, figures, plot::Medium};
use crate::results::{Curve, CurvePoint, Optimum, SweepRow};
use crate::scenario::Scenario;
use clap::Args;
use std::fmt::Write;
use std::path::PathBuf;

pub use schedule::{ScheduleArgs, schedule};

/// Accuracies to fit.
#[derive(Debug, Clone, Args)]
pub struct PredictArgs {
    /// CSV or JSON with sensing_slots, accuracy[, tested][, std], or results of this tool; absent: the accuracies of --out's run.
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
}

/// A region to draw and a point to choose.
#[derive(Debug, Clone, Args)]
pub struct OptimizeArgs {
    /// CSV or JSON with sensing_slots, accuracy[, tested][, std], or results of this tool; absent: the accuracies of --out's run.
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// Learning curve; absent: the best one.
    #[arg(long, value_name = "NAME", value_parser = one_of(&Model::ALL, Model::name))]
    pub curve: Option<Model>,
    #[command(flatten)]
    pub rule: RuleArgs,
    /// Vary carrier_hz, power_w, receivers (number of users) or distance (a factor): AXIS=VALUE,VALUE,... May be given several times.
    #[arg(long, value_name = "AXIS=VALUES")]
    pub sweep: Vec<Sweep>,
}

/// Early exits to fit.
#[derive(Debug, Clone, Args)]
pub struct AnytimeArgs {
    /// Recordings of each class to fit and choose on. They follow those trained on.
    #[arg(long, default_value_t = 200, value_parser = count(2..=100_000))]
    pub calibrate_per_class: u32,
    #[command(flatten)]
    pub rule: RuleArgs,
}

/// How the operating point is chosen; absent: the scenario's weight.
#[derive(Debug, Clone, Copy, Args)]
#[group(multiple = false)]
pub struct RuleArgs {
    /// Accuracy of at least this, 0 to 1.
    #[arg(long)]
    pub accuracy: Option<f64>,
    /// Throughput of at least this, in bits per period.
    #[arg(long)]
    pub throughput: Option<f64>,
    /// Weight of accuracy, 0 to 1; throughput has the rest, both over their span on the boundary.
    #[arg(long)]
    pub weight: Option<f64>,
    /// w_A and w_R of the paper's sum w_A A + w_R R, R in bits per period.
    #[arg(long, value_name = "WA,WR", value_parser = pair)]
    pub weights: Option<(f64, f64)>,
}

fn pair(text: &str) -> Result<(f64, f64), String> {
    let numbers = text.split_once(',').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    numbers.ok_or_else(|| "two numbers with a comma between them".into())
}

/// The accuracies of `--out`'s run.
fn stored_points(job: &Job) -> Result<Vec<CurvePoint>, Failure> {
    let run = job::stored(job)?;
    let point = |a: &crate::results::Accuracy| CurvePoint {
        sensing_slots: f64::from(a.sensing_slots),
        accuracy: a.int8,
        tested: Some(f64::from(a.tested)),
        std: None,
    };
    Ok(run.accuracy.iter().map(point).collect())
}

pub fn predict(context: &Context, args: &PredictArgs) -> Result<bool, Failure> {
    let prediction = match &args.points {
        Some(file) => fitted(&points::read(file)?, context.common.seed())
            .map_err(|e| format!("{}: {e}", file.display()))?,
        None => fitted(&stored_points(&context.job()?)?, context.common.seed())?,
    };
    let job = context.job()?;
    job.output.write_json("predict.json", &prediction)?;
    context.draw(&job, "predict", &figures::learning_curve(&prediction, &[]).svg(Medium::SINGLE))?;
    context.print(&prediction, || report::tables::prediction(&prediction))?;
    Ok(true)
}

/// The rule that the command line or else the scenario states.
fn rule(args: &RuleArgs, scenario: &Scenario) -> Result<Rule, Failure> {
    let share = |name: &str, value: f64| match (0.0..=1.0).contains(&value) {
        true => Ok(value),
        false => Err(Invalid::option(name, value, "0 to 1")),
    };
    let positive = |name: &str, value: f64| match value.is_finite() && value >= 0.0 {
        true => Ok(value),
        false => Err(Invalid::option(name, value, "a number of at least 0")),
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

pub fn optimize(context: &Context, ask: OptimizeArgs) -> Result<bool, Failure> {
    let job = &context.job()?;
    let rule = rule(&ask.rule, &job.scenario)?;
    let (points, origin) = match &ask.points {
        Some(file) => (points::read(file)?, format!("{}: ", file.display())),
        None => (stored_points(job)?, String::new()),
    };
    let prediction = fit_all(&points).map_err(|e| format!("{origin}{e}"))?;
    let curve = match &ask.curve {
        None => best_curve(&prediction),
        Some(model) => {
            let found = prediction.models.iter().find(|m| m.name == model.name());
            let m = found.ok_or_else(|| {
                format!("command line: --curve {}: it has no fit through these points", model.name())
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
        let rows = sweep::rows(&job.scenario, &curve, rule, &ask.sweep, job.seed)?;
        let period_s = job.scenario.period_s();
        context.record(job, "optimize")?;
        job.output.write("sweep.csv", sweep_table(&rows, period_s, ",").as_bytes())?;
        context.print(&rows, || sweep_table(&rows, period_s, "\t").trim_end().to_owned())?;
        return Ok(true);
    }
    job.note_room();
    let outcome = job.optimize(&curve, &points, rule)?;
    let value = Optimum {
        curve,
        region: outcome.region,
        operating_point: outcome.operating_point,
        weighted: outcome.weighted,
        cases: outcome.cases,
        spacings: outcome.spacings,
        zone_ratio: job.scenario.trade.zone_ratio,
    };
    context.record(job, "optimize")?;
    job.output.write("boundary.csv", outcome.boundary.as_bytes())?;
    job.output.write_result("optimize.json", &value)?;
    let region = figures::region(&value.region, &value.operating_point, &value.cases, &points);
    context.draw(job, "optimize", &region.svg(Medium::SINGLE))?;
    context.print(&value, || words(&value))?;
    Ok(true)
}

fn sweep_table(rows: &[SweepRow], period_s: f64, comma: &str) -> String {
    let head = [
        "carrier_hz",
        "power_w",
        "receivers",
        "distance",
        "case",
        "sensing_slots",
        "accuracy",
        "throughput_bit",
        "throughput_mbit_s",
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
            some(r.throughput_bit.map(|bit| bit / period_s / 1e6)),
        ];
        text += &(cells.join(comma) + "\n");
    }
    text
}

fn words(found: &Optimum) -> String {
    let Optimum { curve, zone_ratio: ratio, operating_point: p, .. } = found;
    let mut text = format!("{} by {}, rmse {:.4}\n", p.rule, curve.model, curve.rmse);
    for case in &found.cases {
        match &case.operating_point {
            None => text += &format!("case {}: no point\n", case.case),
            Some(p) => {
                let band =
                    found.region.iter().find(|r| r.case == p.case && r.sensing_slots == p.sensing_slots);
                let band =
                    band.and_then(|r| Some(format!(" ({:.3} to {:.3})", r.accuracy_low?, r.accuracy_high?)));
                let _ = writeln!(
                    text,
                    "case {}: N_s = {}, N_c = {:?}, accuracy {:.4}{}, {:.0} bit per period ({:.3} Mbit/s), {}",
                    p.case,
                    p.sensing_slots,
                    p.communication_slots,
                    p.accuracy,
                    band.unwrap_or_default(),
                    p.throughput_bit,
                    p.throughput_bit / p.period_s / 1e6,
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

fn models(job: &Job) -> Result<Vec<Vec<u8>>, Failure> {
    const QUANTIZE_FIRST: &str = "`sdp3 run` or `sdp3 quantize` with the same --out makes it";
    stored_models(job, QUANTIZE_FIRST)
}

pub fn anytime(context: &Context, args: &AnytimeArgs) -> Result<bool, Failure> {
    let mut job = context.job()?;
    job.scenario = context.trained(&job)?;
    let rule = rule(&args.rule, &job.scenario)?;
    let found = job.anytime(simulator::rho(&job.scenario), &models(&job)?, args.calibrate_per_class, rule)?;
    context.record(&job, "anytime")?;
    job.output.write_result("anytime.json", &found)?;
    let period_s = job.scenario.period_s();
    context.draw(&job, "anytime", &report::anytime::region(&found, period_s).svg(Medium::SINGLE))?;
    context.print(&found, || report::anytime::table(&found, period_s))?;
    Ok(true)
}
