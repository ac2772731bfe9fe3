//! Thousands of periods of the core's scheduler with fading channels, traffic, users that join and leave, lost
//! slots, other targets, and people in front of the radar.
//!
//! Every slot's decision is the core's. The scheduler's properties are checked in every period; violations are counted
//! and described.

mod environment;
mod invariants;
pub(crate) mod plain;
pub(crate) mod radar;
mod simulate;
mod trace;

pub use simulate::{Exits, simulate};

use crate::error::Invalid;
use crate::optimizer::shares::integer_rates;
use crate::results::{Campaign, CampaignUser, Recognitions, Replans};
use crate::scenario::Scenario;
use crate::scheduling::playback::lengthen;
use environment::Environment;
use invariants::Invariants;
use radar::Radar;
use sdp3_core::scheduler::{PlanError, Scheduler, SensingLayout, SlotUse, USERS};
use std::io::Write;
use trace::Trace;

/// What happens, per period unless it says otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub periods: u32,
    /// N_s at the start.
    pub sensing_slots: u32,
    /// Mean time between changes of a channel, in s.
    pub coherence_s: f64,
    /// Mean arrivals of each user over its fair share of the start; `None`: always something to send.
    pub load: Option<f64>,
    /// Probability that a user joins or leaves.
    pub churn: f64,
    /// Probability that a slot is lost, per slot.
    pub loss: f64,
    /// Probability that N_s becomes another of the scenario's.
    pub retarget: f64,
    /// Periods drawn slot by slot in the trace.
    pub traced: u32,
    /// A recognition every so many periods; 0: never.
    pub recognise_every: u32,
}

impl Settings {
    /// Refuses what is outside its range, by the names of the command line; also the confidence that ends sensing early.
    ///
    /// # Errors
    ///
    /// The first such option.
    pub fn check(&self, scenario: &Scenario, threshold: Option<f64>) -> Result<(), Invalid> {
        let most = scenario.frame.period_slots / (scenario.frame.spacing_slots + 1);
        let traced = trace::SLOTS / scenario.frame.period_slots;
        for (name, value, low, high) in [
            ("--sensing-slots", Some(f64::from(self.sensing_slots)), 0.0, f64::from(most)),
            ("--threshold", threshold, 0.0, 1.0),
            ("--coherence", Some(self.coherence_s), 1e-3, 1e12),
            ("--load", self.load, 0.0, 1e3),
            ("--churn", Some(self.churn), 0.0, 1.0),
            ("--loss", Some(self.loss), 0.0, 1.0),
            ("--retarget", Some(self.retarget), 0.0, 1.0),
            ("--traced", Some(f64::from(self.traced)), 0.0, f64::from(traced)),
        ] {
            if let Some(value) = value.filter(|value| !(low..=high).contains(value)) {
                return Err(Invalid::option(name, value, format!("{low} to {high}")));
            }
        }
        Ok(())
    }
}

/// The scheduler alone, or with the radar's pipeline.
enum Loop<'m, 'b> {
    Schedule(Box<Scheduler>),
    Station(Box<Radar<'m, 'b>>),
}

impl Loop<'_, '_> {
    fn scheduler(&mut self) -> &mut Scheduler {
        match self {
            Loop::Schedule(scheduler) => scheduler,
            Loop::Station(radar) => &mut radar.station.scheduler,
        }
    }

    fn begin(&mut self) -> SlotUse {
        match self {
            Loop::Schedule(scheduler) => scheduler.next_slot(),
            Loop::Station(radar) => radar.station.begin(),
        }
    }

    fn on_lost(&mut self, slot: SlotUse) {
        match self {
            Loop::Schedule(scheduler) => scheduler.on_lost(),
            Loop::Station(radar) => radar.station.on_lost(slot),
        }
    }
}

