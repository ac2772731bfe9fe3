//! The schedule online: what changes during a period is answered at its end by a new optimal plan.
//!
//! Within a period the plan stands: its slots add up, sensing slots stay exactly periodic, waits stay bounded. The one thing that
//! may happen earlier is that sensing ends ([`Scheduler::end_sensing`]): then the receivers get the rest of the period at once.

use super::apportion::apportion;
use super::layout::{PlanError, RECEIVERS, Sensing};
use super::plan::Plan;
use super::sequencer::{Sequencer, SlotUse};
use crate::state::{State, byte, flag};

/// What happened since the period before began, and hence why this period's plan differs from that one's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Changes {
    /// Receivers that joined, one bit each.
    pub joined: u8,
    /// Receivers that left.
    pub left: u8,
    /// Receivers whose rate is another.
    pub rates: u8,
    /// Whether N_s or N_m is another.
    pub sensing: bool,
    /// Communication slots lost in the last period; each receiver gets its own back, up to half of the slots over K.
    pub lost: u32,
    /// Sensing slots lost in the last period.
    pub sensing_lost: u32,
    /// Sensing slots that the last period gave back to the receivers.
    pub released: u32,
}

/// What a period boundary did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Boundary {
    /// Number of the period that began, from 0.
    pub period: u32,
    /// Whether its plan was made anew.
    pub replanned: bool,
    /// What happened before.
    pub changes: Changes,
}

/// A running schedule.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scheduler {
    wanted: Sensing,
    rates: [u32; RECEIVERS],
    lost: [u32; RECEIVERS],
    changes: Changes,
    /// Rates the running plan was made by.
    planned: [u32; RECEIVERS],
    /// Whether the running plan repays lost slots, and is therefore not the next one.
    repaying: bool,
    begun: u32,
    boundary: Boundary,
    last: SlotUse,
    sequencer: Sequencer,
}

impl Scheduler {
    /// Plays optimal plans: `sensing` slots as laid out, the others shared by `rates` (bits a slot, 0 for an absent receiver).
    pub fn new(sensing: Sensing, rates: [u32; RECEIVERS]) -> Self {
        Scheduler {
            wanted: sensing,
            rates,
            lost: [0; RECEIVERS],
            changes: Changes::default(),
            planned: rates,
            repaying: false,
            begun: 0,
            boundary: Boundary { period: 0, replanned: true, changes: Changes::default() },
            last: SlotUse::Idle,
            sequencer: Sequencer::new(&Plan::optimal(sensing, &rates, &[0; RECEIVERS])),
        }
    }

    /// Sensing as it was set last.
    pub fn wanted(&self) -> Sensing {
        self.wanted
    }

    /// Rates as they were set last, bits a slot.
    pub fn rates(&self) -> [u32; RECEIVERS] {
        self.rates
    }

    /// What [`Scheduler::next`] gave last.
    pub fn last(&self) -> SlotUse {
        self.last
    }

    /// The plan being played.
    pub fn plan(&self) -> &Plan {
        self.sequencer.plan()
    }

    /// Slots of the current period already played, 0..N; 0 between periods.
    pub fn position(&self) -> u32 {
        self.sequencer.position()
    }

    /// Sensing slots of the current period still to come.
    pub fn sensing_left(&self) -> u32 {
        self.sequencer.sensing_left()
    }

    /// Slots each receiver had in the current period.
    pub fn served(&self) -> [u32; RECEIVERS] {
        self.sequencer.served()
    }

    /// What the last boundary did.
    pub fn boundary(&self) -> Boundary {
        self.boundary
    }

    /// Bits a slot carries to a receiver, 0 if it is absent, from the next period on. A receiver beyond the eighth is ignored.
    pub fn set_rate(&mut self, receiver: usize, rate: u32) {
        let Some(old) = self.rates.get_mut(receiver) else { return };
        let bit = 1_u8 << receiver;
        match (*old, rate) {
            (old, rate) if old == rate => (),
            (0, _) => self.changes.joined |= bit,
            (_, 0) => self.changes.left |= bit,
            _ => self.changes.rates |= bit,
        }
        *old = rate;
    }

