//! The radar module under a clock: a timer interrupt every slot, the slot context in it, processing in the idle loop.
//!
//! Arguments: `slots=N slot=INSTRUCTIONS seed=S [exits=1|2] [faults=0|1]`. One exit is the model for N_s = 1000, two begin with the
//! one for N_s = 200. Rates, users, layout and threshold change by seeded draws, and faults are injected at seeded slots; the program
//! checks every report of a fault against the injected ones. The interrupt copies a sensing slot's samples into
//! its buffer, which stands for a DMA: its instructions are not the slot context's. The transfer ends just before the next slot
//! begins, as late as it may.
//!
//! Prints `name value` lines. Exit code 0 if nothing was late, lost, missed or reported wrongly, 1 if something was, 2 for misuse.
//! When a recognition is done depends on the clock, and with it an early exit's end of sensing: so does the digest with two exits.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware;
#[cfg(target_os = "none")]
mod injection;
#[cfg(target_os = "none")]
mod radio;
#[cfg(target_os = "none")]
mod reports;
#[cfg(target_os = "none")]
mod shared;
