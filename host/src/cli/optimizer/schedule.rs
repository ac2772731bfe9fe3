//! The command `schedule`: one period of the run's operating point, or many with traffic, churn, fading and loss.

use super::models;
use crate::cli::context::{Context, count};
use crate::cli::job::stored;
use crate::cli::simulator::rho;
use crate::error::{Failure, Invalid};
use crate::network::memory::OwnedMemory;
use crate::pipeline::Job;
use crate::report::timeline;
use crate::results::{AnytimeExit, AnytimeResult, Campaign, Schedule};
use crate::scenario::Scenario;
use crate::scheduling::campaign::{
    self, Loop, Settings,
    environment::Environment,
    plain,
    radar::{Radar, Station},
    trace::Trace,
};
use crate::scheduling::playback;
use clap::Args;
use sdp3_core::dsn::Model;
use sdp3_core::early_exit::{EXITS, EarlyExit};
use sdp3_core::scheduler::{Plan, Sequencer, SlotUse};
use std::fmt::Write;
use std::time::Instant;

/// Conditions for the scheduler. With --periods its properties are checked in every period.
#[derive(Debug, Clone, Args)]
pub struct ScheduleArgs {
    /// Periods; absent: one, in which nothing changes.
    #[arg(long, value_parser = count(1..=10_000_000))]
    pub periods: Option<u32>,
    /// N_s; absent: that of the run's operating point.
    #[arg(long, value_name = "N", requires = "periods")]
    pub sensing_slots: Option<u32>,
    /// Mean time in s between changes of a channel (fading).
    #[arg(long, value_name = "S", default_value_t = 5.0, requires = "periods")]
    pub coherence: f64,
    /// Mean arrivals of a user over its fair share; absent: always something to send.
    #[arg(long, value_name = "SHARE", requires = "periods")]
    pub load: Option<f64>,
    /// Probability that a user joins or leaves in a period.
    #[arg(long, value_name = "P", default_value_t = 0.02, requires = "periods")]
    pub churn: f64,
    /// Probability that a slot is lost.
    #[arg(long, value_name = "P", default_value_t = 0.0005, requires = "periods")]
    pub loss: f64,
    /// Probability that N_s becomes another of the scenario's in a period.
    #[arg(long, value_name = "P", default_value_t = 0.02, requires = "periods")]
    pub retarget: f64,
    /// Run a recognition every N periods (0 disables it): raw I/Q through the core with the models of --out.
    #[arg(long, value_name = "N", default_value_t = 0, requires = "periods")]
    pub recognise_every: u32,
    /// Confidence that ends sensing early, with the weights that `sdp3 anytime` wrote to --out.
    #[arg(long, value_name = "CONFIDENCE", requires = "recognise_every")]
    pub threshold: Option<f64>,
    /// Periods written slot by slot to trace.json, for Perfetto.
    #[arg(long, value_name = "PERIODS", default_value_t = 3, requires = "periods")]
    pub traced: u32,
}

fn settings(args: &ScheduleArgs, scenario: &Scenario, sensing_slots: u32) -> Result<Settings, Failure> {
    let within = |name: &str, value: f64, low: f64, high: f64| match (low..=high).contains(&value) {
        true => Ok(value),
        false => Err(Invalid::option(name, value, format!("{low} to {high}"))),
    };
    let most = scenario.frame.period_slots / (scenario.frame.spacing_slots + 1);
    within("--sensing-slots", f64::from(sensing_slots), 0.0, f64::from(most))?;
    if let Some(threshold) = args.threshold {
        within("--threshold", threshold, 0.0, 1.0)?;
    }
    Ok(Settings {
        periods: args.periods.unwrap_or(1),
        sensing_slots,
        coherence_s: within("--coherence", args.coherence, 1e-3, 1e12)?,
        load: args.load.map(|load| within("--load", load, 0.0, 1e3)).transpose()?,
        churn: within("--churn", args.churn, 0.0, 1.0)?,
        loss: within("--loss", args.loss, 0.0, 1.0)?,
        retarget: within("--retarget", args.retarget, 0.0, 1.0)?,
        traced: args.traced,
        recognise_every: args.recognise_every,
    })
}

