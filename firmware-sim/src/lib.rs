//! Firmware support: semihosting, start-up and the conformance program (see `firmware-sim/build`).
#![no_std]
