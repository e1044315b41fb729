//! Test support, with the feature `testing` only: CPU twins of the kernels, scenes that are hard for the methods, and
//! random numbers.

pub mod cpu;
pub mod suite;

/// Random numbers, the same on every machine.
pub mod random {
    pub use crate::random::{Random, pcg};
}
