//! A scheduler under watch: every slot has the radio's number, every word of the schedule is sealed between two slots.
//!
//! Numbers grow by one a slot and wrap after 2^32. What the schedule is made from (N, N_m, N_s, the receivers' rates) lies in two
//! sealed spares beside it: if the schedule's memory is found changed, a new period begins from a spare at once.

use crate::scheduler::{PlanError, RECEIVERS, Scheduler, Sensing, SlotUse};
use crate::state::{State, seal};

/// Most skipped slots that are played through; after more a new period begins.
pub const CATCH_UP: u32 = 64;

/// Words of memory in which a watched schedule survives a reset.
pub const WORDS: usize = 156;

/// What was wrong when a slot began. Told once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Fault {
    /// Numbers were skipped; the slots are lost to those they were planned for.
    Skipped {
        /// Slots.
        slots: u32,
        /// Those of them that were to sense.
        sensing: u32,
    },
    /// More numbers were skipped than are played through, or the rest of the period: a new period begins.
    Outage {
        /// Slots.
        slots: u32,
    },
    /// The number of the slot before: its use is given again.
    Repeated,
    /// A number that was given before: the slot stays idle.
    Late,
    /// The radio counts from another number: a new period begins.
    Recounted,
    /// The schedule's memory had changed: a new period begins from a spare.
    Schedule,
    /// A spare's memory had changed: it is made again.
    Spare,
    /// Schedule and both spares had changed: slots stay idle until [`Watch::configure`].
    Forgotten,
}

/// A slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Step {
    /// What it is for.
    pub slot: SlotUse,
    /// Whether a period begins with it, or began with the slots skipped before it: recordings begin anew.
    pub begins: bool,
    /// What was wrong.
    pub fault: Option<Fault>,
}

/// What a schedule is made from, and its seal.
#[derive(Debug, Clone)]
struct Spare {
    sensing: Sensing,
    rates: [u32; RECEIVERS],
    seal: u32,
}

impl State for Spare {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        self.sensing.words(visit);
        self.rates.iter_mut().for_each(visit);
    }
}

impl Spare {
    fn new(sensing: Sensing, rates: [u32; RECEIVERS]) -> Self {
        let mut spare = Spare { sensing, rates, seal: 0 };
        spare.seal = seal(&mut spare);
        spare
    }

    fn whole(&mut self) -> bool {
        self.seal == seal(self)
    }
}

/// The schedule and where it stands: what one seal is over.
#[derive(Debug, Clone)]
struct Watched {
    scheduler: Scheduler,
    /// Number of the next slot.
    next: u32,
    /// A number out of order that the next one may go on from.
    other: u32,
    /// Whether there is one.
    doubtful: bool,
    /// Whether nothing is known and slots stay idle.
    forgotten: bool,
}

impl State for Watched {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        self.scheduler.words(visit);
        [&mut self.next, &mut self.other].into_iter().for_each(&mut *visit);
        crate::state::flag(&mut self.doubtful, visit);
        crate::state::flag(&mut self.forgotten, visit);
    }
}

/// A scheduler under watch.
#[derive(Debug, Clone)]
pub struct Watch {
    watched: Watched,
    seal: u32,
    spares: [Spare; 2],
}

impl Watch {
    /// Begins a period at the slot of this number.
    pub fn new(sensing: Sensing, rates: [u32; RECEIVERS], number: u32) -> Self {
        let scheduler = Scheduler::new(sensing, rates);
        let watched = Watched { scheduler, next: number, other: 0, doubtful: false, forgotten: false };
        let spare = Spare::new(sensing, rates);
        let mut watch = Watch { watched, seal: 0, spares: [spare.clone(), spare] };
        watch.close();
        watch
    }

    /// The schedule, to be looked at.
    pub fn scheduler(&self) -> &Scheduler {
        &self.watched.scheduler
    }

