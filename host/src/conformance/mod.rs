//! Prove: the core against an independent reference, and the firmware against the core.
//!
//! [`reference`] is every stage written again, plainly; [`suite`] the inputs; [`compare`] holds the core to the
//! reference value by value; [`digests`] holds other processors to the core, one number per stage; [`qemu`] runs them.

pub mod compare;
pub mod digests;
pub mod qemu;
pub mod reference;
pub mod suite;
