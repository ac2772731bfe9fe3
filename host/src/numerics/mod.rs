//! Numerical methods that several modules use: random numbers, interpolation, a special function.

pub(crate) mod bessel;
pub(crate) mod differentiation;
pub(crate) mod filter;
pub(crate) mod pchip;
pub mod random;
