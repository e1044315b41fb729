//! Parses the command line, and makes the plan of the benchmark from it.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use stereotrace::scene::builtin::StackedKind;

/// Width and height of the pictures in pixels. The paper does not state its own.
const SIDE: u32 = 512;

/// Compares the figures of Raghuvanshi and Dhande, "Raytraced rendering using t-buffer and shadow-buffer", with this
/// library's.
#[derive(Parser, Debug)]
#[command(name = "cargo bench -p stereotrace-studies --bench reality --")]
pub(crate) struct Options {
    /// Smoke run with meaningless figures: 32x32, up to 50 objects, into target/bench-smoke/reality
    #[arg(long)]
    smoke: bool,
    /// Parts to measure [default: all]
    #[arg(long, value_name = "A,B", value_delimiter = ',', value_enum)]
    parts: Vec<Part>,
    /// Only count, without timing
    #[arg(long)]
    counts: bool,
    /// Stack triangles in place of spheres
    #[arg(long)]
    triangles: bool,
    /// Number of timed rounds [default: 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), conflicts_with = "counts")]
    rounds: Option<u32>,
    /// Folder for the results [default: target/bench/reality]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Passed by cargo when it benchmarks; without it this is a smoke run
    #[arg(long, hide = true)]
    bench: bool,
}

/// A group of the paper's figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Part {
    /// Figures 9 to 12: three spheres on a ground, and stacks
    Pictures,
    /// Figures 13 to 16: gain against the number of objects
    Gains,
    /// Figure 17: time against the shadow-buffer's resolution
    Resolution,
    /// Figure 18: shadows against the shadow-buffer's resolution
    Quality,
}

/// Settings of the benchmark.
pub(crate) struct Plan {
    pub(crate) parts: Vec<Part>,
    /// Width and height of the pictures in pixels.
    pub(crate) side: u32,
    pub(crate) kind: StackedKind,
    /// Numbers of stacked objects in figures 13 to 16.
    pub(crate) objects: Vec<usize>,
    /// Rows of the shadow-buffers in figures 15 and 16.
    pub(crate) gain_rows: [u32; 2],
    /// Rows of the shadow-buffers in figures 17 and 18.
    pub(crate) time_rows: Vec<u32>,
    pub(crate) quality_rows: Vec<u32>,
    /// Number of objects in figures 17 and 18.
    pub(crate) fixed_objects: usize,
    /// Number of timed rounds; 0 for counts alone.
    pub(crate) rounds: usize,
}

impl Options {
    pub(crate) fn plan(&self) -> Plan {
        let smoke = self.quick();
        let parts = if self.parts.is_empty() { Part::value_variants() } else { &self.parts };
        let rounds = self.rounds.map_or(if smoke { 1 } else { 5 }, |rounds| rounds as usize);
        let choose = |quick: &[u32], full: &[u32]| if smoke { quick.to_vec() } else { full.to_vec() };
        let objects = choose(&[3, 10, 50], &[10, 50, 100, 200, 500, 1000, 2000, 3000, 4000, 5000, 6000]);
        Plan {
            parts: parts.to_vec(),
            side: if smoke { 32 } else { SIDE },
            kind: if self.triangles { StackedKind::Triangles } else { StackedKind::Spheres },
            objects: objects.into_iter().map(|count| count as usize).collect(),
            gain_rows: if smoke { [16, 32] } else { [400, 1000] },
            time_rows: choose(&[8, 16, 24, 32], &[200, 400, 600, 800, 1000, 1200, 1400, 1600, 1800, 2000]),
            quality_rows: choose(&[16, 32], &[400, 800, 1200, 1600, 2000]),
            fixed_objects: if smoke { 20 } else { 500 },
            rounds: if self.counts { 0 } else { rounds },
        }
    }

    /// Returns the folder for the results.
    pub(crate) fn folder(&self) -> PathBuf {
        let target = crate::common::files::root().join("target");
        let standard = target.join(if self.quick() { "bench-smoke/reality" } else { "bench/reality" });
        self.out.clone().unwrap_or(standard)
    }

    fn quick(&self) -> bool {
        self.smoke || !self.bench
    }
}
