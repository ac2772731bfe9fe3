//! The radio under the timer interrupt: slot numbers, samples, and the faults that are injected into them.

use super::injection::{Expected, HARMFUL, HARMLESS, Injection, Injection::*, KINDS, Report, corrupt};
use super::shared::{FIRST_EXIT, INTERRUPTS, QUIET, RETAINED, VALUES, maximum};
use core::sync::atomic::Ordering::Relaxed;
use heapless::spsc::Producer;
use rand_core::Rng;
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::digest::Digest;
use sdp3_core::radar::{SlotAction, SlotContext};
use sdp3_core::supervision::retained::Retained;
use sdp3_firmware_sim::rt::{instructions, lateness, pending};
use sdp3_testkit::flip;

/// Instructions after which an interrupt is late: the one before had not returned.
const LATE: u64 = 1000;
/// Bytes of a use in the digest, beside the number of a user.
const SENSES: u8 = 254;
const IDLE: u8 = 255;

/// The radio's side: numbers, samples, faults.
pub struct Radio {
    pub slots: SlotContext<VALUES>,
    pub rng: Xoshiro128PlusPlus,
    pub noise: &'static [i16],
    pub expected: Producer<'static, Expected>,
    /// Slots to play.
    pub total: u32,
    /// Number of the next slot.
    pub number: u32,
    /// Whether a transfer is under way.
    pub transfer: bool,
    /// Times that the state was saved: the parity says which copy is newer.
    pub saves: usize,
    /// Sensing slots of the running period, and whether none of them was touched.
    pub sensed: u32,
    pub untouched: bool,
    pub faults: bool,
    /// What is injected next, as soon as it is possible.
    pub injection: Option<Injection>,
    /// The interrupt from which it may be.
    pub next: u32,
    pub injected: [u32; KINDS],
    pub harmful: usize,
    /// Instructions of measuring nothing.
    pub overhead: u64,
    /// Instructions of all calls in this interrupt.
    pub both: u64,
    pub late: u32,
    pub latest: u32,
    /// Of slots without a fault, and with each.
    pub worst_begin: [u32; KINDS + 1],
    pub worst_ready: u32,
    pub worst_both: u32,
    pub uses: Digest,
}

impl Radio {
    fn expect(&mut self, report: Report) {
        let since = INTERRUPTS.load(Relaxed);
        let _ = self.expected.enqueue(Expected { report, since }); // a report without its entry is found as wrong
    }

    /// What is injected into this slot, if that is possible now.
    fn draw(&mut self, sensed: bool) -> Option<Injection> {
        let now = INTERRUPTS.load(Relaxed);
        if !self.faults || now < self.next || now + QUIET > self.total {
            return None;
        }
        let draw = self.rng.next_u32() as usize;
        let harmful = &mut self.harmful;
        let kind = *self.injection.get_or_insert_with(|| {
            let kinds = if draw.is_multiple_of(32) { &HARMFUL[..] } else { &HARMLESS[..] };
            let which =
                if draw.is_multiple_of(32) { core::mem::replace(harmful, *harmful + 1) } else { draw / 32 };
            kinds.get(which % kinds.len()).copied().unwrap_or(Repeated)
        });
        let possible = match kind {
            Unexpected => !sensed,
            Missing | Delayed => sensed,
            // the report of the period before has been taken
            Lost => self.slots.position() > 16,
            // surely of a recording that is used
            kind if kind.is_of_samples() => self.untouched && (8..FIRST_EXIT - 50).contains(&self.sensed),
            _ => true,
        };
        possible.then_some(kind)
    }

    /// It has been injected.
    fn injected(&mut self, kind: Injection) {
        if let Some(count) = self.injected.get_mut(kind as usize) {
            *count += 1;
        }
        self.injection = None;
        self.untouched &= HARMLESS.contains(&kind);
        self.next = INTERRUPTS.load(Relaxed) + 30 + self.rng.next_u32() % 200;
    }

    fn samples_ready(&mut self) {
        let before = instructions();
        self.slots.samples_ready();
        let count = (instructions() - before).saturating_sub(self.overhead);
        self.both += count;
        maximum(&mut self.worst_ready, count);
    }

