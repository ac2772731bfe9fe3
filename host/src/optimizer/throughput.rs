//! Bits that one communication slot carries to a user.
//!
//! Eq. (R_k): T_s / T_o OFDM symbols of the water-filled rate; noise k T (B / M) F per sub-carrier.

use super::OptimizerError;
use super::water_filling::allocate;
use crate::scenario::Scenario;
use crate::simulator::radar::KT;

/// Bits of one slot over sub-carriers with power gains `|H_m|^2`, water-filled for these very gains.
pub fn slot_bit(scenario: &Scenario, gains: &[f64]) -> f64 {
    let c = &scenario.communication;
    let noise = KT * c.bandwidth_hz / f64::from(c.subcarriers) * libm::pow(10.0, c.noise_figure_db / 10.0);
    let gamma: Vec<f64> = gains.iter().map(|g| g * c.power_w / noise).collect();
    scenario.frame.slot_s / c.symbol_s * allocate(&gamma).rate_bit
}

/// Bits per slot of each user at its sub-carriers' expected gains `E |H_m|^2`, `[user][subcarrier]`: the paper's
/// approximation, which knows the channel by its mean alone.
///
/// # Errors
///
/// [`OptimizerError::Gain`] for a user without gain.
pub fn slot_bits(scenario: &Scenario, gains: &[Vec<f64>]) -> Result<Vec<f64>, OptimizerError> {
    gains
        .iter()
        .enumerate()
        .map(|(user, gains)| {
            let bits = slot_bit(scenario, gains);
            if bits.is_finite() && bits > 0.0 { Ok(bits) } else { Err(OptimizerError::Gain { user, bits }) }
        })
        .collect()
}

/// Expected bits per slot over fading: the mean over draws `|H_m|^2`, `[draw][subcarrier]`, each water-filled for itself.
pub fn over_fading(scenario: &Scenario, draws: &[Vec<f64>]) -> f64 {
    draws.iter().map(|gains| slot_bit(scenario, gains)).sum::<f64>() / draws.len().max(1) as f64
}