pub fn schedule(context: &Context, args: &ScheduleArgs) -> Result<bool, Failure> {
    let mut job = context.job()?;
    if args.periods.is_none() {
        let schedule = playback::play(&stored(&job)?.operating_point)?;
        job.output.write_result("schedule.json", &schedule)?;
        draw(context, &job, &schedule.timeline)?;
        context.print(&schedule, || one_period(&schedule))?;
        return Ok(true);
    }
    let sensing_slots = match args.sensing_slots {
        Some(slots) => slots,
        None => stored(&job)?.operating_point.sensing_slots,
    };
    if args.recognise_every > 0 {
        job.scenario = context.trained(&job)?;
    }
    let settings = settings(args, &job.scenario, sensing_slots)?;
    context.record(&job, "schedule")?;
    let (found, trace) = play(&job, args, &settings)?;
    job.output.write("trace.json", trace.as_bytes())?;
    job.output.write_result("campaign.json", &found)?;
    draw(context, &job, &found.timeline)?;
    context.print(&found, || campaign_words(&found, job.scenario.period_s()))?;
    Ok(found.broken.is_empty())
}

/// The (first) period's slots as a picture.
fn draw(context: &Context, job: &Job, runs: &[(i32, u32)]) -> Result<(), Failure> {
    context.draw(job, "timeline", &timeline::svg(runs, job.scenario.period_s()))
}

fn play(job: &Job, args: &ScheduleArgs, settings: &Settings) -> Result<(Campaign, String), Failure> {
    let scenario = &job.scenario;
    let stage = job.progress.stage("schedule", "periods");
    let environment = Environment::new(scenario, settings, job.seed);
    let scheduler = campaign::scheduler(scenario, settings, &environment)?;
    let plan = scheduler.plan().clone();
    let mut trace = Trace::new(&scenario.frame);
    let bytes = if settings.recognise_every > 0 { models(job)? } else { Vec::new() };
    let parsed = bytes.iter().map(|b| Model::parse(b)).collect::<Result<Vec<_>, _>>()?;
    let mut memory = parsed.last().map(OwnedMemory::for_model);
    let slots = match &mut memory {
        None => Loop::Schedule(Box::new(scheduler)),
        Some(memory) => {
            let exits = match args.threshold {
                Some(_) => fitted(job, &parsed)?,
                None => vec![largest(&parsed, settings.sensing_slots)?],
            };
            let pipeline = memory.early_exits(exits, args.threshold.unwrap_or(2.0) as f32)?;
            let station = Station::new(scheduler, pipeline);
            Loop::Station(Box::new(Radar::new(station, scenario, rho(scenario), job.seed)))
        }
    };
    let begun = Instant::now();
    let found =
        campaign::play(scenario, settings, environment, slots, &mut trace, &|done, all| stage.at(done, all));
    let took = begun.elapsed().as_secs_f64();
    stage.finish(&format!("{} decisions, {} violations", found.decisions, found.broken.len()));
    if settings.recognise_every == 0 {
        job.progress.note("schedule", &speeds(&plan, &found, took));
    }
    Ok((found, trace.finish()))
}

/// Every model as an exit, with the weights that `sdp3 anytime` fitted.
fn fitted<'m>(job: &Job, models: &[Model<'m>]) -> Result<Vec<EarlyExit<'m>>, Failure> {
    let known: AnytimeResult =
        job.output.read_json("anytime.json", "`sdp3 anytime` with the same --out makes it")?;
    let slots: Vec<u32> = known.exits.iter().map(|exit| exit.sensing_slots).collect();
    if slots != job.scenario.frame.sensing_slots {
        let own = &job.scenario.frame.sensing_slots;
        return Err(format!("anytime.json: exits = {slots:?} are not frame.sensing_slots = {own:?}").into());
    }
    let exit = |(model, known): (&Model<'m>, &AnytimeExit)| {
        let mut weights = [0; EXITS];
        weights.iter_mut().zip(&known.weights).for_each(|(to, from)| *to = *from);
        EarlyExit { model: *model, weights }
    };
    Ok(models.iter().zip(&known.exits).map(exit).collect())
}

