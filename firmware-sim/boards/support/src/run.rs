//! What a run of the station has seen so far: slots, slots that began late, faults, recognitions.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use sdp3_core::radar::Event;

/// Counts of a run. Each is written by one context.
pub struct Run {
    slots: AtomicU32,
    late: AtomicU32,
    faults: AtomicU32,
    recognitions: AtomicU32,
    transferred: AtomicBool,
}

impl Run {
    /// Nothing yet.
    #[allow(clippy::new_without_default)] // for a static
    pub const fn new() -> Self {
        Run {
            slots: AtomicU32::new(0),
            late: AtomicU32::new(0),
            faults: AtomicU32::new(0),
            recognitions: AtomicU32::new(0),
            transferred: AtomicBool::new(false),
        }
    }

    /// The number of the slot that begins, from 0: for the slot interrupt.
    pub fn begin(&self) -> u32 {
        add(&self.slots)
    }

    /// A slot's samples are in its buffer.
    pub fn transfer(&self) {
        self.transferred.store(true, Relaxed);
    }

    /// Whether a transfer has ended since the last call.
    pub fn transferred(&self) -> bool {
        let ended = self.transferred.load(Relaxed);
        self.transferred.store(false, Relaxed);
        ended
    }

    /// The slot interrupt ended after the next slot had begun.
    pub fn late(&self) {
        add(&self.late);
    }

    /// Logs and counts an event: for the task.
    pub fn event(&self, event: &Event) {
        defmt::info!("{}", event);
        match event {
            Event::Fault(_) => add(&self.faults),
            Event::Classification { .. } => add(&self.recognitions),
            _ => 0,
        };
    }

    /// Slots, late ones, faults and recognitions so far.
    pub fn counts(&self) -> [u32; 4] {
        [&self.slots, &self.late, &self.faults, &self.recognitions].map(|count| count.load(Relaxed))
    }
}

/// Adds one by a load and a store, since not every processor adds in memory; returns what was there.
fn add(count: &AtomicU32) -> u32 {
    let before = count.load(Relaxed);
    count.store(before.wrapping_add(1), Relaxed);
    before
}
