//! Twins of the kernels, and random numbers.

pub mod cpu;
pub(crate) mod random;
