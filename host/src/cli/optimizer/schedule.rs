//! The command `schedule`: one period of the run's operating point, or many with traffic, churn, fading and loss.

use crate::cli::context::{Context, count};
use crate::error::Failure;
use crate::results::{Campaign, Schedule};
use crate::scheduling::campaign::Settings;
use clap::Args;
use std::fmt::Write;

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
    /// Confidence that ends sensing early, with the weights that `sdp3 early-exits` wrote to --out.
    #[arg(long, value_name = "CONFIDENCE", requires = "recognise_every")]
    pub threshold: Option<f64>,
    /// Periods written slot by slot to trace.json, for Perfetto.
    #[arg(long, value_name = "PERIODS", default_value_t = 3, requires = "periods")]
    pub traced: u32,
}

pub fn schedule(context: &Context, args: &ScheduleArgs) -> Result<bool, Failure> {
    let job = context.job()?;
    let Some(periods) = args.periods else {
        let schedule = job.schedule()?;
        context.print(&schedule, || one_period(&schedule))?;
        return Ok(true);
    };
    let settings = Settings {
        periods,
        sensing_slots: job.sensing_slots_or_operating_point(args.sensing_slots)?,
        coherence_s: args.coherence,
        load: args.load,
        churn: args.churn,
        loss: args.loss,
        retarget: args.retarget,
        traced: args.traced,
        recognise_every: args.recognise_every,
    };
    let (found, period_s) = job.campaign(&settings, args.threshold)?;
    context.print(&found, || campaign_words(&found, period_s))?;
    Ok(found.violations.is_empty())
}

fn one_period(s: &Schedule) -> String {
    format!(
        "N = {}: {} sensing, {:?} communication, longest waits {:?} slots\n{}",
        s.period_slots, s.sensing_slots, s.communication_slots, s.longest_wait_slots, s.channels
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
    for (k, c) in found.users.iter().enumerate().filter(|(_, c)| c.periods > 0) {
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
            n.correct,
            n.count,
            n.unclassified,
            n.slots as f64 / n.count.max(1) as f64
        );
    }
    text += &found.channels;
    text.push('\n');
    match found.violations.first() {
        None => text += "every property held",
        Some(first) => {
            let _ = write!(text, "VIOLATED, {} times or more: {first}", found.violations.len());
        }
    }
    text
}
