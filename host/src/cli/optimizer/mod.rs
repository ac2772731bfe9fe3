//! Commands of the optimizer: `predict`, `optimize`, `early-exits`, `schedule`.

mod schedule;

use super::context::{Context, count, one_of};
use crate::error::{Failure, Invalid};
use crate::optimizer::Rule;
use crate::optimizer::sweep::{Sweep, check};
use crate::predictor::Model;
use crate::report::{early_exits, tables};
use crate::results::{Link, Optimum};
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
    /// CSV or JSON with sensing_slots, accuracy[, tested][, std], or results of this tool; absent: the accuracies of --out's run. Of
    /// points with several N_m in spacing_slots, the best N_m is chosen.
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// Test --out's int8 models again on test recordings of the scenario with what --set changes, such as channel.rho, and take those
    /// accuracies. Nothing is trained.
    #[arg(long, conflicts_with = "points")]
    pub retest: bool,
    /// Learning curve; absent: the best one.
    #[arg(long, value_name = "NAME", value_parser = one_of(&Model::ALL, Model::name))]
    pub curve: Option<Model>,
    #[command(flatten)]
    pub rule: RuleArgs,
    /// Vary carrier_hz, power_w, users (their number) or distance (a factor): AXIS=VALUE,VALUE,... May be given several times.
    #[arg(long, value_name = "AXIS=VALUES")]
    pub sweep: Vec<Sweep>,
}

/// Early exits to fit.
#[derive(Debug, Clone, Args)]
pub struct EarlyExitsArgs {
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
    #[arg(long, allow_negative_numbers = true)]
    pub accuracy: Option<f64>,
    /// Throughput of at least this, in bits per period.
    #[arg(long, allow_negative_numbers = true)]
    pub throughput: Option<f64>,
    /// Weight of accuracy, 0 to 1; throughput has the rest, both over their span on the boundary.
    #[arg(long, allow_negative_numbers = true)]
    pub weight: Option<f64>,
    /// w_A and w_R of the paper's sum w_A A + w_R R, R in bits per period.
    #[arg(long, value_name = "WA,WR", value_parser = pair, allow_hyphen_values = true)]
    pub weights: Option<(f64, f64)>,
}

fn pair(text: &str) -> Result<(f64, f64), String> {
    let numbers = text.split_once(',').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    numbers.ok_or_else(|| "two numbers with a comma between them".into())
}

/// The rule that is stated, if one is.
fn rule(args: &RuleArgs) -> Result<Option<Rule>, Failure> {
    let share = |name: &str, value: f64| match (0.0..=1.0).contains(&value) {
        true => Ok(value),
        false => Err(Invalid::option(name, value, "0 to 1")),
    };
    let positive = |name: &str, value: f64| match value.is_finite() && value >= 0.0 {
        true => Ok(value),
        false => Err(Invalid::option(name, value, "a number of at least 0")),
    };
    Ok(match *args {
        RuleArgs { accuracy: Some(a), .. } => Some(Rule::AccuracyAtLeast(share("--accuracy", a)?)),
        RuleArgs { throughput: Some(r), .. } => Some(Rule::ThroughputAtLeast(positive("--throughput", r)?)),
        RuleArgs { weights: Some((a, r)), .. } => {
            let (a, r) = (positive("--weights (WA)", a)?, positive("--weights (WR)", r)?);
            if a + r == 0.0 {
                return Err(
                    Invalid::option("--weights", "0,0", "two numbers, at least one of them above 0").into()
                );
            }
            Some(Rule::Weights(a, r))
        }
        RuleArgs { weight: Some(weight), .. } => Some(Rule::Weighted(share("--weight", weight)?)),
        _ => None,
    })
}

pub fn predict(context: &Context, args: &PredictArgs) -> Result<bool, Failure> {
    let prediction = context.job()?.prediction(args.points.as_deref())?;
    context.print(&prediction, || tables::prediction(&prediction))?;
    Ok(true)
}

