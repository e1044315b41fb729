//! Shared parts of the benchmarks: scenes, interleaved rounds, provenance of the figures, charts and files.
#![allow(dead_code, unreachable_pub, reason = "each benchmark uses its own part of this")]

pub mod chart;
pub mod exit;
pub mod files;
pub mod flicker;
pub mod looks;
pub mod measure;
pub mod options;
pub mod provenance;
pub mod records;
pub mod rounds;
pub mod sampled;
pub mod scenes;
pub mod text;