    /// Use of the slot that the radio gives this number. Cost: two passes over [`WORDS`] words beside [`Scheduler::next`]; after
    /// skipped slots at most [`CATCH_UP`] times that.
    pub fn next(&mut self, number: u32) -> Step {
        let mut fault = self.open(number);
        if self.watched.forgotten {
            self.watched.next = number.wrapping_add(1);
            self.close();
            return Step { slot: SlotUse::Idle, begins: false, fault };
        }
        // the period that begins may begin with skipped slots
        let between = self.watched.scheduler.position() == 0;
        if fault.is_none() {
            match number.wrapping_sub(self.watched.next) {
                0 => (),
                u32::MAX if !self.watched.doubtful => {
                    return self.aside(number, self.watched.scheduler.last(), Fault::Repeated);
                }
                gap if gap < 1 << 31 => fault = Some(self.skip(gap)),
                _ if self.watched.doubtful && number == self.watched.other => {
                    fault = Some(Fault::Recounted);
                    self.anew();
                }
                _ => return self.aside(number, SlotUse::Idle, Fault::Late),
            }
        }
        self.watched.doubtful = false;
        self.watched.next = number.wrapping_add(1);
        let begins = between || self.watched.scheduler.position() == 0;
        let slot = self.watched.scheduler.next();
        if begins {
            fault = fault.or(self.mend());
        }
        self.close();
        Step { slot, begins, fault }
    }

    /// The slot given last was lost: see [`Scheduler::lose`].
    pub fn lose(&mut self) -> Option<Fault> {
        self.change(|scheduler| scheduler.lose())
    }

    /// No more sensing in this period: see [`Scheduler::end_sensing`].
    pub fn end_sensing(&mut self) -> Option<Fault> {
        self.change(|scheduler| scheduler.end_sensing())
    }

    /// Bits a slot carries to a receiver from the next period on: see [`Scheduler::set_rate`].
    pub fn set_rate(&mut self, receiver: usize, rate: u32) -> Option<Fault> {
        let fault = self.change(|scheduler| scheduler.set_rate(receiver, rate));
        self.renew_spares();
        fault
    }

    /// Sensing from the next period on: see [`Scheduler::set_sensing`].
    pub fn set_sensing(&mut self, sensing: Sensing) -> Option<Fault> {
        let fault = self.change(|scheduler| scheduler.set_sensing(sensing));
        self.renew_spares();
        fault
    }

    /// [`Watch::set_sensing`] with N_s alone.
    ///
    /// # Errors
    ///
    /// [`PlanError::Spacing`], and nothing changes, if they do not fit the period.
    pub fn set_sensing_slots(&mut self, slots: u32) -> Result<Option<Fault>, PlanError> {
        let wanted = self.watched.scheduler.wanted();
        Ok(self.set_sensing(Sensing::new(wanted.period(), wanted.spacing(), slots)?))
    }

    /// Makes everything anew, whatever was: a period begins with the next slot.
    pub fn configure(&mut self, sensing: Sensing, rates: [u32; RECEIVERS]) {
        *self = Watch::new(sensing, rates, self.watched.next);
    }

    /// Writes everything to memory that survives a reset. Cost: [`WORDS`] stores.
    pub fn save(&mut self, memory: &mut [u32; WORDS]) {
        let mut words = memory.iter_mut();
        self.words(&mut |word| {
            if let Some(to) = words.next() {
                *to = *word;
            }
        });
    }

    /// What [`Watch::save`] wrote, if it is whole. Slots that passed since are found skipped by the next number.
    pub fn restore(memory: &[u32; WORDS]) -> Option<Self> {
        let mut watch = Watch::new(Sensing::new(1, 0, 0).ok()?, [0; RECEIVERS], 0);
        let mut words = memory.iter();
        watch.words(&mut |word| *word = words.next().copied().unwrap_or(0));
        let whole = watch.seal == seal(&mut watch.watched) && !watch.watched.forgotten;
        (whole && watch.spares.iter_mut().all(Spare::whole)).then_some(watch)
    }

