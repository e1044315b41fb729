//! What tests compare with: twins of the kernels.

pub mod cpu;
