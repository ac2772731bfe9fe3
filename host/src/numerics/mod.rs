//! Numerical methods that several modules use: random numbers, interpolation.

pub mod pchip;
pub mod random;
