//! Prove: the core against an independent reference, and the firmware against the core.
//!
//! [`mod@reference`] is every stage written again, plainly; [`suite`] the inputs; [`compare`] holds the core to the
//! reference value by value; [`digests`] holds other processors to the core, one number per stage; [`qemu`] runs them and
//! [`transcript`] reads what they print; [`locate`] finds the first value that differs; [`verification`] puts them together.

pub mod compare;
pub mod digests;
pub(crate) mod locate;
pub mod qemu;
pub mod reference;
pub mod suite;
pub mod transcript;
pub mod verification;
