//! What the boards share: the conformance suite that prints to a serial line, a recording that is played from flash, the counts of
//! a run; with the feature `async` the station as tasks, and its front ends.
#![no_std]

#[cfg(feature = "async")]
pub mod async_station;
#[cfg(feature = "async")]
pub mod bgt60;
pub mod cycles;
#[cfg(feature = "async")]
pub mod front_end;
pub mod interrupt_station;
pub mod line;
pub mod linked;
pub mod recording;
pub mod run;
#[cfg(feature = "async")]
pub mod slots;
#[cfg(feature = "async")]
pub mod spi;
pub mod station;
pub mod suite;