    /// Sensing from the next period on: another accuracy needs another N_s. The period's length may change too.
    pub fn set_sensing(&mut self, sensing: Sensing) {
        self.changes.sensing |= sensing != self.wanted;
        self.wanted = sensing;
    }

    /// [`Scheduler::set_sensing`] with N_s alone.
    ///
    /// # Errors
    ///
    /// [`PlanError::Spacing`], and nothing changes, if they do not fit the period.
    pub fn set_sensing_slots(&mut self, slots: u32) -> Result<(), PlanError> {
        self.set_sensing(Sensing::new(self.wanted.period(), self.wanted.spacing(), slots)?);
        Ok(())
    }

    /// The slot that [`Scheduler::next`] gave last was lost or pre-empted.
    pub fn lose(&mut self) {
        match self.last {
            SlotUse::Communication(k) => {
                self.changes.lost += 1;
                if let Some(lost) = self.lost.get_mut(usize::from(k)) {
                    *lost += 1;
                }
            }
            SlotUse::Sensing => self.changes.sensing_lost += 1,
            SlotUse::Idle => (),
        }
    }

    /// No more sensing in this period: its remaining slots go to the receivers so that the period's worst total is as large as it
    /// can be. Between periods nothing happens. Cost: O(K^3).
    pub fn end_sensing(&mut self) {
        let left = self.sequencer.sensing_left();
        if left == 0 || self.position() == 0 {
            return;
        }
        let given = self.sequencer.served().map(|served| served as i32); // at most 2^24
        let rest = self.plan().period() - self.position();
        let mut shares = [0; RECEIVERS];
        apportion(&self.planned, &given, rest, &mut shares);
        self.sequencer.deal_rest(&shares);
        self.changes.released += left;
    }

    /// Use of the next slot. Before a period's first slot the plan is made anew if anything changed; [`Scheduler::boundary`]
    /// says so. Cost: O(K) without a division; O(K^3) at a boundary with changes.
    #[allow(clippy::should_implement_trait)] // it never ends: this is no iterator
    pub fn next(&mut self) -> SlotUse {
        if self.sequencer.position() == 0 {
            self.begin();
        }
        self.last = self.sequencer.next();
        self.last
    }

    fn begin(&mut self) {
        let c = self.changes;
        let others = c.joined | c.left | c.rates;
        let replanned = self.begun == 0 || others != 0 || c.sensing || c.lost > 0 || self.repaying;
        if replanned {
            let present = self.rates.iter().filter(|&&rate| rate > 0).count().max(1) as u32;
            let most = self.wanted.others() / (2 * present);
            let given = self.lost.map(|lost| -(lost.min(most) as i32));
            self.sequencer.restart(Some(&Plan::optimal(self.wanted, &self.rates, &given)));
            self.planned = self.rates;
            self.repaying = given.iter().any(|&given| given < 0);
        }
        self.boundary = Boundary { period: self.begun, replanned, changes: c };
        self.begun = self.begun.wrapping_add(1);
        self.changes = Changes::default();
        self.lost = [0; RECEIVERS];
    }
}

impl State for Changes {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        let Changes { joined, left, rates, sensing, lost, sensing_lost, released } = self;
        [joined, left, rates].into_iter().for_each(|bits| byte(bits, visit));
        flag(sensing, visit);
        [lost, sensing_lost, released].into_iter().for_each(visit);
    }
}

impl State for Scheduler {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        self.wanted.words(visit);
        [&mut self.rates, &mut self.lost, &mut self.planned].into_iter().flatten().for_each(&mut *visit);
        self.changes.words(visit);
        flag(&mut self.repaying, visit);
        visit(&mut self.begun);
        visit(&mut self.boundary.period);
        flag(&mut self.boundary.replanned, visit);
        self.boundary.changes.words(visit);
        self.last.words(visit);
        self.sequencer.words(visit);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    /// One period as it was played.
    fn period(scheduler: &mut Scheduler, mut during: impl FnMut(&mut Scheduler, SlotUse)) -> Vec<SlotUse> {
        let mut slots = Vec::new();
        loop {
            let slot = scheduler.next();
            slots.push(slot);
            if scheduler.position() == 0 {
                return slots;
            }
            during(scheduler, slot);
        }
    }

