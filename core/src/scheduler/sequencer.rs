//! The use of the next slot, period after period, in integers and O(K) a slot.

use super::layout::USERS;
use super::plan::Plan;
use super::slot_order::SlotOrder;
use crate::supervision::retained::State;

/// What a slot is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SlotUse {
    /// The radar sweeps.
    Sensing,
    /// Downlink to this user.
    Communication(u8),
    /// Nothing is planned (no user has a share).
    Idle,
}

impl State for SlotUse {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        let mut word = match *self {
            SlotUse::Communication(k) => u32::from(k),
            SlotUse::Sensing => 254,
            SlotUse::Idle => 255,
        };
        visit(&mut word);
        *self = match word as u8 {
            254 => SlotUse::Sensing,
            255 => SlotUse::Idle,
            k => SlotUse::Communication(k),
        };
    }
}

/// Plays a plan, slot by slot: [`Plan::senses`] says when the radar sweeps, `SlotOrder` which user has the others.
///
/// Between two slots of a user lie at most [`Plan::longest_wait`] others.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sequencer {
    plan: Plan,
    order: SlotOrder,
    position: u32,
    due: u32,
    left: u32,
    /// Slots that the users had in this period before the rest was reassigned.
    before: [u32; USERS],
}

impl Sequencer {
    /// Begins a period of the plan.
    pub fn new(plan: &Plan) -> Self {
        Sequencer {
            order: SlotOrder::new(plan.shares()),
            position: 0,
            due: 1,
            left: plan.sensing(),
            before: [0; USERS],
            plan: plan.clone(),
        }
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Slots of the current period already played, 0..N.
    pub fn position(&self) -> u32 {
        self.position
    }

    /// Sensing slots of the current period still to come.
    pub fn sensing_left(&self) -> u32 {
        self.left
    }

    /// Slots each user had in the current period.
    pub fn served(&self) -> [u32; USERS] {
        let mut served = self.order.served();
        served.iter_mut().zip(self.before).for_each(|(served, before)| *served += before);
        served
    }

    /// Begins a new period at once, with another plan if one is given.
    pub fn restart(&mut self, plan: Option<&Plan>) {
        if let Some(plan) = plan {
            self.plan.clone_from(plan);
        }
        self.order = SlotOrder::new(self.plan.shares());
        (self.position, self.due, self.left) = (0, 1, self.plan.sensing());
        self.before = [0; USERS];
    }

    /// Slots of the current period still to come.
    pub fn rest(&self) -> u32 {
        self.plan.period() - self.position
    }

    /// No more sensing in this period; how many slots are released, 0 if none is left or no period is running. They follow the
    /// order of the others until [`Sequencer::reassign`].
    pub fn release_sensing(&mut self) -> u32 {
        if self.position == 0 { 0 } else { core::mem::take(&mut self.left) }
    }

    /// Shares the rest of the period so that each user ends it with these totals, as far as they sum to what is left.
    pub fn reassign(&mut self, totals: &[u32; USERS]) {
        self.before = self.served();
        let mut shares = *totals;
        shares.iter_mut().zip(self.before).for_each(|(share, had)| *share = share.saturating_sub(had));
        self.order = SlotOrder::new(&shares);
    }

    /// Use of the next slot; after the period's last slot the next period begins.
    ///
    /// Cost: O(K), one division; K more at the end of a period.
    pub fn next_slot(&mut self) -> SlotUse {
        self.position += 1;
        let slot = if self.left > 0 && self.position == self.due {
            self.left -= 1;
            self.due = self.due.saturating_add(self.plan.spacing()).saturating_add(1);
            SlotUse::Sensing
        } else {
            self.order.next().map_or(SlotUse::Idle, |k| SlotUse::Communication(k as u8))
        };
        if self.position >= self.plan.period() {
            self.restart(None);
        }
        slot
    }
}

impl State for Sequencer {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        self.plan.words(visit);
        self.order.words(visit);
        [&mut self.position, &mut self.due, &mut self.left].into_iter().for_each(&mut *visit);
        self.before.iter_mut().for_each(visit);
    }
}
