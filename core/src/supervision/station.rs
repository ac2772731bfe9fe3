//! The slot loop of a radio that fails: [`Station`](crate::station::Station) with every guard.
//!
//! [`Guarded::begin`] takes the radio's number of the slot and says what it is for; in a sensing slot the samples go to
//! [`Guarded::sensed`] with the same number. A recording with a gap is no recording: it begins anew, or the period's sensing ends
//! if too few slots are left for the first exit.

use super::sample_health::{self, SampleFault};
use super::verified_image::Intact;
use super::watch::{Fault, WORDS, Watch};
use crate::dims::Slot;
use crate::dsn::{Kernels, ModelError, WinogradF2};
use crate::early_exit::{Anytime, EXITS, Verdict};
use crate::scheduler::SlotUse;
use crate::signal::stft::{NativeStft, Stft};
use heapless::Vec;

/// Something that went wrong. Told once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Trouble {
    /// With the numbers of slots or the schedule's memory.
    Slot(Fault),
    /// With a slot's samples: they are not used.
    Samples(SampleFault),
    /// A sensing slot's samples did not come before the next slot.
    Missing,
    /// Samples that nobody waits for: late, or given twice. They are not used.
    Unasked,
    /// A model has changed: nothing is recognised, and the receivers have the sensing slots, until it is whole again.
    Model(ModelError),
}

/// A slot that begins.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Begun {
    /// What it is for.
    pub slot: SlotUse,
    /// What went wrong since the slot before.
    pub troubles: Vec<Trouble, 3>,
}

/// A base station's slot loop, guarded.
#[derive(Debug)]
pub struct Guarded<'m, 'b, K = WinogradF2<'b>, T = NativeStft> {
    watch: Watch,
    receiver: Anytime<'m, 'b, K, T>,
    models: Vec<Intact<'m>, EXITS>,
    /// Whether all models were whole when the period began.
    sound: bool,
    /// Number of the sensing slot whose samples are to come.
    awaited: Option<u32>,
}

impl<'m, 'b, K: Kernels, T: Stft> Guarded<'m, 'b, K, T> {
    /// Joins a watched schedule, a receiver and the files of its models, which are looked at again when a period begins.
    pub fn new(watch: Watch, receiver: Anytime<'m, 'b, K, T>, models: Vec<Intact<'m>, EXITS>) -> Self {
        Guarded { watch, receiver, models, sound: true, awaited: None }
    }

    /// The slot that the radio gives this number. Cost: [`Watch::next`]; when a period begins, [`Intact::check`] of every model.
    pub fn begin(&mut self, number: u32) -> Begun {
        let mut troubles = Vec::new();
        let mut tell = |trouble| {
            let _ = troubles.push(trouble); // three kinds, three places
        };
        let step = self.watch.next(number);
        let mut gap = matches!(step.fault, Some(Fault::Skipped { sensing: 1.., .. }));
        if let Some(fault) = step.fault {
            tell(Trouble::Slot(fault));
        }
        let again = step.fault == Some(Fault::Repeated);
        if self.awaited.is_some() && !again {
            tell(Trouble::Missing);
            self.awaited = None;
            // a gap in what ended is none in what begins
            gap |= !step.begins;
        }
        if step.begins {
            self.receiver.reset();
            let damage = self.models.iter().find_map(|model| model.check().err());
            if let (true, Some(error)) = (self.sound, damage) {
                tell(Trouble::Model(error));
            }
            self.sound = damage.is_none();
        }
        let mut slot = step.slot;
        let enough = !gap || self.restart(usize::from(slot == SlotUse::Sensing));
        if !self.sound {
            self.watch.end_sensing();
        }
        if slot == SlotUse::Sensing && !(enough && self.sound) {
            slot = SlotUse::Idle; // its samples would serve nothing
        }
        if slot == SlotUse::Sensing && !again && !self.receiver.stopped() {
            self.awaited = Some(number);
        }
        Begun { slot, troubles }
    }

    /// The samples of the sensing slot that began with this number. The verdict that stops ends the period's sensing.
    ///
    /// # Errors
    ///
    /// [`Trouble::Samples`], [`Trouble::Unasked`]: the samples are not used.
    pub fn sensed(&mut self, number: u32, slot: &Slot) -> Result<Option<Verdict>, Trouble> {
        if self.awaited != Some(number) {
            return Err(Trouble::Unasked);
        }
        self.awaited = None;
        if let Err(fault) = sample_health::check(slot) {
            self.watch.lose();
            self.restart(0);
            return Err(Trouble::Samples(fault));
        }
        let verdict = self.receiver.push(slot, &mut ());
        if verdict.as_ref().is_some_and(|verdict| verdict.stop) {
            self.watch.end_sensing();
        }
        Ok(verdict)
    }

    /// The watched schedule, to tell it what changes.
    pub fn watch(&mut self) -> &mut Watch {
        &mut self.watch
    }

    /// The receiver, to be looked at.
    pub fn receiver(&self) -> &Anytime<'m, 'b, K, T> {
        &self.receiver
    }

    /// After a reset: goes on in the period that was running when [`Watch::save`] wrote `memory`, with a recording begun anew if the
    /// period has slots enough for one. `false` if the memory is not whole: then nothing changes.
    #[must_use]
    pub fn restore(&mut self, memory: &[u32; WORDS]) -> bool {
        let Some(watch) = Watch::restore(memory) else { return false };
        self.watch = watch;
        self.receiver.reset();
        self.awaited = None;
        self.restart(0);
        true
    }

    /// The recording begins anew, if the period has slots enough for one: those to come and the `current` one. Whether it has.
    fn restart(&mut self, current: usize) -> bool {
        if self.receiver.stopped() {
            return true;
        }
        self.receiver.reset();
        let need = self.receiver.exits().first().map_or(0, |exit| exit.model.sensing_slots());
        let enough = (self.watch.scheduler().sensing_left() as usize).saturating_add(current) >= need;
        if !enough {
            self.watch.end_sensing();
        }
        enough
    }
}