pub fn optimize(context: &Context, args: &OptimizeArgs) -> Result<bool, Failure> {
    let rule = rule(&args.rule)?;
    check(&args.sweep)?;
    let job = context.job()?;
    let (job, retested) = match args.retest {
        true => job.retest().map(|(job, found)| (job, Some(found)))?,
        false => (job, None),
    };
    let (job, measured) = job.learning_curves(retested.as_ref(), args.points.as_deref(), args.curve)?;
    if args.sweep.is_empty() {
        let found = job.optimum(measured, rule, retested)?;
        context.print(&found, || words(&found))?;
    } else {
        let period_s = job.scenario.period_s();
        let rows = job.vary_links(&measured, rule, &args.sweep)?;
        context.print(&rows, || tables::sweep(&rows, period_s, b'\t').trim_end().to_owned())?;
    }
    Ok(true)
}

pub fn early_exits(context: &Context, args: &EarlyExitsArgs) -> Result<bool, Failure> {
    let (found, period_s) = context.job()?.early_exits(args.calibrate_per_class, rule(&args.rule)?)?;
    context.print(&found, || early_exits::table(&found, period_s))?;
    Ok(true)
}

fn words(found: &Optimum) -> String {
    let Optimum { curve, zone_ratio: ratio, operating_point: p, .. } = found;
    let mut text = format!("{} by {}, rmse {:.4}\n", p.rule, curve.model, curve.rmse);
    if let Some(retested) = &found.retested {
        let each = retested.accuracy.iter().map(|a| format!("{} {:.4}", a.sensing_slots, a.int8));
        let (rho, tested, each) = (retested.rho, retested.tested(), each.collect::<Vec<_>>().join(", "));
        let _ = writeln!(
            text,
            "accuracy at rho = {rho} on {tested} recordings, by networks as they were trained: N_s {each}"
        );
    }
    text += &of_spacings(found);
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
                    "case {}: N_s = {}, N_c = {:?}, accuracy {:.4}{}, {:.0} bit per period ({:.3} Mbit/s), {}{}",
                    p.case,
                    p.sensing_slots,
                    p.communication_slots,
                    p.accuracy,
                    band.unwrap_or_default(),
                    p.throughput_bit,
                    p.throughput_bit / p.period_s / 1e6,
                    p.zone.name(),
                    beyond(p.extrapolated)
                );
            }
        }
        if !case.links.is_empty() {
            let _ = writeln!(text, "  {}", links(&case.links));
        }
        for b in &case.borders {
            let _ =
                writeln!(text, "  {} from N_s = {}{}", b.to.name(), b.sensing_slots, beyond(b.extrapolated));
        }
    }
    let _ = write!(
        text,
        "zones: |dA / dR|, both over their span, above {:.3}, between, below {ratio}; every N_s in boundary.csv",
        1.0 / ratio
    );
    text += "\n";
    text += &p.channels;
    text
}

/// The operating point at every N_m, a line each.
fn of_spacings(found: &Optimum) -> String {
    let Optimum { operating_point: p, .. } = found;
    let mut text = String::new();
    for row in &found.spacings {
        let mark = if row.spacing_slots == p.spacing_slots { "*" } else { " " };
        let _ = write!(text, "{mark} N_m = {}: ", row.spacing_slots);
        let _ = match (row.sensing_slots, row.accuracy, row.throughput_bit, row.observation_s) {
            (Some(slots), Some(accuracy), Some(bit), Some(seconds)) => writeln!(
                text,
                "N_s = {slots} in {seconds:.3} s, accuracy {accuracy:.4}, {bit:.0} bit per period ({:.3} Mbit/s) by {}{}",
                bit / p.period_s / 1e6,
                row.curve.model,
                beyond(row.extrapolated)
            ),
            _ => writeln!(text, "no point"),
        };
    }
    text
}

/// What is said of an N_s at which the curve is extrapolated.
fn beyond(extrapolated: bool) -> &'static str {
    if extrapolated { ", extrapolated: no accuracy was measured there" } else { "" }
}

/// What the users' slots are made of, in a line.
fn links(links: &[Link]) -> String {
    let subcarriers = links.first().map_or(0, |link| link.subcarriers);
    let bits: Vec<_> = links.iter().map(|link| format!("{:.2}", link.subcarrier_bit)).collect();
    let full: Vec<_> =
        links.iter().filter_map(|link| Some(format!("{:.0} %", 100.0 * link.full_share?))).collect();
    let limit = match full.is_empty() {
        true => "no largest modulation".to_owned(),
        false => format!("{} of them at the modulation's limit", full.join(", ")),
    };
    format!("{subcarriers} sub-carriers with {} bit a symbol, {limit}", bits.join(", "))
}
