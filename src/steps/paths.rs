//! Paths of light: steps after all views' first hits. They add the light that surfaces, the sky and emitting surfaces
//! send to each view's hits.

use super::step;
use crate::{
    Gpu, Lighting, Options, Penumbra,
    frame::{
        fewest_rows,
        plan::{Launch, Step},
        targets::{proposed_bytes, state_limit},
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
/// Begin paths whose vertices other kernels shade.
pub(crate) const BEGIN_VERTICES: Kernel = kernel!("paths", "begin_vertices", Role::Paths);
pub(crate) const BEGIN_LISTED_VERTICES: Kernel = kernel!("paths", "begin_listed_vertices", Role::Paths);
pub(crate) const TRACE_PATH_RAYS: Kernel = kernel!("paths", "trace_path_rays", Role::Paths);
pub(crate) const SCATTER_PATHS: Kernel = kernel!("paths", "scatter_paths", Role::Paths);
/// Finds how much of the light arrives that [`SCATTER_PATHS`] proposed.
pub(crate) const LIGHT_PATHS: Kernel = kernel!("paths", "light_paths", Role::Paths);
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
    /// Whether separate kernels trace rays, scatter light and trace rays to lights. Otherwise one kernel does all this,
    /// which takes scratch memory on GPUs. The light is the same.
    is_apart: bool,
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
                is_apart: false,
            }),
        }
    }

    /// Sets whether kernels that trace are separate. They take a buffer that very wide pictures cannot bind.
    pub(crate) fn apart(self, gpu: &Gpu, is_apart: bool, [width, height]: [u32; 2]) -> Self {
        let bytes = proposed_bytes(u64::from(width) * u64::from(fewest_rows(height)));
        Self { is_apart: is_apart && bytes <= state_limit(gpu), ..self }
    }

    pub(crate) fn parts(self) -> impl Iterator<Item = Part> {
        (0..=self.rays).map(|ray| Part::Paths { ray })
    }
}

/// Returns the steps that follow paths from a view's hits and add their light.
pub(crate) fn of(view: usize, paths: Paths) -> Vec<Step> {
    let begin = if paths.is_apart { &BEGIN_VERTICES } else { &BEGIN_PATHS };
    followed(view, paths, step(begin, view, Launch::Pixels))
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
    let begin = if paths.is_apart { &BEGIN_LISTED_VERTICES } else { &BEGIN_LISTED_PATHS };
    let begin = step(begin, view, Launch::Listed(Resource::Lists, TO_TRACE));
    [vec![Step::EmptyLists, step(lists, view, Launch::Pixels)], followed(view, paths, begin)].concat()
}

/// Returns the step that keeps a view's light for the next frame.
pub(crate) fn kept(view: usize) -> Step {
    step(&KEEP_BROUGHT, view, Launch::Pixels)
}

fn followed(view: usize, paths: Paths, begin: Step) -> Vec<Step> {
    let of_list = |kernel: &'static Kernel, list: u32, ray: u32| Step::Run {
        name: kernel.name,
        kernel,
        view,
        launch: Launch::Listed(Resource::Paths, list),
        part: paths.first_part + ray as usize,
    };
    let apart = |ray: u32| {
        let trace = (ray > 0).then_some(&TRACE_PATH_RAYS);
        // Where the last rays of paths end, only emitted light counts.
        let light = (ray < paths.rays).then_some(&LIGHT_PATHS);
        trace.into_iter().chain([&SCATTER_PATHS]).chain(light).map(move |kernel| of_list(kernel, ray, ray))
    };
    let mut steps = Vec::new();
    for _ in 0..paths.each {
        steps.extend([Step::EmptyPaths, begin]);
        match paths.is_apart {
            true => steps.extend((0..=paths.rays).flat_map(apart)),
            false => steps.extend((1..=paths.rays).map(|ray| of_list(&TRACE_PATHS, ray - 1, ray))),
        }
    }
    steps.push(step(&ADD_BROUGHT, view, Launch::Pixels));
    steps
}
