//! Compares the methods in time, accuracy and counted work, scene by scene: `cargo bench --bench stereo`.
//!
//! Times cover the passes alone, without upload and read-back. All methods take turns in one run, in an order that
//! rotates from round to round. Tables are printed. `results.csv`, `results.json` and `chart.svg` are either all
//! written, or none. `cargo bench --bench stereo -- --help` lists the options; `cargo test --benches` runs it as
//! `--smoke`.

mod chart;
#[path = "../common/mod.rs"]
mod common;
mod options;
mod output;
mod tables;

use std::{error::Error, process::ExitCode};

use clap::Parser;
use stereotrace::{Gpu, Renderer, blocking::Wait};

use crate::{
    common::{
        measure::{self, Measured},
        provenance::Provenance,
        sampled, scenes,
    },
    options::Options,
};

fn main() -> ExitCode {
    common::exit::status(run(&Options::parse()))
}

fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    let plan = options.plan();
    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let provenance = Provenance::of(renderer.gpu());
    let mut measured: Vec<Measured> = Vec::new();
    for name in options.scenes() {
        match scenes::load(&name, plan.size, plan.e_px, plan.lights)? {
            Some(mut scene) => {
                if plan.sampled.soft.is_some() {
                    sampled::soften(&mut scene)?;
                }
                scene.camera = options.projected(scene.camera);
                let figures = measure::measure(&mut renderer, &scene, &plan)?;
                println!("{}", tables::of(&figures, &plan, &provenance));
                measured.push(figures);
            }
            None => println!("{}\n", scenes::skipped(&name)),
        }
    }
    if measured.is_empty() {
        return Err("no scene was measured".into());
    }
    for path in output::write_all(&options.folder(), &measured, &plan, &provenance)? {
        println!("wrote {}", path.display());
    }
    Ok(())
}
