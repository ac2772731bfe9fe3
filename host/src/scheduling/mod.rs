//! Simulation of the scheduler: one period of an operating point ([`playback`]), or thousands with traffic, fading, churn and loss
//! ([`campaign`]). The decisions are the core's.

pub(crate) mod campaign;
pub(crate) mod playback;
