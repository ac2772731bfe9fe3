//! Bits that flip, and what the observer gets to know of them.

use super::super::observer::{Copies, MODEL_FAULT};
use super::Environment;
use crate::{flip, flip_bit};
use core::ops::Range;
use sdp3_core::areas::Area;
use sdp3_core::supervision::retained::Retained;

impl<const VALUES: usize> Environment<VALUES> {
    /// Changes a word of retained copies at any tick: its number in each, and the bits that are inverted.
    pub fn damage(&mut self, copies: Copies, change: (u32, u32)) {
        self.wait();
        self.flip_retained(copies, change);
        self.observer.damaged = Some(copies);
    }

    pub(super) fn flip_retained(&self, copies: Copies, (at, mask): (u32, u32)) {
        let words = Retained::LEN / 2;
        // the first half is written with even numbers
        let (newest, at) = (words * (self.observer.saves % 2) as usize, at as usize % words);
        if copies != Copies::Older {
            flip(self.retained, newest + at, mask);
        }
        if copies != Copies::Newest {
            flip(self.retained, words - newest + at, mask);
        }
    }

    /// Flips a bit of the plan that waits for its period; false if there is none.
    pub fn flip_plan(&mut self, bit: u32) -> bool {
        if self.observer.plan_begun || self.observer.plan.is_none() {
            return false;
        }
        let plan = self.contexts.0.waiting_plan();
        let Range { start, end } = plan.map_or(&[][..], core::slice::from_ref).as_ptr_range();
        self.observer.plan_damaged = true;
        flip_bit(&(start.cast()..end.cast()), bit)
    }

    /// Flips a bit of an area, in the observer's copy of a message as well; false if there is nothing at this moment.
    pub fn flip_area(&mut self, area: Area, bit: u32) -> bool {
        if let (Area::WaitingSlot(number), Some(slot)) = (area, self.observer.filled.front_mut()) {
            let numbers = slot.numbers.iter_mut().skip(number.into()).take(1);
            numbers.for_each(|number| *number ^= 1 << (bit % 32));
        }
        flip_bit(&self.contexts.1.area(area), bit)
    }

    /// Flips a bit of a model in memory, or back; the first must be reported.
    pub fn flip_model(&mut self, number: usize, bytes: &'static [u8], bit: u32, back: bool) {
        flip_bit(&bytes.as_ptr_range(), bit);
        self.observer.damage_model(number);
        let full = !back && self.expected.push(MODEL_FAULT).is_err();
        self.invariant(!full);
    }
}
