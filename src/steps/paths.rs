//! Paths of light: steps after all views' first hits. They add the light that surfaces, the sky and emitting surfaces
//! send to each view's hits.

use super::step;
use crate::{
    Lighting, Options,
    frame::{
        plan::{Launch, Step},
        uniforms::Part,
    },
    kernel::{Kernel, Resource, Role, kernel},
};

pub(crate) const BEGIN_PATHS: Kernel = kernel!("paths", "begin_paths", Role::Paths);
pub(crate) const TRACE_PATHS: Kernel = kernel!("paths", "trace_paths", Role::Paths);
pub(crate) const ADD_BROUGHT: Kernel = kernel!("paths", "add_brought", Role::Paths);

/// Paths of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paths {
    /// Number of paths per sample of a pixel.
    pub(crate) each: u32,
    /// Number of rays of a path, at most.
    pub(crate) rays: u32,
    /// Number of parts before those of paths.
    pub(crate) first_part: usize,
}

impl Paths {
    /// Returns the paths of a frame, after this number of other parts.
    pub(crate) fn of(options: &Options, first_part: usize) -> Option<Self> {
        match options.lighting {
            Lighting::Direct => None,
            Lighting::Paths { bounces, samples } => {
                Some(Self { each: samples.div_ceil(options.samples), rays: bounces + 1, first_part })
            }
        }
    }

    pub(crate) fn parts(self) -> impl Iterator<Item = Part> {
        (1..=self.rays).map(|ray| Part::Paths { ray })
    }
}

/// Returns the steps that follow paths from a view's hits and add their light.
pub(crate) fn of(view: usize, paths: Paths) -> Vec<Step> {
    let trace = |ray: u32| Step::Run {
        name: TRACE_PATHS.name,
        kernel: &TRACE_PATHS,
        view,
        launch: Launch::Listed(Resource::Paths, ray - 1),
        part: paths.first_part + ray as usize - 1,
    };
    let mut steps = Vec::new();
    for _ in 0..paths.each {
        steps.extend([Step::EmptyPaths, step(&BEGIN_PATHS, view, Launch::Pixels)]);
        steps.extend((1..=paths.rays).map(trace));
    }
    steps.push(step(&ADD_BROUGHT, view, Launch::Pixels));
    steps
}
