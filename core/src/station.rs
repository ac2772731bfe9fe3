//! Scheduler and receiver together: one call per slot, the firmware's whole day.
//!
//! [`Station::begin`] says what the next slot is for; in a sensing slot the samples go to [`Station::sensed`]. As soon as the
//! receiver is sure, the period's remaining sensing slots go to communication.

use crate::dims::Slot;
use crate::dsn::{Kernels, WinogradF2};
use crate::early_exit::{Anytime, Verdict};
use crate::scheduler::{Scheduler, SlotUse};
use crate::signal::stft::{NativeStft, Stft};

/// A base station's slot loop.
#[derive(Debug)]
pub struct Station<'m, 'b, K = WinogradF2<'b>, T = NativeStft> {
    scheduler: Scheduler,
    receiver: Anytime<'m, 'b, K, T>,
}

impl<'m, 'b, K: Kernels, T: Stft> Station<'m, 'b, K, T> {
    /// Plays `scheduler`'s plans and recognises with `receiver`; one exit makes a receiver that never stops early.
    pub fn new(scheduler: Scheduler, receiver: Anytime<'m, 'b, K, T>) -> Self {
        Station { scheduler, receiver }
    }

    /// Use of the next slot. A recording never crosses a period: at its first slot an unfinished one is forgotten.
    pub fn begin(&mut self) -> SlotUse {
        if self.scheduler.position() == 0 {
            self.receiver.reset();
        }
        self.scheduler.next()
    }

    /// Takes the samples of a sensing slot; verdicts come at the receiver's exits. The one that stops ends the period's sensing.
    pub fn sensed(&mut self, slot: &Slot) -> Option<Verdict> {
        let verdict = self.receiver.push(slot, &mut ());
        if verdict.as_ref().is_some_and(|verdict| verdict.stop) {
            self.scheduler.end_sensing();
        }
        verdict
    }

    /// The slot that [`Station::begin`] gave last was lost or pre-empted. A recording with a gap is no recording: a lost sensing
    /// slot begins it anew, or ends the period's sensing if too few slots are left for the first exit.
    pub fn lose(&mut self, slot: SlotUse) {
        self.scheduler.lose();
        if slot == SlotUse::Sensing && !self.receiver.stopped() {
            self.receiver.reset();
            let need = self.receiver.exits().first().map_or(0, |exit| exit.model.sensing_slots());
            if (self.scheduler.sensing_left() as usize) < need {
                self.scheduler.end_sensing();
            }
        }
    }

    /// The schedule, to tell it what changes.
    pub fn scheduler(&mut self) -> &mut Scheduler {
        &mut self.scheduler
    }
}
