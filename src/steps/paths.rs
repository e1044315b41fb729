//! Paths of light: steps after all views' first hits. They add the light that surfaces, the sky and emitting surfaces
//! send to each view's hits.

use super::step;
use crate::{
    Lighting, Options, Penumbra,
    frame::{
        plan::{Launch, Step},
        uniforms::Part,
    },
    kernel::layout::TO_TRACE,
    kernel::{Kernel, Resource, Role, kernel},
};

pub(crate) const BEGIN_PATHS: Kernel = kernel!("paths", "begin_paths", Role::Paths);
/// Begins paths in listed pixels.
pub(crate) const BEGIN_LISTED_PATHS: Kernel = kernel!("paths", "begin_listed_paths", Role::Paths);
/// Reuses light of a source view, and lists the pixels that need paths of their own.
pub(crate) const SHARE_BROUGHT: Kernel = kernel!("paths", "share_brought", Role::SharePaths);
/// Recalls light of an earlier frame, and lists the pixels that need paths of their own.
pub(crate) const RECALL_BROUGHT: Kernel = kernel!("paths", "recall_brought", Role::Paths);
/// Keeps a view's light for the next frame.
pub(crate) const KEEP_BROUGHT: Kernel = kernel!("paths", "keep_brought", Role::Paths);
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
    /// Whether views that reuse visibility bits also reuse light.
    pub(crate) is_shared: bool,
}

impl Paths {
    /// Returns the paths of a frame, after this number of other parts.
    pub(crate) fn of(options: &Options, first_part: usize) -> Option<Self> {
        match options.lighting {
            Lighting::Direct => None,
            Lighting::Paths { bounces, samples } => Some(Self {
                each: samples.div_ceil(options.samples),
                rays: bounces + 1,
                first_part,
                is_shared: options.penumbra != Penumbra::Exact,
            }),
        }
    }

    pub(crate) fn parts(self) -> impl Iterator<Item = Part> {
        (1..=self.rays).map(|ray| Part::Paths { ray })
    }
}

/// Returns the steps that follow paths from a view's hits and add their light.
pub(crate) fn of(view: usize, paths: Paths) -> Vec<Step> {
    followed(view, paths, step(&BEGIN_PATHS, view, Launch::Pixels))
}

/// Returns the steps that reuse light of a view's source, follow paths for the rest, and add their light. The
/// source's paths have been followed.
pub(crate) fn shared(view: usize, paths: Paths) -> Vec<Step> {
    listed(&SHARE_BROUGHT, view, paths)
}

/// Returns the steps that recall light of an earlier frame, follow paths for the rest, and add a view's light.
pub(crate) fn recalled(view: usize, paths: Paths) -> Vec<Step> {
    listed(&RECALL_BROUGHT, view, paths)
}

/// Returns the steps that follow paths in the pixels that a kernel lists.
fn listed(lists: &'static Kernel, view: usize, paths: Paths) -> Vec<Step> {
    let begin = step(&BEGIN_LISTED_PATHS, view, Launch::Listed(Resource::Lists, TO_TRACE));
    [vec![Step::EmptyLists, step(lists, view, Launch::Pixels)], followed(view, paths, begin)].concat()
}

/// Returns the step that keeps a view's light for the next frame.
pub(crate) fn kept(view: usize) -> Step {
    step(&KEEP_BROUGHT, view, Launch::Pixels)
}

fn followed(view: usize, paths: Paths, begin: Step) -> Vec<Step> {
    let trace = |ray: u32| Step::Run {
        name: TRACE_PATHS.name,
        kernel: &TRACE_PATHS,
        view,
        launch: Launch::Listed(Resource::Paths, ray - 1),
        part: paths.first_part + ray as usize - 1,
    };
    let mut steps = Vec::new();
    for _ in 0..paths.each {
        steps.extend([Step::EmptyPaths, begin]);
        steps.extend((1..=paths.rays).map(trace));
    }
    steps.push(step(&ADD_BROUGHT, view, Launch::Pixels));
    steps
}
