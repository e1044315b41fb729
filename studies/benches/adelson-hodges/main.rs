//! Sets the figures of Adelson and Hodges 1993, "Stereoscopic ray-tracing", beside ours: `cargo bench --bench
//! adelson-hodges`.
//!
//! Its random scenes at its size of picture and at both distances between the eyes that its text implies: what is
//! traced again, what that saves by rays and by counters, and how far the pictures differ; then several rays a pixel,
//! its worst cases, its table 4, and the scenes in which it fails. Prints a table in Markdown and writes `results.csv`
//! and `results.json`, whole or not at all. studies/ADELSON-HODGES.md says what comes of it. `cargo bench --bench
//! adelson-hodges -- --help` lists the options; `cargo test --benches` runs it as `--smoke`.

mod adaptive;
mod closed;
#[path = "../../../benches/common/mod.rs"]
mod common;
mod counts;
mod groups;
mod lattice;
mod measure;
mod nine;
mod options;
mod panes;
mod quanta;
mod random;
mod rows;
mod samples;
mod times;
mod worst;

use std::{error::Error, process::ExitCode};

use clap::Parser;
use stereotrace::{Gpu, Renderer, blocking::Wait};

use crate::{
    common::provenance::Provenance,
    options::{Options, Part},
};

fn main() -> ExitCode {
    common::exit::status(run(&Options::parse()))
}

fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    let plan = options.plan();
    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let provenance = Provenance::of(renderer.gpu());
    let mut rows = Vec::new();
    for part in &plan.parts {
        rows.extend(match part {
            Part::Random => random::rows(&mut renderer, &plan)?,
            Part::Samples => samples::rows(&mut renderer, &plan)?,
            Part::Nine => nine::rows(&mut renderer, &plan, &options.folder())?,
            Part::Adaptive => adaptive::rows(&mut renderer, &plan)?,
            Part::Times => times::rows(&mut renderer, &plan)?,
            Part::Worst => worst::rows(&mut renderer, &plan)?,
        });
    }
    println!("{}", rows::table(&rows, plan.side, &provenance));
    for path in rows::write(&options.folder(), &rows, plan.side, &provenance)? {
        println!("wrote {}", path.display());
    }
    Ok(())
}
