//! Commands that trade: `predict`, `optimize`, `anytime`, `schedule`.

use crate::cli::{RuleArgs, WorldArgs};
use crate::{RUN_FIRST, model_name, print, resolved};
use sdp3::formats::points;
use sdp3::optimizer::campaign::{self, Loop, Settings, plain, radar::Radar, trace::Trace, world::World};
use sdp3::optimizer::sweep::{self, Sweep};
use sdp3::optimizer::{Outcome, Rule, playback};
use sdp3::pipeline::{Failure, Job};
use sdp3::predictor::learning_curve::{best_curve, fit_all, predict};
use sdp3::report;
use sdp3::results::{AnytimeResult, Campaign, Curve, CurvePoint, Run, Schedule, SweepRow};
use sdp3::scenario::Scenario;
use sdp3::simulator::calibration::stored_rho;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

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

fn settings(world: &WorldArgs, scenario: &Scenario, sensing_slots: u32) -> Result<Settings, Failure> {
    let within = |name: &str, value: f64, low: f64, high: f64| match (low..=high).contains(&value) {
        true => Ok(value),
        false => Err(format!("command line: {name} = {value} is outside its legal range: {low}..={high}")),
    };
    let most = scenario.frame.period_slots / (scenario.frame.spacing_slots + 1);
    within("--sensing-slots", f64::from(sensing_slots), 0.0, f64::from(most))?;
    if let Some(threshold) = world.threshold {
        within("--threshold", threshold, 0.0, 1.0)?;
    }
    Ok(Settings {
        periods: world.periods.unwrap_or(1),
        sensing_slots,
        coherence_s: within("--coherence", world.coherence, 1e-3, 1e12)?,
        load: world.load.map(|load| within("--load", load, 0.0, 1e3)).transpose()?,
        churn: within("--churn", world.churn, 0.0, 1.0)?,
        loss: within("--loss", world.loss, 0.0, 1.0)?,
        retarget: within("--retarget", world.retarget, 0.0, 1.0)?,
        traced: world.traced,
        recognise_every: world.recognise_every,
    })
}

pub fn schedule(job: &mut Job, args: &WorldArgs, given: bool, json: bool) -> Result<bool, Failure> {
    if args.periods.is_none() {
        let run: Run = job.output.read_json("run.json", RUN_FIRST)?;
        let schedule = playback::play(&run.operating_point)?;
        job.output.write_json("schedule.json", &schedule)?;
        print(json, &schedule, || one_period(&schedule));
        return Ok(true);
    }
    let sensing_slots = match args.sensing_slots {
        Some(slots) => slots,
        None => job.output.read_json::<Run>("run.json", RUN_FIRST)?.operating_point.sensing_slots,
    };
    if args.recognise_every > 0 {
        job.scenario = trained(job, given)?;
    }
    let settings = settings(args, &job.scenario, sensing_slots)?;
    job.output.write("schedule-scenario.toml", job.scenario.to_toml().as_bytes())?;
    let (found, trace) = play(job, args, &settings)?;
    job.output.write("trace.json", trace.as_bytes())?;
    job.output.write_json("campaign.json", &found)?;
    print(json, &found, || campaign_words(&found));
    Ok(found.broken.is_empty())
}

fn play(job: &Job, args: &WorldArgs, settings: &Settings) -> Result<(Campaign, String), Failure> {
    use sdp3::conformance::compare::OwnedBuffers;
    use sdp3_core::anytime::{Anytime, EXITS, Exit};
    use sdp3_core::dsn::{Model, Portable};
    use sdp3_core::station::Station;
    let scenario = &job.scenario;
    let stage = job.progress.stage("schedule", "periods");
    let world = World::new(scenario, settings, job.seed);
    let scheduler = campaign::scheduler(scenario, settings, &world)?;
    let plan = scheduler.plan().clone();
    let mut trace = Trace::new(&scenario.frame);
    let bytes = if settings.recognise_every > 0 { models(job)? } else { Vec::new() };
    let parsed = bytes.iter().map(|b| Model::parse(b)).collect::<Result<Vec<_>, _>>()?;
    let mut buffers = parsed.last().map(OwnedBuffers::for_model);
    let slots = match (&mut buffers, args.threshold) {
        (None, _) => Loop::Schedule(Box::new(scheduler)),
        (Some(buffers), threshold) => {
            let exits: Vec<Exit> = match threshold {
                Some(_) => {
                    let known: AnytimeResult = job
                        .output
                        .read_json("anytime.json", "`sdp3 anytime` with the same --out makes it")?;
                    let weights = |exit: &sdp3::results::AnytimeExit| {
                        let mut all = [0; EXITS];
                        all.iter_mut().zip(&exit.weights).for_each(|(to, from)| *to = *from);
                        all
                    };
                    let exit = |(model, known)| Exit { model, kernels: Portable, weights: weights(known) };
                    parsed.iter().cloned().zip(&known.exits).map(exit).collect()
                }
                None => {
                    let fits = |m: &&Model| m.sensing_slots() <= settings.sensing_slots as usize;
                    let largest = parsed.iter().filter(fits).max_by_key(|m| m.sensing_slots());
                    let largest = largest.ok_or_else(|| {
                        format!(
                            "--sensing-slots = {}: no model of --out is that small",
                            settings.sensing_slots
                        )
                    })?;
                    vec![Exit::alone(largest.clone(), Portable)]
                }
            };
            let receiver = Anytime::new(exits, threshold.unwrap_or(2.0) as f32, buffers.view())?;
            let station = Station::new(scheduler, receiver);
            Loop::Station(Box::new(Radar::new(station, scenario, rho(scenario), job.seed)))
        }
    };
    let begun = Instant::now();
    let found =
        campaign::play(scenario, settings, world, slots, &mut trace, &|done, all| stage.at(done, all));
    let took = begun.elapsed().as_secs_f64();
    stage.finish(&format!("{} decisions, {} promises broken", found.decisions, found.broken.len()));
    if settings.recognise_every == 0 {
        job.progress.note("schedule", &speeds(&plan, &found, took));
    }
    Ok((found, trace.finish()))
}

