//! What the boards share: the conformance suite that prints to a serial line, a recording that is played from flash, the counts of
//! a run.
#![no_std]

pub mod line;
pub mod linked;
pub mod recording;
pub mod run;
pub mod station;
pub mod suite;
