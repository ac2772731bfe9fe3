//! Firmware support: start-up, semihosting and logging for emulated Cortex-M, RISC-V and AArch64 machines.
//!
//! [`rt`] has the assembly and most unsafe code; [`semihosting`] is the safe interface to it: files, text, arguments and the exit
//! code of the emulator; `fault` ends what went wrong. [`log`] carries defmt frames to a file. [`station`] is the board on which the
//! program of `porting.rs` runs.
#![cfg_attr(target_os = "none", no_std)]

#[cfg(target_os = "none")]
mod fault;
#[cfg(all(feature = "graph", target_os = "none"))]
pub mod graph_files;
#[cfg(all(feature = "target", target_os = "none"))]
pub mod log;
#[cfg(target_os = "none")]
pub mod rt;
#[cfg(target_os = "none")]
pub mod semihosting;
#[cfg(target_os = "none")]
pub mod static_cell;
#[cfg(all(feature = "target", target_os = "none"))]
pub mod station;
