//! Simulate: a person in a room, seen by a radar, as raw 16-bit slots.
//!
//! [`body`] moves (Boulic-Thalmann gait, sixteen ellipsoids), [`channel`] carries (target echoes of eq. (uit), the room's
//! AR(1) response of eq. (vit)), [`radar`] sends the chirp, adds noise and converts, [`dataset`] makes a recording of it
//! from its coordinates alone, [`targets`] are its person as points for other simulators, and [`calibration`] finds the channel
//! correlation rho that a measured signal shows. [`validity`] says before anything is simulated what cannot be, and what aliases.
//!
//! Floating-point functions are `libm`'s throughout: the same seed gives the same bytes on every machine.

pub mod body;
pub mod calibration;
pub(crate) mod channel;
pub(crate) mod clutter_to_target;
pub mod dataset;
#[cfg(test)]
mod physics;
pub(crate) mod radar;
pub(crate) mod randomised;
pub mod targets;
pub mod validity;
