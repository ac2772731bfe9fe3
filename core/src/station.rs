//! Scheduler and receiver together: one call per slot, the firmware's whole day.
//!
//! [`Station::begin`] says what the next slot is for; in a sensing slot the samples go to [`Station::sensed`].

use crate::dsn::{Kernels, Tiled};
use crate::frame::Slot;
use crate::receiver::{Receiver, Recognition};
use crate::schedule::{Plan, Sequencer, SlotUse};
use crate::stft::{NativeStft, ShortTime};

/// A base station's slot loop.
#[derive(Debug)]
pub struct Station<'m, 'b, K = Tiled<'b>, T = NativeStft> {
    sequencer: Sequencer,
    receiver: Receiver<'m, 'b, K, T>,
}

impl<'m, 'b, K: Kernels, T: ShortTime> Station<'m, 'b, K, T> {
    /// Plays `plan` and recognises with `receiver`.
    pub fn new(plan: &Plan, receiver: Receiver<'m, 'b, K, T>) -> Self {
        Station { sequencer: Sequencer::new(plan), receiver }
    }

    /// Use of the next slot. A recording never crosses a period: at its first slot an unfinished one is forgotten.
    pub fn begin(&mut self) -> SlotUse {
        if self.sequencer.position() == 0 {
            self.receiver.reset();
        }
        self.sequencer.next()
    }

    /// Takes the samples of a sensing slot. Answers when they complete a recording; slots beyond that are not used.
    pub fn sensed(&mut self, slot: &Slot) -> Option<Recognition> {
        let missing = self.receiver.push(slot, &mut ()).ok()?;
        (missing == 0).then(|| self.receiver.classify(&mut ()).ok()).flatten()
    }

    /// The scheduler.
    pub fn sequencer(&self) -> &Sequencer {
        &self.sequencer
    }
}
