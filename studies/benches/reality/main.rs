//! Compares the figures of Raghuvanshi and Dhande, "Raytraced rendering using t-buffer and shadow-buffer", with this
//! library's: `cargo bench -p stereotrace-studies --bench reality`. The benchmark has the name of their engine.
//!
//! The paper's stacks of objects are rendered by the classical ray tracer, and by the T-buffer with and without a
//! shadow-buffer. Rays through a tree, which the paper could not show, are added. Further parts render the paper's
//! three spheres, and its shadow-buffers at several resolutions. One eye sees all scenes, as in the paper. Tables are
//! printed in Markdown. Files with the tables, CSV, JSON, charts and pictures are either all written, or none.
//! studies/REALITY.md discusses the results. `cargo bench -p stereotrace-studies --bench reality -- --help` lists the
//! options; `cargo test --benches` runs it as `--smoke`.

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