    fn count(slots: &[SlotUse], k: u8) -> u32 {
        slots.iter().filter(|&&slot| slot == SlotUse::Communication(k)).count() as u32
    }

    #[test]
    fn changes_wait_for_the_boundary_and_are_reported_there() {
        let sensing = Sensing::new(40, 3, 5).unwrap();
        let mut scheduler = Scheduler::new(sensing, [3, 3, 0, 0, 0, 0, 0, 0]);
        let plan = scheduler.plan().clone();
        let first = period(&mut scheduler, |s, slot| {
            s.set_rate(2, 7);
            s.set_rate(1, 5);
            s.set_sensing_slots(4).unwrap();
            assert!(s.set_sensing_slots(11).is_err());
            if slot == SlotUse::Communication(0) {
                s.lose();
            }
        });
        assert_eq!((count(&first, 0), count(&first, 1)), (plan.shares()[0], plan.shares()[1]));
        scheduler.next();
        let Boundary { period, replanned, changes } = scheduler.boundary();
        assert_eq!((period, replanned), (1, true));
        assert_eq!((changes.joined, changes.left, changes.rates, changes.sensing), (4, 0, 2, true));
        assert_eq!((changes.lost, changes.sensing_lost, changes.released), (count(&first, 0), 0, 0));
        assert_eq!(scheduler.plan().sensing(), 4);
    }

    #[test]
    fn lost_slots_are_given_back_once() {
        let sensing = Sensing::new(100, 3, 10).unwrap();
        let mut scheduler = Scheduler::new(sensing, [4, 4, 4, 0, 0, 0, 0, 0]);
        let mut lost = 0;
        period(&mut scheduler, |s, slot| {
            if slot == SlotUse::Communication(1) && lost < 9 {
                (lost, ()) = (lost + 1, s.lose());
            }
        });
        let second = period(&mut scheduler, |_, _| ());
        assert_eq!([count(&second, 0), count(&second, 1), count(&second, 2)], [27, 36, 27]);
        let third = period(&mut scheduler, |_, _| ());
        assert_eq!([count(&third, 0), count(&third, 1), count(&third, 2)], [30, 30, 30]);
        period(&mut scheduler, |_, _| ());
        assert!(!scheduler.boundary().replanned);
    }

    #[test]
    fn served_counts_what_was_given_in_this_period() {
        let sensing = Sensing::new(400, 3, 100).unwrap();
        let mut scheduler = Scheduler::new(sensing, [1, 2, 4, 0, 0, 0, 0, 0]);
        for _ in 0..2 {
            let mut given = [0; RECEIVERS];
            for n in 0..400 {
                if n == 90 {
                    scheduler.end_sensing();
                }
                if let SlotUse::Communication(k) = scheduler.next() {
                    given[usize::from(k)] += 1;
                }
                if n < 399 {
                    assert_eq!(scheduler.served(), given, "after slot {n}");
                }
            }
        }
    }

    #[test]
    fn ending_sensing_gives_its_slots_to_the_receivers() {
        let sensing = Sensing::new(400, 3, 100).unwrap();
        let mut scheduler = Scheduler::new(sensing, [1, 2, 4, 0, 0, 0, 0, 0]);
        let slots = period(&mut scheduler, |s, _| {
            if s.position() == 201 {
                s.end_sensing();
            }
        });
        assert_eq!(slots.iter().filter(|&&s| s == SlotUse::Sensing).count(), 51);
        let served = [count(&slots, 0), count(&slots, 1), count(&slots, 2)];
        // 349 slots by 1/1 : 1/2 : 1/4
        assert_eq!(served, [199, 100, 50]);
        scheduler.next();
        assert_eq!(scheduler.boundary().changes.released, 49);
    }
}
