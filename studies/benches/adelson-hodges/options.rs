//! Parses the command line, and makes the plan of the benchmark from it.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};

/// Width and height of the paper's pictures in pixels.
pub(crate) const PAPER_SIDE: u32 = 512;

/// Compares the figures of Adelson and Hodges 1993, "Stereoscopic ray-tracing", with this library's.
#[derive(Parser, Debug)]
#[command(name = "cargo bench -p stereotrace-studies --bench adelson-hodges --")]
pub(crate) struct Options {
    /// Smoke run with meaningless figures: 64x64, one random scene, into target/bench-smoke/adelson-hodges
    #[arg(long)]
    smoke: bool,
    /// Parts to measure [default: all]
    #[arg(long, value_name = "A,B", value_delimiter = ',', value_enum)]
    parts: Vec<Part>,
    /// Folder for the results [default: target/bench/adelson-hodges]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Passed by cargo when it benchmarks; without it this is a smoke run
    #[arg(long, hide = true)]
    bench: bool,
}

/// A part of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Part {
    /// Random scenes with one ray per pixel
    Random,
    /// Several rays per pixel
    Samples,
    /// Nine rays with aiming rays
    Nine,
    /// Adaptive samples
    Adaptive,
    /// Time
    Times,
    /// Worst cases, scenes in which the method fails, and table 4
    Worst,
}

/// Settings of the benchmark.
pub(crate) struct Plan {
    pub(crate) parts: Vec<Part>,
    /// Width and height of the pictures in pixels.
    pub(crate) side: u32,
    /// Interaxials in pixels. The first is a fortieth of the width, as the paper describes its renderer. The second
    /// follows from the left edges in the paper, which have 11,520 pixels in 512 rows.
    pub(crate) e_px: [f32; 2],
    /// Numbers of lights. The paper's "single shadow ray" implies one; the built-in scenes have five.
    pub(crate) lights: Vec<usize>,
    /// Number of random scenes with 20 objects; the paper has 30.
    pub(crate) seeds: u32,
    /// Square roots of the numbers of samples per pixel.
    pub(crate) grids: Vec<u32>,
    /// Number of timed rounds.
    pub(crate) rounds: usize,
    pub(crate) smoke: bool,
}

impl Options {
    pub(crate) fn plan(&self) -> Plan {
        let smoke = self.quick();
        let side = if smoke { 64 } else { PAPER_SIDE };
        let parts = if self.parts.is_empty() { Part::value_variants() } else { &self.parts };
        Plan {
            parts: parts.to_vec(),
            side,
            e_px: [12.8, 22.5].map(|e_px| e_px * side as f32 / PAPER_SIDE as f32),
            lights: if smoke { vec![5] } else { vec![1, 5] },
            seeds: if smoke { 1 } else { 30 },
            grids: if smoke { vec![1, 3] } else { vec![1, 3, 5] },
            rounds: if smoke { 1 } else { 9 },
            smoke,
        }
    }

    /// Returns the folder for the results.
    pub(crate) fn folder(&self) -> PathBuf {
        let target = crate::common::files::root().join("target");
        let standard = target.join(if self.quick() { "bench-smoke/adelson-hodges" } else { "bench/adelson-hodges" });
        self.out.clone().unwrap_or(standard)
    }

    fn quick(&self) -> bool {
        self.smoke || !self.bench
    }
}
