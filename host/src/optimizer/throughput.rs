//! Bits that one communication slot carries to a receiver.
//!
//! Eq. (R_k): T_s / T_o OFDM symbols of the water-filled rate; noise k T (B / M) F per sub-carrier.

use super::OptimizerError;
use super::water_filling::allocate;
use crate::scenario::Scenario;
use crate::simulator::radar::{KT, SAMPLE_RATE};

/// Bits per slot of each receiver from its sub-carriers' `E |H_m|^2`.
///
/// # Errors
///
/// [`OptimizerError::Gain`] for a receiver that hears nothing.
pub fn slot_bits(scenario: &Scenario, gains: &[Vec<f64>]) -> Result<Vec<f64>, OptimizerError> {
    let c = &scenario.communication;
    let noise = KT * SAMPLE_RATE / f64::from(c.subcarriers) * libm::pow(10.0, c.noise_figure_db / 10.0);
    gains
        .iter()
        .enumerate()
        .map(|(receiver, gains)| {
            let gamma: Vec<f64> = gains.iter().map(|g| g * c.power_w / noise).collect();
            let bits = scenario.frame.slot_s / c.symbol_s * allocate(&gamma).rate_bit;
            if bits.is_finite() && bits > 0.0 {
                Ok(bits)
            } else {
                Err(OptimizerError::Gain { receiver, bits })
            }
        })
        .collect()
}