    /// Looks at the seal; a broken one is answered at once.
    fn open(&mut self, number: u32) -> Option<Fault> {
        if self.seal == seal(&mut self.watched) {
            return None;
        }
        let [first, second] = &mut self.spares;
        let spare = if first.whole() { Some(&*first) } else { second.whole().then_some(&*second) };
        match spare {
            Some(spare) => {
                *self = Watch::new(spare.sensing, spare.rates, number);
                Some(Fault::Schedule)
            }
            None => {
                if let Ok(nothing) = Sensing::new(1, 0, 0) {
                    *self = Watch::new(nothing, [0; RECEIVERS], number);
                }
                self.watched.forgotten = true;
                Some(Fault::Forgotten)
            }
        }
    }

    fn close(&mut self) {
        self.seal = seal(&mut self.watched);
    }

    fn change(&mut self, what: impl FnOnce(&mut Scheduler)) -> Option<Fault> {
        let fault = self.open(self.watched.next);
        what(&mut self.watched.scheduler);
        self.close();
        fault
    }

    /// A slot beside the row of numbers.
    fn aside(&mut self, number: u32, slot: SlotUse, fault: Fault) -> Step {
        self.watched.doubtful = fault == Fault::Late;
        self.watched.other = number.wrapping_add(1);
        self.close();
        Step { slot, begins: false, fault: Some(fault) }
    }

    /// Plays skipped slots as lost.
    fn skip(&mut self, slots: u32) -> Fault {
        let scheduler = &mut self.watched.scheduler;
        let left = scheduler.plan().period().saturating_sub(scheduler.position());
        // between periods none of the next one has been played
        if slots > CATCH_UP || slots >= left {
            self.anew();
            return Fault::Outage { slots };
        }
        let mut sensing = 0;
        for _ in 0..slots.min(CATCH_UP) {
            sensing += u32::from(scheduler.next() == SlotUse::Sensing);
            scheduler.lose();
        }
        Fault::Skipped { slots, sensing }
    }

    /// A new period of what is wanted.
    fn anew(&mut self) {
        let scheduler = &mut self.watched.scheduler;
        *scheduler = Scheduler::new(scheduler.wanted(), scheduler.rates());
    }

    fn renew_spares(&mut self) {
        let scheduler = &self.watched.scheduler;
        let spare = Spare::new(scheduler.wanted(), scheduler.rates());
        self.spares = [spare.clone(), spare];
    }

    /// Looks after the spares.
    fn mend(&mut self) -> Option<Fault> {
        if self.spares.iter_mut().all(Spare::whole) {
            return None;
        }
        self.renew_spares();
        Some(Fault::Spare)
    }
}