/// A scheduler at the start of the simulation.
///
/// # Errors
///
/// [`PlanError`] if N_s does not fit.
fn scheduler(
    scenario: &Scenario,
    settings: &Settings,
    environment: &Environment,
) -> Result<Scheduler, PlanError> {
    let f = &scenario.frame;
    let sensing = SensingLayout::new(f.period_slots, f.spacing_slots, settings.sensing_slots)?;
    Ok(Scheduler::new(sensing, rates(environment)))
}

/// The present users' bits per slot in the core's units.
fn rates(environment: &Environment) -> [u32; USERS] {
    let present: Vec<usize> = (0..USERS).filter(|&k| environment.present[k]).collect();
    let bits: Vec<f64> = present.iter().map(|&k| environment.slot_bit[k]).collect();
    let mut rates = [0; USERS];
    present.into_iter().zip(integer_rates(&bits)).for_each(|(k, rate)| rates[k] = rate);
    rates
}

fn play(
    scenario: &Scenario,
    settings: &Settings,
    mut environment: Environment,
    mut slots: Loop,
    trace: &mut Trace<impl Write>,
    progress: &dyn Fn(u64, u64),
) -> Campaign {
    let mut found = Campaign {
        periods: settings.periods,
        decisions: 0,
        sensing_slots: 0,
        idle_slots: 0,
        users: vec![CampaignUser::default(); USERS],
        replans: Replans::default(),
        recognitions: None,
        timeline: Vec::new(),
        violations: Vec::new(),
        channels: scenario.communication.channels().to_owned(),
    };
    let mut recognitions = Recognitions::default();
    let mut invariants = Invariants::new();
    let mut until_loss = environment.slots_until_loss(settings.loss);
    for period in 0..settings.periods {
        environment.arrive(settings);
        let person = settings.recognise_every > 0 && period % settings.recognise_every == 0;
        if let Loop::Station(radar) = &mut slots {
            radar.prepare(person, period);
        }
        let traced = period < settings.traced;
        invariants.begin();
        let mut served = [0_u32; USERS];
        let (mut sensed, mut idle, mut position) = (0_u32, 0_u32, 0_u32);
        let mut ended = false;
        loop {
            let slot = slots.begin();
            position += 1;
            if position == 1 {
                let scheduler = slots.scheduler();
                invariants.plan(scheduler.plan());
                count(&mut found.replans, scheduler.report());
                trace.boundary(period, scheduler.report(), scheduler.plan());
            }
            let lost = until_loss == 0;
            until_loss = if lost { environment.slots_until_loss(settings.loss) } else { until_loss - 1 };
            match slot {
                SlotUse::Communication(k) => {
                    let k = usize::from(k) % USERS;
                    served[k] += 1;
                    invariants.serve(k, position);
                    if !lost {
                        environment.deliver(k);
                    }
                }
                SlotUse::Sensing => {
                    sensed += 1;
                    invariants.sense(position);
                    if let Loop::Station(radar) = &mut slots
                        && !lost
                    {
                        let before = radar.station.scheduler.sensing_left();
                        radar.sense(&mut recognitions);
                        ended |= radar.station.scheduler.sensing_left() != before;
                    }
                }
                SlotUse::Idle => idle += 1,
            }
            if period == 0 {
                lengthen(&mut found.timeline, slot);
            }
            if traced {
                trace.slot(period, position, slot, lost);
            }
            if lost {
                let before = slots.scheduler().sensing_left();
                slots.on_lost(slot);
                ended |= slots.scheduler().sensing_left() != before;
            }
            if slots.scheduler().position() == 0 {
                break;
            }
        }
        if let Loop::Station(radar) = &mut slots {
            radar.finish(&mut recognitions);
        }
        let planned = slots.scheduler().plan().clone();
        invariants.end(period, &planned, (&served, sensed, idle), ended, &mut found.violations);
        found.decisions += u64::from(position);
        found.sensing_slots += u64::from(sensed);
        found.idle_slots += u64::from(idle);
        for (k, r) in found.users.iter_mut().enumerate() {
            r.slots += u64::from(served[k]);
            r.periods += u64::from(environment.present[k]);
        }
        trace.period(period, &environment.drain(&mut found.users));
        if period % 64 == 0 {
            progress(u64::from(period), u64::from(settings.periods));
        }
        let changed = environment.change(settings, scenario);
        let scheduler = slots.scheduler();
        if changed.rates {
            rates(&environment)
                .into_iter()
                .enumerate()
                .for_each(|(k, rate)| scheduler.planner_mut().set_rate(k, rate));
        }
        if let Some(n) = changed.sensing_slots {
            // one of the scenario's: it fits
            let _ = scheduler.planner_mut().set_sensing_slots(n);
        }
    }
    for (r, (wait, bound)) in found.users.iter_mut().zip(invariants.waits()) {
        (r.longest_wait_slots, r.wait_bound_slots) = (wait, bound);
    }
    found.recognitions = (recognitions.count > 0).then_some(recognitions);
    found
}

