//! Whether a recording comes from a given radar, and its slots.

use super::{Samples, Signal, doppler};
use crate::error::Invalid;
use crate::formats::slots::Slots;
use rustfft::num_complex::Complex64;
use sdp3_core::config::{RadarConfig, SampleFormat};
use std::borrow::Cow;

/// The radar that slots must come from.
#[derive(Debug, Clone, Copy)]
pub struct Expected {
    /// Owner of the radar, for errors: `the model's`.
    pub owner: &'static str,
    /// Its samples.
    pub radar: RadarConfig,
    /// Time from slot to slot in us.
    pub interval_us: f64,
    /// Carrier in Hz.
    pub carrier_hz: f64,
}

impl Expected {
    /// Share by which a recording's slot interval and carrier may differ.
    const INTERVAL: f64 = 0.01;
    const CARRIER: f64 = 0.05;

    /// The slots of a recording, if it comes from such a radar and has at least `least`. For a Doppler sensor they are made of its
    /// samples, which may have a higher rate.
    ///
    /// # Errors
    ///
    /// The first field that differs.
    pub fn slots<'s>(&self, signal: &'s Signal, least: usize) -> Result<Cow<'s, Slots>, Invalid> {
        let owner = self.owner;
        let ensure = |field, value: String, holds, legal: String| Invalid::unless(holds, field, value, legal);
        let near = |value: f64, of: f64, share: f64| (value - of).abs() <= share * of;
        let interval_us = 1e6 / signal.rate_hz;
        let doppler = self.radar.samples == 1;
        if let Samples::Slots(slots) = &signal.samples {
            let expected = self.radar.values_per_slot();
            ensure(
                "values a slot",
                slots.per_slot.to_string(),
                slots.per_slot == expected,
                format!("{expected}, {owner}"),
            )?;
            ensure(
                "slot interval (us)",
                interval_us.to_string(),
                near(interval_us, self.interval_us, Self::INTERVAL),
                format!("{}, {owner}, within a hundredth", self.interval_us),
            )?;
        } else if doppler {
            let slowest = 1e6 / self.interval_us;
            let legal = format!("at least {slowest}, {owner} rate of slots, within a hundredth");
            let fast = signal.rate_hz >= (1.0 - Self::INTERVAL) * slowest;
            ensure("rate (Hz)", signal.rate_hz.to_string(), fast, legal)?;
        }
        ensure(
            "carrier (Hz)",
            signal.carrier_hz.to_string(),
            near(signal.carrier_hz, self.carrier_hz, Self::CARRIER),
            format!("{}, {owner}, within 5 %", self.carrier_hz),
        )?;
        let slots = match (&signal.samples, self.radar.format) {
            (Samples::Slots(slots), _) => Cow::Borrowed(slots),
            (Samples::Real(x), SampleFormat::Real) if doppler => {
                Cow::Owned(self.sampled(x.iter().map(|&x| Complex64::new(x, 0.0)).collect(), signal.rate_hz))
            }
            (Samples::Complex(z), _) if doppler => Cow::Owned(self.sampled(z.clone(), signal.rate_hz)),
            _ => {
                let legal = if doppler { "I and Q of a Doppler sensor" } else { "raw slots of a radar" };
                return Err(Invalid::new("samples", &signal.about.axes, legal));
            }
        };
        let legal = format!("at least {least}, the longest window");
        ensure("slots", slots.len().to_string(), slots.len() >= least, legal)?;
        Ok(slots)
    }

    /// The slots of a Doppler sensor's samples.
    fn sampled(&self, samples: Vec<Complex64>, rate_hz: f64) -> Slots {
        doppler::slots(&doppler::coupled(samples, rate_hz, 1e6 / self.interval_us), self.radar.format)
    }
}