    /// The number that the radio gives this slot, with what goes wrong before it.
    fn number(&mut self, injection: Option<Injection>) -> u32 {
        let draw = self.rng.next_u32();
        let next = self.number;
        let given = match injection {
            Some(Repeated) => next.wrapping_sub(1),
            Some(Late) => next.wrapping_sub(2 + draw % 1000),
            Some(Skipped) => next.wrapping_add(1 + draw % 8),
            Some(Outage) => next.wrapping_add(9 + draw % 5000),
            Some(CounterReset) => next.wrapping_sub(1000 + draw % (1 << 30)),
            _ => next,
        };
        if !matches!(injection, Some(Repeated | Late)) {
            self.number = given.wrapping_add(1);
        }
        let half = Retained::LEN / 2;
        let newer = self.saves % 2 * half;
        let (word, mask) = (draw as usize % half, 1 << (draw >> 27));
        match injection {
            Some(FlipOlder) => flip(&RETAINED, half - newer + word, mask),
            Some(FlipNewer) => flip(&RETAINED, newer + word, mask),
            Some(FlipBoth) => [word, half + word].into_iter().for_each(|at| flip(&RETAINED, at, mask)),
            _ => (),
        }
        self.saves += usize::from(injection != Some(Repeated));
        match injection {
            Some(Repeated) => self.expect(Report::Repeated),
            Some(Late) => self.expect(Report::Late),
            Some(Skipped | Outage) => self.expect(Report::Gap(given.wrapping_sub(next))),
            Some(CounterReset) => {
                self.expect(Report::Late);
                self.expect(Report::CounterReset);
            }
            Some(FlipNewer) => self.expect(Report::Repaired),
            Some(FlipBoth) => self.expect(Report::StateLost),
            Some(Missing) => self.expect(Report::Missing),
            Some(Delayed) => {
                self.expect(Report::Missing);
                self.expect(Report::Unexpected);
            }
            Some(Unexpected) => self.expect(Report::Unexpected),
            _ => (),
        }
        given
    }

    /// The interrupt of a slot.
    pub fn slot(&mut self) {
        let entered = lateness();
        self.both = 0;
        let sensed = core::mem::take(&mut self.transfer);
        let mut injection = self.draw(sensed);
        let lost = matches!(injection, Some(Missing | Delayed));
        if sensed && !lost || injection == Some(Unexpected) {
            self.samples_ready();
        }
        let number = self.number(injection);
        let before = instructions();
        let action = self.slots.begin(number);
        let count = (instructions() - before).saturating_sub(self.overhead);
        maximum(&mut self.latest, lateness());
        let mut report = None;
        let slot_use = match action {
            SlotAction::Sense(buffer) => {
                let at = self.rng.next_u32() as usize % (2 * VALUES) & !1;
                let samples = self.noise.get(at..at + VALUES).unwrap_or_default();
                buffer.0.iter_mut().zip(samples).for_each(|(to, from)| *to = *from);
                report = injection.and_then(|kind| corrupt(&mut buffer.0, kind));
                self.transfer = true;
                SENSES
            }
            SlotAction::Serve(user) => user,
            SlotAction::Idle => IDLE,
        };
        self.both += count;
        let kind = injection.map_or(KINDS, |kind| kind as usize);
        self.worst_begin.get_mut(kind).into_iter().for_each(|worst| maximum(worst, count));
        self.uses.value([slot_use]);
        if injection == Some(Delayed) {
            self.samples_ready();
        }
        if self.slots.position() == 1 {
            (self.sensed, self.untouched) = (0, true);
        }
        self.sensed += u32::from(slot_use == SENSES);
        match injection {
            Some(kind) if kind.is_of_samples() => match report {
                Some(report) => self.expect(report),
                None => injection = None, // the slot does not sense: another one
            },
            Some(Lost) if slot_use == IDLE => injection = None,
            Some(Lost) => {
                self.expect(Report::Lost);
                let before = instructions();
                self.slots.lost();
                self.both += (instructions() - before).saturating_sub(self.overhead);
                self.saves += 1;
                self.transfer = false;
            }
            _ => (),
        }
        if let Some(kind) = injection {
            self.injected(kind);
        }
        maximum(&mut self.worst_both, self.both);
        INTERRUPTS.store(INTERRUPTS.load(Relaxed) + 1, Relaxed);
        self.late += u32::from(entered > LATE || pending());
    }
}