impl State for Watch {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        self.watched.words(visit);
        visit(&mut self.seal);
        for spare in &mut self.spares {
            spare.words(visit);
            visit(&mut spare.seal);
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn watch(number: u32) -> Watch {
        Watch::new(Sensing::new(40, 3, 5).unwrap(), [3, 2, 1, 0, 0, 0, 0, 0], number)
    }

    fn uses(watch: &mut Watch, numbers: impl IntoIterator<Item = u32>) -> Vec<SlotUse> {
        numbers.into_iter().map(|number| watch.next(number).slot).collect()
    }

    #[test]
    fn without_faults_it_is_the_scheduler_and_the_number_may_wrap() {
        let mut scheduler = Scheduler::new(Sensing::new(40, 3, 5).unwrap(), [3, 2, 1, 0, 0, 0, 0, 0]);
        let mut watch = watch(u32::MAX - 30);
        for n in 0..200_u32 {
            let step = watch.next((u32::MAX - 30).wrapping_add(n));
            assert_eq!((step.slot, step.fault), (scheduler.next(), None), "slot {n}");
            assert_eq!(step.begins, n % 40 == 0);
        }
    }

    #[test]
    fn the_state_has_as_many_words_as_memory_is_kept_for() {
        let mut count = 0;
        watch(0).words(&mut |_| count += 1);
        assert_eq!(count, WORDS);
    }

    #[test]
    fn skipped_slots_are_lost_and_the_rest_of_the_period_stands() {
        let whole = uses(&mut watch(7), 7..47);
        let mut gapped = watch(7);
        assert_eq!(uses(&mut gapped, 7..17), whole[..10]);
        let step = gapped.next(23);
        let sensing = whole[10..16].iter().filter(|&&slot| slot == SlotUse::Sensing).count() as u32;
        assert_eq!((step.slot, step.fault), (whole[16], Some(Fault::Skipped { slots: 6, sensing })));
        assert_eq!(uses(&mut gapped, 24..47), whole[17..]);
        assert!(gapped.next(47).begins);
        assert_eq!(gapped.scheduler().boundary().changes.lost + sensing, 6);
    }

    #[test]
    fn a_period_that_begins_with_skipped_slots_begins_all_the_same() {
        let whole = uses(&mut watch(0), 0..80);
        for skipped in [1, 5, 39] {
            let mut gapped = watch(0);
            uses(&mut gapped, 0..40);
            let step = gapped.next(40 + skipped);
            assert!(
                step.begins && matches!(step.fault, Some(Fault::Skipped { slots, .. }) if slots == skipped)
            );
            assert_eq!(step.slot, whole[40 + skipped as usize]);
            assert!(!gapped.next(41 + skipped).begins || skipped == 39);
        }
    }

    #[test]
    fn numbers_out_of_order_never_move_the_schedule() {
        let whole = uses(&mut watch(0), 0..40);
        let mut odd = watch(0);
        assert_eq!(uses(&mut odd, 0..12), whole[..12]);
        assert_eq!(odd.next(11), Step { slot: whole[11], begins: false, fault: Some(Fault::Repeated) });
        assert_eq!(odd.next(3), Step { slot: SlotUse::Idle, begins: false, fault: Some(Fault::Late) });
        assert_eq!(uses(&mut odd, 12..20), whole[12..20]);
        // the radio counts anew: the second number shows it
        assert_eq!(odd.next(0x8000_0000 + 20).fault, Some(Fault::Late));
        let step = odd.next(0x8000_0000 + 21);
        assert_eq!((step.slot, step.begins, step.fault), (whole[0], true, Some(Fault::Recounted)));
        // more than is played through
        let step = odd.next(0x8000_0000 + 100);
        assert_eq!((step.slot, step.begins, step.fault), (whole[0], true, Some(Fault::Outage { slots: 78 })));
    }

    #[test]
    fn any_flipped_bit_is_found_before_the_next_slot_is_given() {
        for at in 0..WORDS {
            for bit in [0, 1, 7, 8, 15, 16, 31] {
                let mut watch = watch(0);
                uses(&mut watch, 0..9);
                let (mut before, mut after) = ([0; WORDS], [0; WORDS]);
                watch.save(&mut before);
                let mut word = 0;
                watch.words(&mut |w| {
                    *w ^= u32::from(word == at) << bit;
                    word += 1;
                });
                watch.save(&mut after);
                if before == after {
                    continue; // a byte's upper bits: nothing has changed
                }
                assert!(Watch::restore(&after).is_none(), "word {at} bit {bit}");
                let faults: Vec<Fault> = (9..60).filter_map(|n| watch.next(n).fault).collect();
                let found = match faults[..] {
                    [Fault::Schedule] => at < WORDS - 24,
                    [Fault::Spare] => at >= WORDS - 24,
                    _ => false,
                };
                assert!(found, "word {at} bit {bit}: {faults:?}");
                assert_eq!(watch.scheduler().wanted(), Sensing::new(40, 3, 5).unwrap());
            }
        }
    }

    #[test]
    fn what_is_told_to_a_damaged_schedule_tells_the_damage() {
        let told = |tell: fn(&mut Watch) -> Option<Fault>| {
            let (mut whole, mut damaged) = (watch(0), watch(0));
            uses(&mut whole, 0..3);
            uses(&mut damaged, 0..3);
            damaged.watched.next ^= 4;
            (tell(&mut whole), tell(&mut damaged))
        };
        let expected = (None, Some(Fault::Schedule));
        assert_eq!(told(|watch| watch.lose()), expected);
        assert_eq!(told(|watch| watch.end_sensing()), expected);
        assert_eq!(told(|watch| watch.set_rate(1, 9)), expected);
        assert_eq!(told(|watch| watch.set_sensing(Sensing::new(40, 3, 2).unwrap())), expected);
        assert_eq!(told(|watch| watch.set_sensing_slots(2).unwrap()), expected);
        let mut watch = watch(0);
        assert_eq!(watch.set_sensing_slots(2), Ok(None));
        assert_eq!(watch.scheduler().wanted(), Sensing::new(40, 3, 2).unwrap());
        assert!(watch.set_sensing_slots(11).is_err());
        assert_eq!(watch.scheduler().wanted(), Sensing::new(40, 3, 2).unwrap());
    }

    #[test]
    fn as_many_skipped_slots_are_played_through_as_stated() {
        let long = || Watch::new(Sensing::new(400, 3, 5).unwrap(), [3, 2, 1, 0, 0, 0, 0, 0], 0);
        let whole = uses(&mut long(), 0..400);
        for (skipped, played) in [(63, true), (64, true), (65, false)] {
            let mut gapped = long();
            uses(&mut gapped, 0..30);
            let step = gapped.next(30 + skipped);
            match step.fault {
                Some(Fault::Skipped { slots, sensing: 0 }) => assert!(played && slots == skipped),
                Some(Fault::Outage { slots }) => assert!(!played && slots == skipped),
                other => panic!("{skipped}: {other:?}"),
            }
            let at = if played { 30 + skipped as usize } else { 0 };
            assert_eq!((step.begins, step.slot), (!played, whole[at]));
        }
    }

    #[test]
    fn a_doubtful_number_decides_nothing_alone() {
        let whole = uses(&mut watch(100), 100..140);
        let mut odd = watch(100);
        assert_eq!(uses(&mut odd, 100..105), whole[..5]);
        // nobody has counted from 0 before
        assert_eq!(odd.next(0).fault, Some(Fault::Late));
        // the slot before is no repetition now: what the radio counts from is not known
        assert_eq!(odd.next(104), Step { slot: SlotUse::Idle, begins: false, fault: Some(Fault::Late) });
        assert_eq!(uses(&mut odd, 105..140), whole[5..]);
    }

    #[test]
    fn a_reset_goes_on_from_kept_memory() {
        let whole = uses(&mut watch(0), 0..40);
        let mut running = watch(0);
        uses(&mut running, 0..10);
        let mut memory = [0; WORDS];
        running.save(&mut memory);
        let mut back = Watch::restore(&memory).unwrap();
        // two slots passed meanwhile
        assert!(matches!(back.next(12), Step { fault: Some(Fault::Skipped { slots: 2, .. }), .. }));
        assert_eq!(uses(&mut back, 13..40), whole[13..]);
        memory[17] ^= 4;
        assert!(Watch::restore(&memory).is_none());
        // memory that nobody has written
        for word in [0, u32::MAX, 0xAAAA_AAAA, 0x5555_5555, 0xDEAD_BEEF] {
            assert!(Watch::restore(&[word; WORDS]).is_none(), "{word:#x}");
        }
    }

    #[test]
    fn with_everything_changed_slots_stay_idle_until_configured() {
        let mut lost = watch(0);
        uses(&mut lost, 0..5);
        lost.watched.next ^= 1;
        lost.spares.iter_mut().for_each(|spare| spare.rates[0] ^= 1);
        assert_eq!(lost.next(5), Step { slot: SlotUse::Idle, begins: false, fault: Some(Fault::Forgotten) });
        assert_eq!(lost.next(6), Step { slot: SlotUse::Idle, begins: false, fault: None });
        lost.configure(Sensing::new(40, 3, 5).unwrap(), [3, 2, 1, 0, 0, 0, 0, 0]);
        assert_eq!(uses(&mut lost, 7..47), uses(&mut watch(7), 7..47));
    }
}