/// Decisions per second of the campaign, of the core's scheduler alone, and of the plainest loop, one after the other.
fn speeds(plan: &sdp3_core::schedule::Plan, found: &Campaign, took: f64) -> String {
    use sdp3_core::schedule::{Sequencer, SlotUse};
    let periods = (found.decisions / u64::from(plan.period())).clamp(1, 10_000) as u32;
    let count = f64::from(periods) * f64::from(plan.period());
    let mut heard = 0_u64;
    let mut hear = |slot: SlotUse| {
        if let SlotUse::Communication(k) = slot {
            heard = heard.wrapping_mul(31).wrapping_add(u64::from(k));
        }
    };
    let begun = Instant::now();
    let mut sequencer = Sequencer::new(plan);
    (0..periods * plan.period()).for_each(|_| hear(sequencer.next()));
    let core = begun.elapsed().as_secs_f64();
    let begun = Instant::now();
    plain::play(plan, periods, &mut hear);
    let plain = begun.elapsed().as_secs_f64();
    std::hint::black_box(heard);
    let million = |count: f64, s: f64| count / s / 1e6;
    format!(
        "million decisions a second, one core: the whole simulation {:.1}, the scheduler {:.1}, a plain loop {:.1}; the scheduler \
         is {:.2} times the plain loop",
        million(found.decisions as f64, took),
        million(count, core),
        million(count, plain),
        plain / core
    )
}

fn one_period(s: &Schedule) -> String {
    format!(
        "N = {}: {} sensing, {:?} communication, longest waits {:?} slots",
        s.period_slots, s.sensing_slots, s.communication_slots, s.longest_wait_slots
    )
}

fn campaign_words(found: &Campaign) -> String {
    let r = &found.replans;
    let mut text = format!(
        "{} periods, {} decisions: {} sensing, {} idle\n{} new plans: {} joined, {} left, {} rates, {} targets, {} slots lost and \
         {} of sensing, {} given back\n{:<9}{:>9}{:>13}{:>14}{:>14}{:>10}{:>8}\n",
        found.periods,
        found.decisions,
        found.sensing_slots,
        found.idle_slots,
        r.replanned,
        r.joined,
        r.left,
        r.rates,
        r.retargeted,
        r.lost_slots,
        r.lost_sensing_slots,
        r.released_slots,
        "receiver",
        "periods",
        "slots",
        "bit a period",
        "offered",
        "wait",
        "bound"
    );
    for (k, c) in found.receivers.iter().enumerate().filter(|(_, c)| c.periods > 0) {
        let per_period = |bits: f64| bits / c.periods as f64;
        let _ = writeln!(
            text,
            "{:<9}{:>9}{:>13}{:>14.0}{:>14.0}{:>10}{:>8}",
            k + 1,
            c.periods,
            c.slots,
            per_period(c.delivered_bit),
            per_period(c.offered_bit),
            c.longest_wait_slots,
            c.wait_bound_slots
        );
    }
    if let Some(n) = &found.recognitions {
        let _ = writeln!(
            text,
            "{} of {} people recognised, {} without a verdict, {:.0} sensing slots each",
            n.right,
            n.count,
            n.silent,
            n.slots as f64 / n.count.max(1) as f64
        );
    }
    match found.broken.first() {
        None => text += "every promise held",
        Some(first) => {
            let _ = write!(text, "BROKEN, {} times or more: {first}", found.broken.len());
        }
    }
    text
}