/// The model of most sensing slots that a period has, as the only exit.
fn largest<'m>(models: &[Model<'m>], sensing_slots: u32) -> Result<EarlyExit<'m>, Failure> {
    let fits = models.iter().filter(|m| m.sensing_slots() <= sensing_slots as usize);
    let model = fits.max_by_key(|m| m.sensing_slots());
    let model = model.ok_or_else(|| {
        let least = models.iter().map(Model::sensing_slots).min().unwrap_or(0);
        let legal = format!("at least {least}, as the smallest model of --out");
        Invalid::option("--sensing-slots", sensing_slots, legal)
    })?;
    Ok(EarlyExit::single(*model))
}

/// Decisions per second of the campaign, of the core's scheduler alone, and of the plainest loop, one after the other.
fn speeds(plan: &Plan, found: &Campaign, took: f64) -> String {
    // the loop that repeats a plan counts its slots in 32 bits
    let most = u64::from(u32::MAX / plan.period()).min(10_000);
    let periods = (found.decisions / u64::from(plan.period())).clamp(1, most) as u32;
    let count = f64::from(periods) * f64::from(plan.period());
    let mut digest = 0_u64;
    let mut count_slot = |slot: SlotUse| {
        if let SlotUse::Communication(k) = slot {
            digest = digest.wrapping_mul(31).wrapping_add(u64::from(k));
        }
    };
    let begun = Instant::now();
    let mut sequencer = Sequencer::new(plan);
    (0..periods * plan.period()).for_each(|_| count_slot(sequencer.next_slot()));
    let core = begun.elapsed().as_secs_f64();
    let begun = Instant::now();
    plain::play(plan, periods, &mut count_slot);
    let plain = begun.elapsed().as_secs_f64();
    std::hint::black_box(digest);
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

fn campaign_words(found: &Campaign, period_s: f64) -> String {
    let r = &found.replans;
    let mut text = format!(
        "{} periods, {} decisions: {} sensing, {} idle\n{} new plans: {} joined, {} left, {} rates, {} targets, {} slots lost and \
         {} of sensing, {} given back\n{:<9}{:>9}{:>13}{:>14}{:>10}{:>14}{:>10}{:>8}\n",
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
        "user",
        "periods",
        "slots",
        "bit a period",
        "Mbit/s",
        "offered",
        "wait",
        "bound"
    );
    for (k, c) in found.receivers.iter().enumerate().filter(|(_, c)| c.periods > 0) {
        let per_period = |bits: f64| bits / c.periods as f64;
        let _ = writeln!(
            text,
            "{:<9}{:>9}{:>13}{:>14.0}{:>10.3}{:>14.0}{:>10}{:>8}",
            k + 1,
            c.periods,
            c.slots,
            per_period(c.delivered_bit),
            per_period(c.delivered_bit) / period_s / 1e6,
            per_period(c.offered_bit),
            c.longest_wait_slots,
            c.wait_bound_slots
        );
    }
    if let Some(n) = &found.recognitions {
        let _ = writeln!(
            text,
            "{} of {} people recognised, {} without a classification, {:.0} sensing slots each",
            n.right,
            n.count,
            n.silent,
            n.slots as f64 / n.count.max(1) as f64
        );
    }
    match found.broken.first() {
        None => text += "every property held",
        Some(first) => {
            let _ = write!(text, "BROKEN, {} times or more: {first}", found.broken.len());
        }
    }
    text
}
