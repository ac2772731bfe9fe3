//! N_m as a variable: what a wider spacing of the sensing slots allows and forbids.
//!
//! N_s (N_m + 1) <= N bounds N_s, the pulse repetition interval (N_m + 1) T_s bounds the speed that is not aliased,
//! lambda / (4 (N_m + 1) T_s), and N_s intervals are what the radar sees of the motion. The curve A(N_s) is that of the spacing it
//! was learnt with; the others' rows say what the constraint alone does.

use super::operating_point::{Rule, choose};
use super::region::{point, range};
use crate::results::{Curve, Spacing};
use crate::scenario::{SPEED_OF_LIGHT, Scenario};

/// A row for every N_m from 0 to the widest that lets the shortest recording fit.
pub fn spacings(scenario: &Scenario, curve: &Curve, slot_bits: &[f64], rule: Rule) -> Vec<Spacing> {
    let f = &scenario.frame;
    let wavelength = SPEED_OF_LIGHT / scenario.radar.carrier_hz;
    let widest = (f.period_slots / scenario.least_sensing_slots()).saturating_sub(1);
    let rows = (0..=widest).filter_map(|spacing_slots| {
        let (least, most) = range(scenario, spacing_slots).ok()?;
        let interval_s = f.slot_s * f64::from(spacing_slots + 1);
        let points: Vec<_> = (least..=most).map(|n| point(f.period_slots, curve, slot_bits, n)).collect();
        let chosen = choose(&points, rule).map(|index| &points[index]);
        Some(Spacing {
            spacing_slots,
            most_sensing_slots: most,
            unambiguous_m_s: wavelength / (4.0 * interval_s),
            learnt: spacing_slots == f.spacing_slots,
            sensing_slots: chosen.map(|p| p.sensing_slots),
            accuracy: chosen.map(|p| p.accuracy),
            throughput_bit: chosen.map(|p| p.throughput_bit),
            observation_s: chosen.map(|p| interval_s * f64::from(p.sensing_slots)),
        })
    });
    rows.collect()
}
