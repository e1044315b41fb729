//! The command line, and the plan that it makes.

use std::path::PathBuf;

use clap::Parser;
use stereotrace::Method;

use crate::common::{measure::Plan, options::size};

/// The scenes of the table: built-in ones, and what is worth having of the files.
const SCENES: [&str; 8] = ["spheres", "hall", "fence", "hidden", "near", "grazing", "sponza_4x", "dragon"];

/// Compares the methods in time, accuracy and counted work.
#[derive(Parser, Debug)]
#[command(name = "cargo bench --bench stereo --")]
pub(crate) struct Options {
    /// A quick look, not for figures: 128x128, two rounds, two built-in scenes, into target/bench-smoke
    #[arg(long)]
    smoke: bool,
    /// Picture size in pixels [default: 600x600]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Distance between the eyes in pixels [default: 15 of 600]
    #[arg(long, value_name = "PX")]
    e: Option<f32>,
    /// Place this many lights by the library's rule [default: built-in scenes keep their own five, files get five]
    #[arg(long, value_name = "N")]
    lights: Option<usize>,
    /// Rounds that are timed, after two to warm up [default: 7]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,
    /// Scenes: built-in ones, folders of OBJ files, or paths of .obj, .gltf, .glb or .ply files [default: six built-in
    /// ones, `sponza_4x`, dragon]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    scenes: Vec<String>,
    /// Methods; naive and ideal are always among them [default: atomic, es-isler, bracket, verified]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    methods: Vec<Method>,
    /// Where the results go [default: target/bench/stereo]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Cargo says so when it benchmarks; without it this is a test, hence a quick look
    #[arg(long, hide = true)]
    bench: bool,
}

impl Options {
    pub(crate) fn plan(&self) -> Plan {
        let quick = self.quick();
        let size = self.size.unwrap_or(if quick { [128, 128] } else { [600, 600] });
        let mut methods = vec![Method::Naive, Method::Ideal];
        let all = [Method::ATOMIC, Method::ES_ISLER, Method::BRACKET, Method::VERIFIED];
        for &method in if self.methods.is_empty() { &all[..] } else { &self.methods } {
            if !methods.contains(&method) {
                methods.push(method);
            }
        }
        Plan {
            size,
            e_px: self.e.unwrap_or(15.0 * size[0] as f32 / 600.0),
            lights: self.lights,
            methods,
            warm_ups: if quick { 1 } else { 2 },
            rounds: self.rounds.map_or(if quick { 2 } else { 7 }, |rounds| rounds as usize),
        }
    }

    pub(crate) fn scenes(&self) -> Vec<String> {
        match self.scenes.as_slice() {
            [] if self.quick() => ["hall", "spheres"].map(Into::into).into(),
            [] => SCENES.map(Into::into).into(),
            named => named.to_vec(),
        }
    }

    /// Where the results go.
    pub(crate) fn folder(&self) -> PathBuf {
        let target = crate::common::files::root().join("target");
        let standard = target.join(if self.quick() { "bench-smoke" } else { "bench/stereo" });
        self.out.clone().unwrap_or(standard)
    }

    fn quick(&self) -> bool {
        self.smoke || !self.bench
    }
}
