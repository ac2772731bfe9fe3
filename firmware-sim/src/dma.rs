//! A double buffer between an interrupt and the idle loop: one side fills a slot while the other reads the one before.
//!
//! What a DMA engine with two descriptors gives a driver; here the interrupt handler plays the engine.
#![allow(unsafe_code)]

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering};
use sdp3_core::dims::{Iq, SLOT_SAMPLES, Slot};

const ZERO: Slot = [Iq { i: 0, q: 0 }; SLOT_SAMPLES];

/// Two slots and who may touch each.
pub struct DoubleBuffer {
    slots: [UnsafeCell<Slot>; 2],
    full: [AtomicBool; 2],
    split: AtomicBool,
}

// SAFETY: `split` makes one writer and one reader, ever; a slot belongs to the writer while its flag is down and to the
// reader while it is up, and only the owner changes the flag.
unsafe impl Sync for DoubleBuffer {}

impl DoubleBuffer {
    /// Two empty slots.
    pub const fn new() -> Self {
        DoubleBuffer {
            slots: [UnsafeCell::new(ZERO), UnsafeCell::new(ZERO)],
            full: [AtomicBool::new(false), AtomicBool::new(false)],
            split: AtomicBool::new(false),
        }
    }

    /// Its two ends, the first time.
    pub fn split(&'static self) -> Option<(Writer, Reader)> {
        let first = !crate::rt::test_and_set(&self.split);
        first.then_some((Writer { buffer: self, odd: false }, Reader { buffer: self, odd: false }))
    }

    /// The slot and flag whose turn it is.
    fn half(&self, odd: bool) -> (&UnsafeCell<Slot>, &AtomicBool) {
        let [even_slot, odd_slot] = &self.slots;
        let [even_full, odd_full] = &self.full;
        if odd { (odd_slot, odd_full) } else { (even_slot, even_full) }
    }
}

impl Default for DoubleBuffer {
    fn default() -> Self {
        Self::new()
    }
}

/// The converter's end.
pub struct Writer {
    buffer: &'static DoubleBuffer,
    odd: bool,
}

impl Writer {
    /// Lets `fill` write the next slot; false, and nothing is called, if the reader is two slots behind.
    pub fn fill(&mut self, fill: impl FnOnce(&mut Slot)) -> bool {
        let (slot, full) = self.buffer.half(self.odd);
        if full.load(Ordering::Acquire) {
            return false;
        }
        // SAFETY: the flag is down, so the slot is the writer's; there is one writer, and it is borrowed exclusively.
        fill(unsafe { &mut *slot.get() });
        full.store(true, Ordering::Release);
        self.odd = !self.odd;
        true
    }
}

/// The idle loop's end.
pub struct Reader {
    buffer: &'static DoubleBuffer,
    odd: bool,
}

impl Reader {
    /// Lets `read` see the oldest full slot, if there is one.
    pub fn read<R>(&mut self, read: impl FnOnce(&Slot) -> R) -> Option<R> {
        let (slot, full) = self.buffer.half(self.odd);
        if !full.load(Ordering::Acquire) {
            return None;
        }
        // SAFETY: the flag is up, so the slot is the reader's; there is one reader, and it is borrowed exclusively.
        let result = read(unsafe { &*slot.get() });
        full.store(false, Ordering::Release);
        self.odd = !self.odd;
        Some(result)
    }
}
