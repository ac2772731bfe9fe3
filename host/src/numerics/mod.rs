//! Numerical methods that several modules use: random numbers, interpolation, special functions.

pub(crate) mod atan;
pub(crate) mod bessel;
pub(crate) mod bisection;
pub(crate) mod differentiation;
pub(crate) mod exp;
pub(crate) mod filter;
pub(crate) mod fresnel;
pub(crate) mod pchip;
pub mod random;
pub(crate) mod resample;
pub(crate) mod sincos;
pub(crate) mod vectors;
pub(crate) mod xoshiro;
pub(crate) mod ziggurat;
