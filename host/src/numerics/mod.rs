//! Numerical methods that several modules use: random numbers, interpolation, a special function.

pub mod bessel;
pub mod filter;
pub mod pchip;
pub mod random;
