//! What the benchmarks share: scenes, repeats in turn, where and when figures were taken.
#![allow(dead_code, unreachable_pub, reason = "each benchmark uses its own part of this")]

pub mod chart;
pub mod exit;
pub mod files;
pub mod looks;
pub mod measure;
pub mod options;
pub mod provenance;
pub mod records;
pub mod rounds;
pub mod scenes;
pub mod text;
