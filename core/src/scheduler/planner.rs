//! Which plan the next period gets: rates and layout as they were set last, lost slots given back.

use super::apportion::apportion;
use super::layout::{PlanError, SensingLayout, USERS};
use super::plan::Plan;
use super::sequencer::SlotUse;
use crate::supervision::retained::State;

/// What a period lost and gave back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PeriodCounts {
    /// Communication slots lost, of each user.
    pub lost: [u32; USERS],
    /// Sensing slots lost.
    pub sensing_lost: u32,
    /// Sensing slots released to the users.
    pub released: u32,
}

impl PeriodCounts {
    /// Counts a slot that was lost or pre-empted.
    pub fn on_lost(&mut self, slot: SlotUse) {
        match slot {
            SlotUse::Communication(k) => {
                if let Some(lost) = self.lost.get_mut(usize::from(k)) {
                    *lost = lost.saturating_add(1);
                }
            }
            SlotUse::Sensing => self.sensing_lost = self.sensing_lost.saturating_add(1),
            SlotUse::Idle => (),
        }
    }

    /// Adds another period's.
    pub(crate) fn add(&mut self, other: &Self) {
        for (lost, more) in self.lost.iter_mut().zip(other.lost) {
            *lost = lost.saturating_add(more);
        }
        self.sensing_lost = self.sensing_lost.saturating_add(other.sensing_lost);
        self.released = self.released.saturating_add(other.released);
    }

    /// The same as totals.
    pub(crate) fn changes(&self) -> Changes {
        let lost = self.lost.iter().copied().fold(0, u32::saturating_add);
        Changes { lost, sensing_lost: self.sensing_lost, released: self.released, ..Changes::default() }
    }
}

impl State for PeriodCounts {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        self.lost.iter_mut().for_each(&mut *visit);
        [&mut self.sensing_lost, &mut self.released].into_iter().for_each(visit);
    }
}

/// What happened since the period before began, and hence why this period's plan differs from that one's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Changes {
    /// Users that joined, one bit each.
    pub joined: u8,
    /// Users that left.
    pub left: u8,
    /// Users with another rate.
    pub rates: u8,
    /// Whether N_s or N_m is another.
    pub sensing: bool,
    /// Communication slots lost in the last period; each user gets its own back, up to half of the slots over K.
    pub lost: u32,
    /// Sensing slots lost in the last period.
    pub sensing_lost: u32,
    /// Sensing slots that the last period released to the users.
    pub released: u32,
}

/// What a period boundary did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PeriodReport {
    /// Number of the period that began: the first is 0 in a [`Scheduler`](super::Scheduler), 1 in a radar module.
    pub period: u32,
    /// Whether it has a new plan.
    pub replanned: bool,
    /// What happened before.
    pub changes: Changes,
}

/// Makes plans.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Planner {
    target: SensingLayout,
    rates: [u32; USERS],
    planned: [u32; USERS],
    changes: Changes,
    /// Whether the running plan gives back lost slots, and is therefore not the next one.
    repaying: bool,
}

impl Planner {
    /// Sensing slots as laid out, the others shared by `rates` (bits a slot, 0 for an absent user).
    pub fn new(target: SensingLayout, rates: [u32; USERS]) -> Self {
        Planner { target, rates, planned: rates, changes: Changes::default(), repaying: false }
    }

    /// The plan of a period without a history.
    pub fn first_plan(&self) -> Plan {
        Plan::optimal(self.target, &self.rates, &[0; USERS])
    }

    /// Sensing as it was set last.
    pub fn target(&self) -> SensingLayout {
        self.target
    }

    /// Rates as they were set last, bits a slot.
    pub fn rates(&self) -> [u32; USERS] {
        self.rates
    }

    /// Whether something was set that no plan has yet.
    pub fn has_changes(&self) -> bool {
        self.changes != Changes::default()
    }

    /// Bits a slot carries to a user, 0 if it is absent, from the next plan on. A user beyond the eighth is ignored.
    pub fn set_rate(&mut self, user: usize, rate: u32) {
        let Some(old) = self.rates.get_mut(user) else { return };
        let bit = 1_u8 << user;
        match (*old, rate) {
            (old, rate) if old == rate => (),
            (0, _) => self.changes.joined |= bit,
            (_, 0) => self.changes.left |= bit,
            _ => self.changes.rates |= bit,
        }
        *old = rate;
    }

    /// Sensing from the next plan on: another accuracy needs another N_s. The period's length may change too.
    pub fn set_layout(&mut self, layout: SensingLayout) {
        self.changes.sensing |= layout != self.target;
        self.target = layout;
    }

    /// [`Planner::set_layout`] with N_s alone.
    ///
    /// # Errors
    ///
    /// [`PlanError::Spacing`], and nothing changes, if they do not fit the period.
    pub fn set_sensing_slots(&mut self, slots: u32) -> Result<(), PlanError> {
        self.set_layout(SensingLayout::new(self.target.period(), self.target.spacing(), slots)?);
        Ok(())
    }

    /// The plan after a period with these counts, if it is another than the running one, and why. Cost: O(K^3).
    pub fn next_plan(&mut self, counts: &PeriodCounts) -> (Option<Plan>, Changes) {
        let Changes { lost, sensing_lost, released, .. } = counts.changes();
        let changes = Changes { lost, sensing_lost, released, ..core::mem::take(&mut self.changes) };
        let users = changes.joined | changes.left | changes.rates;
        if users == 0 && !changes.sensing && lost == 0 && !self.repaying {
            return (None, changes);
        }
        let present = self.rates.iter().filter(|&&rate| rate > 0).count().max(1) as u32;
        let most = self.target.data_slots() / (2 * present);
        let credit = counts.lost.map(|lost| -(lost.min(most) as i32));
        self.planned = self.rates;
        self.repaying = credit.iter().any(|&credit| credit < 0);
        (Some(Plan::optimal(self.target, &self.rates, &credit)), changes)
    }

    /// Totals of the period for every user that shares its last `rest` slots after an early end of sensing and has had `served`: the
    /// worst is as large as it can be. Where a number is beyond [`LONGEST_PERIOD`](super::layout::LONGEST_PERIOD) nothing is shared. Cost: O(K^3).
    pub fn totals(&self, rest: u32, served: &[u32; USERS]) -> [u32; USERS] {
        let credit = served.map(|served| served.min(i32::MAX as u32) as i32);
        let mut totals = [0; USERS];
        apportion(&self.planned, &credit, rest, &mut totals);
        totals.iter_mut().zip(served).for_each(|(total, served)| *total += served);
        totals
    }
}
