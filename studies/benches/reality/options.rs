//! The command line, and the plan that it makes.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use stereotrace::scene::builtin::StackedKind;

/// Pixels a side of the pictures; the paper does not say how many its own had.
const SIDE: u32 = 512;

/// Sets the figures of Raghuvanshi and Dhande, "Raytraced rendering using t-buffer and shadow-buffer", beside ours.
#[derive(Parser, Debug)]
#[command(name = "cargo bench -p stereotrace-studies --bench reality --")]
pub(crate) struct Options {
    /// A quick look, not for figures: 32x32, up to 50 objects, into target/bench-smoke/reality
    #[arg(long)]
    smoke: bool,
    /// What is measured [default: all]
    #[arg(long, value_name = "A,B", value_delimiter = ',', value_enum)]
    parts: Vec<Part>,
    /// Counts alone, no times
    #[arg(long)]
    counts: bool,
    /// Stacks of triangles in place of spheres
    #[arg(long)]
    triangles: bool,
    /// Rounds that are timed [default: 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), conflicts_with = "counts")]
    rounds: Option<u32>,
    /// Where the results go [default: target/bench/reality]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Cargo says so when it benchmarks; without it this is a test, hence a quick look
    #[arg(long, hide = true)]
    bench: bool,
}

/// Figures of the paper that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Part {
    /// Figures 9 to 12: three spheres on a ground, stacks
    Pictures,
    /// Figures 13 to 16: gain over the number of objects
    Gains,
    /// Figure 17: time over the shadow-buffer's resolution
    Resolution,
    /// Figure 18: shadows over the shadow-buffer's resolution
    Quality,
}

/// What is measured.
pub(crate) struct Plan {
    pub(crate) parts: Vec<Part>,
    /// Pixels a side.
    pub(crate) side: u32,
    pub(crate) kind: StackedKind,
    /// How many objects are stacked, figures 13 to 16.
    pub(crate) objects: Vec<usize>,
    /// Rows of the shadow-buffers of figures 15 and 16.
    pub(crate) gain_rows: [u32; 2],
    /// And of figures 17 and 18.
    pub(crate) time_rows: Vec<u32>,
    pub(crate) quality_rows: Vec<u32>,
    /// Objects of figures 17 and 18.
    pub(crate) fixed_objects: usize,
    /// Rounds that are timed; 0 for counts alone.
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

    /// Where the results go.
    pub(crate) fn folder(&self) -> PathBuf {
        let target = crate::common::files::root().join("target");
        let standard = target.join(if self.quick() { "bench-smoke/reality" } else { "bench/reality" });
        self.out.clone().unwrap_or(standard)
    }

    fn quick(&self) -> bool {
        self.smoke || !self.bench
    }
}
