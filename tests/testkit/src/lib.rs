//! What the tests of the core, the tests of the host and the firmware share: models, signals, fault injection.
#![no_std]

pub mod campaign;
pub mod churn;
pub mod models;
pub mod random_model;
pub mod signals;