fn count(replans: &mut Replans, boundary: sdp3_core::scheduler::PeriodReport) {
    let c = boundary.changes;
    replans.boundaries += 1;
    replans.replanned += u64::from(boundary.replanned);
    replans.joined += u64::from(c.joined.count_ones());
    replans.left += u64::from(c.left.count_ones());
    replans.rates += u64::from(c.rates.count_ones());
    replans.retargeted += u64::from(c.sensing);
    replans.lost_slots += u64::from(c.lost);
    replans.lost_sensing_slots += u64::from(c.sensing_lost);
    replans.released_slots += u64::from(c.released);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything at once, as in the long form of `tests/scheduler`.
    fn settings(periods: u32) -> Settings {
        Settings {
            periods,
            sensing_slots: 309,
            coherence_s: 3.0,
            load: Some(0.8),
            churn: 0.05,
            loss: 0.001,
            retarget: 0.05,
            traced: 2,
            recognise_every: 0,
        }
    }

    fn campaign(settings: &Settings, seed: u64) -> (Campaign, String) {
        // without a largest modulation, at which rates do not change
        let mut scenario = crate::scenario::builtin::named("as-printed".as_ref()).unwrap().scenario();
        scenario.communication.draws = 20;
        let environment = Environment::new(&scenario, settings, seed);
        let scheduler = scheduler(&scenario, settings, &environment).unwrap();
        let mut text = Vec::new();
        let mut trace = Trace::new(&mut text, &scenario.frame);
        let slots = Loop::Schedule(Box::new(scheduler));
        let found = play(&scenario, settings, environment, slots, &mut trace, &|_, _| ());
        trace.finish().unwrap();
        (found, String::from_utf8(text).unwrap())
    }

    #[test]
    fn properties_hold_and_everything_happens() {
        let (found, trace) = campaign(&settings(400), 1);
        assert!(found.violations.is_empty(), "{:?}", found.violations);
        assert_eq!(found.decisions, 400 * 4000);
        let r = &found.replans;
        assert!(
            r.joined > 20 && r.left > 10 && r.rates > 50 && r.retargeted > 5 && r.lost_slots > 500,
            "{r:?}"
        );
        for user in found.users.iter().filter(|r| r.slots > 0) {
            assert!(user.longest_wait_slots <= user.wait_bound_slots, "{user:?}");
            assert!(user.delivered_bit > 0.0 && user.delivered_bit <= user.offered_bit * 1.0001);
        }
        let events: serde_json::Value = serde_json::from_str(&trace).unwrap();
        assert!(events["traceEvents"].as_array().unwrap().len() > 4000);
        assert_eq!((found, trace), campaign(&settings(400), 1));
    }

    #[test]
    fn a_quiet_world_keeps_its_first_plan() {
        let quiet =
            Settings { coherence_s: 1e12, load: None, churn: 0.0, loss: 0.0, retarget: 0.0, ..settings(20) };
        let (found, _) = campaign(&quiet, 3);
        assert!(found.violations.is_empty(), "{:?}", found.violations);
        assert_eq!((found.replans.replanned, found.idle_slots), (1, 0));
        assert_eq!(found.sensing_slots, 20 * 309);
    }
}
