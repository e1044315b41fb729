//! Compares the figures of Adelson and Hodges 1993, "Stereoscopic ray-tracing", with this library's: `cargo bench
//! --bench adelson-hodges`.
//!
//! The paper's random scenes are rendered at its picture size, with both interaxials that its text implies. The
//! benchmark measures the traced pixels, the saved rays, the saved box and primitive tests, and the difference of the
//! pictures. Further parts are several rays per pixel, the worst cases, table 4, and the scenes in which the method
//! fails. A table is printed in Markdown. `results.csv` and `results.json` are either both written, or none.
//! studies/ADELSON-HODGES.md discusses the results. `cargo bench --bench adelson-hodges -- --help` lists the options;
//! `cargo test --benches` runs it as `--smoke`.

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
