//! The command line, and the plan that it makes.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};

/// Pixels a side of the paper's pictures.
pub(crate) const PAPER_SIDE: u32 = 512;

/// Sets the figures of Adelson and Hodges 1993, "Stereoscopic ray-tracing", beside ours.
#[derive(Parser, Debug)]
#[command(name = "cargo bench -p stereotrace-studies --bench adelson-hodges --")]
pub(crate) struct Options {
    /// A quick look, not for figures: 64x64, one random scene, into target/bench-smoke/adelson-hodges
    #[arg(long)]
    smoke: bool,
    /// What is measured [default: all]
    #[arg(long, value_name = "A,B", value_delimiter = ',', value_enum)]
    parts: Vec<Part>,
    /// Where the results go [default: target/bench/adelson-hodges]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Cargo says so when it benchmarks; without it this is a test, hence a quick look
    #[arg(long, hide = true)]
    bench: bool,
}

/// A part of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Part {
    /// Random scenes at one ray a pixel
    Random,
    /// Several rays a pixel
    Samples,
    /// Nine rays with aiming rays
    Nine,
    /// Adaptive samples
    Adaptive,
    /// Time
    Times,
    /// Worst cases, scenes in which the method fails, table 4
    Worst,
}

/// What is measured.
pub(crate) struct Plan {
    pub(crate) parts: Vec<Part>,
    /// Pixels a side.
    pub(crate) side: u32,
    /// Distances between the eyes: a fortieth of the width, as the paper describes its renderer, and what its left
    /// edge of 11,520 pixels in 512 rows amounts to.
    pub(crate) e_px: [f32; 2],
    /// Lights; its "single shadow ray" makes it one, the built-in scenes have five.
    pub(crate) lights: Vec<usize>,
    /// Random scenes of 20 objects; the paper has 30.
    pub(crate) seeds: u32,
    /// Roots of numbers of samples a pixel.
    pub(crate) grids: Vec<u32>,
    /// Rounds that are timed.
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

    /// Where the results go.
    pub(crate) fn folder(&self) -> PathBuf {
        let target = crate::common::files::root().join("target");
        let standard = target.join(if self.quick() { "bench-smoke/adelson-hodges" } else { "bench/adelson-hodges" });
        self.out.clone().unwrap_or(standard)
    }

    fn quick(&self) -> bool {
        self.smoke || !self.bench
    }
}
