//! Bits that one communication slot carries to a user.
//!
//! Eq. (R_k): T_s / T_o OFDM symbols of the water-filled rate; noise k T (B / M) F per sub-carrier. The largest modulation and the
//! transmitter's error vector magnitude limit the bits of a sub-carrier, if the scenario states them.

use super::OptimizerError;
use super::limited_water_filling::{Limits, allocate};
use crate::results::Link;
use crate::scenario::Scenario;
use crate::simulator::radar::KT;

/// The limits that a scenario states.
fn limits(scenario: &Scenario) -> Limits {
    let c = &scenario.communication;
    let error = c.evm_percent / 100.0;
    let modulation_bit = if c.modulation_bit == 0.0 { f64::INFINITY } else { c.modulation_bit };
    Limits { error: error * error, modulation_bit }
}

/// Signal-to-noise ratio of each sub-carrier if it had all the power.
fn ratios(scenario: &Scenario, gains: &[f64]) -> Vec<f64> {
    let c = &scenario.communication;
    let m = f64::from(c.used_subcarriers());
    let noise = KT * c.bandwidth_hz / m * libm::pow(10.0, c.noise_figure_db / 10.0);
    gains.iter().map(|g| g * c.power_w / noise).collect()
}

/// Bits of one slot over sub-carriers with power gains `|H_m|^2`, water-filled for these very gains.
pub fn slot_bit(scenario: &Scenario, gains: &[f64]) -> f64 {
    let symbol_bit = allocate(&ratios(scenario, gains), limits(scenario)).rate_bit;
    scenario.frame.slot_s / scenario.communication.symbol_s * symbol_bit
}

/// What a slot over these sub-carriers is made of.
pub fn link(scenario: &Scenario, gains: &[f64]) -> Link {
    let (ratios, limits) = (ratios(scenario, gains), limits(scenario));
    let found = allocate(&ratios, limits);
    let each = found.shares.iter().zip(&ratios).map(|(share, ratio)| limits.bits(share * ratio.max(0.0)));
    let full = each.filter(|bits| limits.full(*bits)).count();
    let subcarriers = gains.len().max(1) as f64;
    Link {
        subcarriers: gains.len() as u32,
        subcarrier_bit: found.rate_bit / subcarriers,
        full_share: limits.modulation_bit.is_finite().then(|| full as f64 / subcarriers),
        power_share: found.shares.iter().sum(),
    }
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

#[cfg(test)]
mod tests {
    use super::super::region::point;
    use super::super::theorem::Theorem;
    use super::*;
    use crate::results::{Curve, Parameters};

    fn limited(modulation_bit: f64, evm_percent: f64) -> Scenario {
        let mut scenario = Scenario::default();
        let c = &mut scenario.communication;
        (c.subcarriers, c.modulation_bit, c.evm_percent) = (0, modulation_bit, evm_percent);
        scenario
    }

    #[test]
    fn without_limits_a_slot_has_the_bits_it_always_had() {
        let scenario = crate::scenario::builtin::named("as-printed".as_ref()).unwrap().scenario();
        let gains: Vec<f64> = (0..64).map(|m| 1e-5 / (1.0 + 0.1 * f64::from(m))).collect();
        let noise = KT * 10e6 / 64.0 * libm::pow(10.0, 1.0);
        let gamma: Vec<f64> = gains.iter().map(|g| g * 1.0 / noise).collect();
        let expected = 250e-6 / 50e-6 * crate::optimizer::water_filling::allocate(&gamma).rate_bit;
        assert_eq!(slot_bit(&scenario, &gains).to_bits(), expected.to_bits());
    }

    #[test]
    fn the_largest_modulation_limits_a_slot() {
        let gains = vec![1e-5; 467];
        let full = limited(8.0, 3.5);
        // five symbols of 467 sub-carriers with 8 bit
        assert!((slot_bit(&full, &gains) - 18_680.0).abs() < 1e-6);
        let found = link(&full, &gains);
        assert_eq!((found.subcarriers, found.full_share), (467, Some(1.0)));
        assert!((found.subcarrier_bit - 8.0).abs() < 1e-12 && found.power_share < 1.0, "{found:?}");
        let free = link(&limited(0.0, 0.0), &gains);
        assert!(
            free.subcarrier_bit > 20.0 && free.full_share.is_none() && (free.power_share - 1.0).abs() < 1e-9
        );
        // an error vector magnitude of 3.5 % alone: less than log2(1 + 1 / 0.035^2)
        let rough = link(&limited(0.0, 3.5), &gains).subcarrier_bit;
        assert!(rough < 9.68 && rough > 9.6, "{rough}");
    }

    #[test]
    fn theorem_1_holds_for_limited_rates() {
        let mut scenario = limited(4.0, 17.5);
        scenario.communication.power_w = 1e-5;
        let users: Vec<Vec<f64>> = [1e-5, 1e-6, 2e-7]
            .iter()
            .map(|g| (0..467).map(|m| g * (1.0 + libm::sin(0.05 * f64::from(m)))).collect())
            .collect();
        let bits = slot_bits(&scenario, &users).unwrap();
        assert!(bits[0] > 1.1 * bits[1] && bits[1] > 1.1 * bits[2], "{bits:?}");
        let parameters = Parameters { alpha: 61906.0, beta: 2.4297, gamma: Some(0.9499), epsilon: None };
        let curve = Curve { model: "pow3".into(), parameters, rmse: 0.0 };
        let theorem = Theorem::new(4000, &bits);
        for sensing in [200, 500, 900] {
            let exact = theorem.throughput_bit(f64::from(sensing));
            let found = point(4000, &curve, &bits, sensing).throughput_bit;
            assert!(
                found <= exact * (1.0 + 1e-12) && found >= exact * (1.0 - 2.0 / 3100.0),
                "{found} {exact}"
            );
        }
    }
}
