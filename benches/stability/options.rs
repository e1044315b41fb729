//! Parses the command line, and makes the plan of the benchmark from it.

use std::path::PathBuf;

use clap::Parser;
use stereotrace::{Method, testing::suite::Trial};

use crate::common::options::size;

/// Tests the methods on hard scenes and on a film.
#[derive(Parser, Debug)]
#[command(name = "cargo bench --bench stability --")]
pub(crate) struct Options {
    /// Smoke run with meaningless figures: 48x48, three trials, four frames, into target/bench-smoke/stability
    #[arg(long)]
    smoke: bool,
    /// Picture size in pixels; the interaxial is proportional to its width [default: 300x300]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Trials [default: all]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    trials: Vec<Trial>,
    /// Methods [default: all named ones except naive, which is the reference, and ideal]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    methods: Vec<Method>,
    /// Number of frames in one turn of the film's spheres [default: 60]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    frames: Option<u32>,
    /// Use trials with mirrors and spherical lights, and 4 samples per pixel
    #[arg(long)]
    rich: bool,
    /// Folder for the results [default: target/bench/stability]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Passed by cargo when it benchmarks; without it this is a smoke run
    #[arg(long, hide = true)]
    bench: bool,
}

/// Settings of the benchmark.
pub(crate) struct Plan {
    pub(crate) size: [u32; 2],
    pub(crate) trials: Vec<Trial>,
    pub(crate) methods: Vec<Method>,
    pub(crate) frames: u32,
    /// Whether trials have expensive materials, lights and samples.
    pub(crate) rich: bool,
}

impl Options {
    pub(crate) fn plan(&self) -> Plan {
        let quick = self.quick();
        let trials = match self.trials.as_slice() {
            [] if quick => vec![Trial::Hidden, Trial::Wires, Trial::HalfWidth],
            [] => Trial::ALL.into(),
            named => named.into(),
        };
        let compared = |method: &Method| !matches!(method, Method::Naive | Method::Ideal);
        let methods = match self.methods.as_slice() {
            [] => Method::ALL.iter().copied().filter(compared).collect(),
            named => named.into(),
        };
        Plan {
            size: self.size.unwrap_or(if quick { [48, 48] } else { [300, 300] }),
            trials,
            methods,
            frames: self.frames.unwrap_or(if quick { 4 } else { 60 }),
            rich: self.rich,
        }
    }

    /// Returns the folder for the results.
    pub(crate) fn folder(&self) -> PathBuf {
        let target = crate::common::files::root().join("target");
        let standard = target.join(if self.quick() { "bench-smoke/stability" } else { "bench/stability" });
        self.out.clone().unwrap_or(standard)
    }

    fn quick(&self) -> bool {
        self.smoke || !self.bench
    }
}
