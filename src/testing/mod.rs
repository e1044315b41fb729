//! What tests compare with, and what they are tried on. It ships with the feature `testing` only: twins of the kernels,
//! scenes that are hard on methods, and random numbers.

pub mod cpu;
pub mod suite;

/// Random numbers, the same on every machine.
pub mod random {
    pub use crate::random::{Random, pcg};
}
