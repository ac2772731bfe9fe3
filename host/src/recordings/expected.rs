//! Whether slots come from a given radar.

use super::{Samples, Signal};
use crate::error::Invalid;
use crate::formats::slots::Slots;

/// The radar that slots must come from.
#[derive(Debug, Clone, Copy)]
pub struct Expected {
    /// Owner of the radar, for errors: `the model's`.
    pub owner: &'static str,
    /// Values of a slot.
    pub per_slot: usize,
    /// Time from slot to slot in us.
    pub interval_us: f64,
    /// Carrier in Hz.
    pub carrier_hz: f64,
}

impl Expected {
    /// Share by which a recording's slot interval and carrier may differ.
    const INTERVAL: f64 = 0.01;
    const CARRIER: f64 = 0.05;

    /// The slots of a recording, if they come from such a radar and are at least `least`.
    ///
    /// # Errors
    ///
    /// The first field that differs.
    pub fn slots<'s>(&self, signal: &'s Signal, least: usize) -> Result<&'s Slots, Invalid> {
        let owner = self.owner;
        let Samples::Slots(slots) = &signal.samples else {
            return Err(Invalid::new("samples", &signal.about.axes, "raw slots of a radar"));
        };
        let ensure = |field, value: String, holds, legal: String| Invalid::unless(holds, field, value, legal);
        let near = |value: f64, of: f64, share: f64| (value - of).abs() <= share * of;
        let interval_us = 1e6 / signal.rate_hz;
        ensure(
            "values a slot",
            slots.per_slot.to_string(),
            slots.per_slot == self.per_slot,
            format!("{}, {owner}", self.per_slot),
        )?;
        ensure(
            "slot interval (us)",
            interval_us.to_string(),
            near(interval_us, self.interval_us, Self::INTERVAL),
            format!("{}, {owner}, within a hundredth", self.interval_us),
        )?;
        ensure(
            "carrier (Hz)",
            signal.carrier_hz.to_string(),
            near(signal.carrier_hz, self.carrier_hz, Self::CARRIER),
            format!("{}, {owner}, within 5 %", self.carrier_hz),
        )?;
        let legal = format!("at least {least}, the longest window");
        ensure("slots", slots.len().to_string(), slots.len() >= least, legal)?;
        Ok(slots)
    }
}
