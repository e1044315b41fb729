//! Tests the methods on hard scenes and on a film: `cargo bench --bench stability`.
//!
//! The benchmark only counts and measures no times, so the results do not depend on the machine. Two tables are printed
//! in Markdown. The first contains cost and accuracy on every trial, and is written as `results.csv` and
//! `results.json`. The second contains the flicker in the film of turning spheres, and is written as `flicker.csv`. The
//! chart is `stability.svg`. Either all files are written, or none. `cargo bench --bench stability -- --help` lists the
//! options; `cargo test --benches` runs it as `--smoke`.

mod chart;
#[path = "../common/mod.rs"]
mod common;
mod film;
mod options;
mod output;
mod tables;
mod trials;

use std::{error::Error, process::ExitCode};

use clap::Parser;
use stereotrace::{Gpu, Renderer, blocking::Wait};

use crate::{common::provenance::Provenance, options::Options};

fn main() -> ExitCode {
    common::exit::status(run(&Options::parse()))
}

fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    let plan = options.plan();
    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let provenance = Provenance::of(renderer.gpu());
    let mut rows = Vec::new();
    for &trial in &plan.trials {
        eprintln!("{trial}");
        rows.extend(trials::measure(&mut renderer, trial, &plan));
    }
    println!("{}", tables::of_trials(&rows, &plan, &provenance));
    eprintln!("film of {} frames", plan.frames);
    let films = film::measure(&mut renderer, &plan)?;
    println!("{}", tables::of_films(&films, &plan));
    for path in output::write_all(&options.folder(), &rows, &films, &plan, &provenance)? {
        println!("wrote {}", path.display());
    }
    Ok(())
}
