//! One period of a plan as the core's scheduler plays it.

use super::campaign::radar::Station;
use crate::network::memory::OwnedMemory;
use crate::optimizer::OptimizerError;
use crate::optimizer::shares::integer_rates;
use crate::results::{OperatingPoint, Recognised, RegionPoint, Schedule, SlotPlan};
use crate::scenario::{Class, Scenario};
use crate::simulator::dataset::{Set, recording};
use sdp3_core::dsn::Model;
use sdp3_core::early_exit::EarlyExit;
use sdp3_core::scheduler::{Plan, Scheduler, SensingLayout, Sequencer, SlotUse, USERS};

/// Slots and columns of a [`SlotPlan`].
const FIRST: usize = 80;
const COLUMNS: usize = 50;

/// Appends a slot to a run-length coded period.
pub fn lengthen(timeline: &mut Vec<(i32, u32)>, slot: SlotUse) {
    let code = match slot {
        SlotUse::Communication(k) => i32::from(k),
        SlotUse::Sensing => -1,
        SlotUse::Idle => -2,
    };
    match timeline.last_mut() {
        Some((last, slots)) if *last == code => *slots += 1,
        _ => timeline.push((code, 1)),
    }
}

/// Plays an operating point for one period.
///
/// # Errors
///
/// [`OptimizerError::Plan`] if the numbers are not a plan.
pub fn play(point: &OperatingPoint) -> Result<Schedule, OptimizerError> {
    let plan =
        Plan::new(point.period_slots, point.spacing_slots, point.sensing_slots, &point.communication_slots)
            .map_err(OptimizerError::Plan)?;
    let mut sequencer = Sequencer::new(&plan);
    let users = point.communication_slots.len();
    let mut schedule = Schedule {
        period_slots: plan.period(),
        sensing_slots: 0,
        communication_slots: vec![0; users],
        longest_wait_slots: vec![0; users],
        delivered_bit: vec![0.0; users],
        timeline: Vec::new(),
        recognised: None,
        channels: point.channels.clone(),
    };
    let mut waits = vec![0; users];
    for _ in 0..plan.period() {
        waits.iter_mut().for_each(|wait| *wait += 1);
        let slot = sequencer.next_slot();
        match slot {
            SlotUse::Communication(k) => {
                let k = usize::from(k);
                schedule.communication_slots[k] += 1;
                schedule.delivered_bit[k] += point.slot_bit.get(k).copied().unwrap_or(0.0);
                schedule.longest_wait_slots[k] = schedule.longest_wait_slots[k].max(waits[k] - 1);
                waits[k] = 0;
            }
            SlotUse::Sensing => schedule.sensing_slots += 1,
            SlotUse::Idle => (),
        }
        lengthen(&mut schedule.timeline, slot);
    }
    for (longest, wait) in schedule.longest_wait_slots.iter_mut().zip(waits) {
        *longest = (*longest).max(wait);
    }
    Ok(schedule)
}

/// The core's station on an adult walking, with the largest model that fits the point's sensing slots.
pub fn recognise(
    scenario: &Scenario,
    seed: u64,
    point: &OperatingPoint,
    rho: f64,
    models: &[Vec<u8>],
) -> Option<Recognised> {
    let parsed = models.iter().filter_map(|bytes| Model::parse(bytes).ok());
    let model = parsed
        .filter(|m| m.sensing_slots() <= point.sensing_slots as usize)
        .max_by_key(Model::sensing_slots)?;
    let class = Class::AdultWalking;
    let slots = recording(scenario, rho, seed, Set::Demo, class, 1, point.sensing_slots).slots;
    let mut memory = OwnedMemory::for_model(&model);
    let pipeline = memory.early_exits(vec![EarlyExit::single(model)], 2.0).ok()?;
    let sensing = SensingLayout::new(point.period_slots, point.spacing_slots, point.sensing_slots).ok()?;
    let mut rates = [0; USERS];
    rates.iter_mut().zip(integer_rates(&point.slot_bit)).for_each(|(rate, own)| *rate = own);
    let mut station = Station::new(Scheduler::new(sensing, rates), pipeline);
    let mut signal = slots.iter();
    let mut found = None;
    for _ in 0..point.period_slots {
        if station.begin() == SlotUse::Sensing {
            found = station.on_samples(signal.next()?).or(found);
        }
    }
    let found = found?;
    Some(Recognised {
        truth: class.name().to_owned(),
        class: model.class_name(usize::from(found.class)).to_owned(),
        confidence: f64::from(found.confidence),
    })
}

/// One period of a boundary's point; N and N_m are those of `like`.
///
/// # Errors
///
/// [`OptimizerError::Plan`] if the numbers are not a plan.
pub fn plan(point: &RegionPoint, like: &OperatingPoint) -> Result<SlotPlan, OptimizerError> {
    let played = play(&OperatingPoint {
        case: point.case,
        sensing_slots: point.sensing_slots,
        communication_slots: point.communication_slots.clone(),
        ..like.clone()
    })?;
    let slots: Vec<i32> =
        played.timeline.iter().flat_map(|&(code, n)| std::iter::repeat_n(code, n as usize)).collect();
    let uses = 0..=point.communication_slots.len() as i32;
    let count = |own: &[i32]| {
        uses.clone().map(|code| own.iter().filter(|&&slot| slot == code - 1).count() as u32).collect()
    };
    let edge = |column: usize| column * slots.len() / COLUMNS;
    Ok(SlotPlan {
        case: point.case,
        sensing_slots: point.sensing_slots,
        longest_wait_slots: played.longest_wait_slots,
        first: slots[..slots.len().min(FIRST)].to_vec(),
        columns: (0..COLUMNS).map(|column| count(&slots[edge(column)..edge(column + 1)])).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimizer::{Outcome, Rule, optimise};
    use crate::results::{Curve, Parameters};

    fn outcome(rule: Rule) -> Result<Outcome, OptimizerError> {
        let parameters = Parameters { alpha: 61906.0, beta: 2.4297, gamma: Some(0.9499), epsilon: None };
        let curve = Curve { model: "pow3".into(), parameters, rmse: 0.0 };
        optimise(&curve, &[], &[], &Scenario::default(), rule, 1)
    }

    #[test]
    fn the_scheduler_plays_the_point_exactly() {
        let point = outcome(Rule::AccuracyAtLeast(0.93)).unwrap().operating_point;
        assert!(point.accuracy >= 0.93);
        let played = play(&point).unwrap();
        assert_eq!(played.communication_slots, point.communication_slots);
        assert_eq!(played.sensing_slots, point.sensing_slots);
        let found = outcome(Rule::Weighted(0.5)).unwrap();
        for weighted in &found.weighted {
            let own = |p: &&RegionPoint| (p.case, p.sensing_slots) == (weighted.case, weighted.sensing_slots);
            let shown = found.region.iter().find(own).unwrap();
            let plan = plan(shown, &found.operating_point).unwrap();
            let slots = |uses: usize| plan.columns.iter().map(|column| column[uses]).sum::<u32>();
            assert_eq!(slots(0), shown.sensing_slots);
            let shares: Vec<u32> = (1..=shown.communication_slots.len()).map(slots).collect();
            assert_eq!(shares, shown.communication_slots);
        }
        let worst = played.delivered_bit.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((worst / point.throughput_bit - 1.0).abs() < 1e-9);
        assert!(outcome(Rule::AccuracyAtLeast(0.99)).is_err());
    }
}
