//! Firmware support: start-up, semihosting and logging for emulated Cortex-M and RISC-V machines.
//!
//! [`rt`] is the one module with unsafe code and assembly; [`semihosting`] is its safe face: files, text, arguments and
//! the exit code of the emulator. [`log`] carries defmt frames to a file.
#![cfg_attr(target_os = "none", no_std)]

#[cfg(all(feature = "target", target_os = "none"))]
pub mod log;
#[cfg(target_os = "none")]
pub mod rt;
#[cfg(target_os = "none")]
pub mod semihosting;
