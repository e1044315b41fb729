//! Parses the command line, and makes the plan of the benchmark from it.

use std::path::PathBuf;

use clap::Parser;
use stereotrace::{Equirectangular, Method, Projection, Span, StereoCamera, camera::HUMAN_INTERAXIAL};

use crate::common::{measure::Plan, options::size, sampled::Sampled};

/// Default scenes: built-in ones and two of the OBJ files.
const SCENES: [&str; 8] = ["spheres", "hall", "fence", "hidden", "near", "grazing", "sponza_4x", "dragon"];

/// Compares the methods in time, accuracy and counted work.
#[derive(Parser, Debug)]
#[command(name = "cargo bench --bench stereo --")]
pub(crate) struct Options {
    /// Smoke run with meaningless figures: 128x128, two rounds, two built-in scenes, into target/bench-smoke
    #[arg(long)]
    smoke: bool,
    /// Picture size in pixels [default: 600x600]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Interaxial in pixels [default: 15 of 600]
    #[arg(long, value_name = "PX")]
    e: Option<f32>,
    /// Equirectangular pairs of 360 degrees, seen from the camera's midpoint, with an interaxial of 0.065 world units.
    /// The default size is 2048x1024
    #[arg(long, conflicts_with = "e")]
    around: bool,
    /// Place this many lights by the library's rule [default: built-in scenes keep their own five, files get five]
    #[arg(long, value_name = "N")]
    lights: Option<usize>,
    /// Makes all lights spheres, with a radius of a twentieth of the camera's distance, sampled by so many rays
    #[arg(long, value_name = "RAYS", value_parser = clap::value_parser!(u32).range(1..=32))]
    soft: Option<u32>,
    /// Follows so many paths of light per pixel, with two bounces
    #[arg(long, value_name = "PATHS", value_parser = clap::value_parser!(u32).range(1..=1024))]
    paths: Option<u32>,
    /// Number of timed rounds, after two warm-up rounds [default: 7]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,
    /// Built-in scenes, folders of OBJ files, or paths of .obj, .gltf, .glb or .ply files [default: six built-in ones,
    /// `sponza_4x`, dragon]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    scenes: Vec<String>,
    /// Methods besides naive and ideal, which are always included [default: atomic, es-isler, bracket, verified]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    methods: Vec<Method>,
    /// Folder for the results [default: target/bench/stereo]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Passed by cargo when it benchmarks; without it this is a smoke run
    #[arg(long, hide = true)]
    bench: bool,
}

impl Options {
    pub(crate) fn plan(&self) -> Plan {
        let quick = self.quick();
        let size = self.size.unwrap_or(match (quick, self.around) {
            (true, _) => [128, 128],
            (false, true) => [2048, 1024],
            (false, false) => [600, 600],
        });
        let mut methods = vec![Method::Naive, Method::Ideal];
        let all = [Method::ATOMIC, Method::ES_ISLER, Method::BRACKET, Method::VERIFIED];
        for &method in if self.methods.is_empty() { &all[..] } else { &self.methods } {
            if !methods.contains(&method) {
                methods.push(method);
            }
        }
        Plan {
            size,
            around: self.around,
            e_px: self.e.unwrap_or(15.0 * size[0] as f32 / 600.0),
            lights: self.lights,
            sampled: Sampled { soft: self.soft, paths: self.paths },
            methods,
            warm_ups: if quick { 1 } else { 2 },
            rounds: self.rounds.map_or(if quick { 2 } else { 7 }, |rounds| rounds as usize),
        }
    }

    /// Returns a scene's camera with the projection of the options.
    pub(crate) fn projected(&self, camera: StereoCamera) -> StereoCamera {
        let projection = Projection::Equirectangular(Equirectangular::new(Span::Full));
        if self.around { camera.projection(projection).interaxial(HUMAN_INTERAXIAL) } else { camera }
    }

    pub(crate) fn scenes(&self) -> Vec<String> {
        match self.scenes.as_slice() {
            [] if self.quick() => ["hall", "spheres"].map(Into::into).into(),
            [] => SCENES.map(Into::into).into(),
            named => named.to_vec(),
        }
    }

    /// Returns the folder for the results.
    pub(crate) fn folder(&self) -> PathBuf {
        let target = crate::common::files::root().join("target");
        let standard = target.join(if self.quick() { "bench-smoke" } else { "bench/stereo" });
        self.out.clone().unwrap_or(standard)
    }

    fn quick(&self) -> bool {
        self.smoke || !self.bench
    }
}
