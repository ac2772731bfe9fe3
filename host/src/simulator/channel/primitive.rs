//! `primitive`: the primitive-based channel of deterministic sensing simulators.
//!
//! The hybrid channel with rho = 1: the room's response is drawn once and never changes.

use super::dahc::Dahc;
use crate::numerics::random::Random;
use crate::scenario::Scenario;
use crate::simulator::body::Vec3;

/// The model between two points.
pub fn model(scenario: &Scenario, ends: (Vec3, Vec3), random: Random) -> Dahc {
    Dahc::new(scenario, ends, 1.0, random)
}
