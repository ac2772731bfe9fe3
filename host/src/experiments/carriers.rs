//! The paper's carriers, and a scenario at each with the paper's numbers of sensing slots.

use crate::scenario::Scenario;

/// The paper's carriers in Hz.
pub const CARRIERS_HZ: [f64; 2] = [3.5e9, 60e9];

/// A scenario at a carrier; at 60 GHz sensing slots follow one another, and rows hold four bins.
pub fn at_carrier(base: &Scenario, carrier_hz: f64) -> Scenario {
    let mut found = base.clone();
    found.radar.carrier_hz = carrier_hz;
    if carrier_hz > 30e9 {
        found.frame.spacing_slots = 0;
        found.spectrogram.bins_per_row = 4;
    }
    found
}
