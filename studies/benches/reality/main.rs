//! Sets the figures of Raghuvanshi and Dhande, "Raytraced rendering using t-buffer and shadow-buffer", beside ours:
//! `cargo bench -p stereotrace-studies --bench reality`, after the name of their engine.
//!
//! Its stacks of objects by the classical ray tracer, by the T-buffer with and without a shadow-buffer, and by what the
//! paper could not show, rays through a tree; its three spheres; and its shadow-buffers by resolution. One eye sees
//! them all, as in the paper. Prints tables in Markdown and writes them with CSV, JSON, charts and pictures, whole or
//! not at all. studies/REALITY.md says what comes of it. `cargo bench -p stereotrace-studies --bench reality -- --help`
//! lists the options; `cargo test --benches` runs it as `--smoke`.

mod charts;
#[path = "../../../benches/common/mod.rs"]
mod common;
mod fits;
mod gains;
mod measure;
mod options;
mod quality;
mod report;
mod resolution;
mod ways;

use std::{error::Error, process::ExitCode};

use clap::Parser;
use stereotrace::{Gpu, Renderer, blocking::Wait};

use crate::{
    common::provenance::Provenance,
    options::{Options, Part},
    report::Report,
};

fn main() -> ExitCode {
    common::exit::status(run(&Options::parse()))
}

fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    let plan = options.plan();
    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let mut report = Report::new(Provenance::of(renderer.gpu()));
    for part in &plan.parts {
        match part {
            Part::Pictures => {
                quality::pictures(&mut renderer, &plan, &mut report)?;
                quality::stacks(&mut renderer, &plan, &mut report)?;
            }
            Part::Gains => gains::measure(&mut renderer, &plan, &mut report)?,
            Part::Resolution => resolution::measure(&mut renderer, &plan, &mut report)?,
            Part::Quality => quality::shadows(&mut renderer, &plan, &mut report)?,
        }
    }
    println!("{}", report.text);
    for path in report.write(&options.folder())? {
        println!("wrote {}", path.display());
    }
    Ok(())
}
