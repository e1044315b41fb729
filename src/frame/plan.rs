//! The plan of a method: the steps that it runs over views for each band of rows, as data.

use super::targets::Used;
use crate::{
    BufferDepth, ShadowReuse,
    kernel::{Kernel, Kernels, Resource, variant::Variant},
};

/// How a view, or a band of it, was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Made {
    /// All pixels were traced.
    Traced,
    /// All pixels were drawn, except those counted as missed, which were traced.
    Drawn,
    /// All pixels were resolved by `bracket`; marks say how.
    Bracketed,
    /// All pixels are copied from the source.
    Copied,
    /// Pixels were traced or reused from the source, as marks say. `checked` says whether a ray verified each reused
    /// one.
    Marked { checked: bool },
    /// Traced or bracketed, as each band's counters say.
    Chosen,
}

/// What a frame does to each band, and how its kernels are specialised.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) stages: Vec<Stage>,
    /// Which visibility bits views reuse. What is kept of source samples depends on it.
    pub(crate) bits: ShadowReuse,
    /// Whether source samples are kept for reuse.
    pub(crate) samples: bool,
    /// Whether `bracket` searches four tiles at once, which it does for several samples a pixel.
    pub(crate) wide: bool,
    /// Whether some step reads the rows above and below a band, for edges or blocks of samples.
    pub(crate) reaches: bool,
    /// How each view is made.
    pub(crate) made: Vec<Made>,
    /// The source of each view. A traced view is its own source.
    pub(crate) sources: Vec<usize>,
    /// How each view is traced in steps, so that no limit on a thread's loops can end it.
    pub(crate) in_steps: Vec<InSteps>,
}

/// Steps of a view that is traced in several dispatches.
#[derive(Clone, Debug)]
pub(crate) struct InSteps {
    /// Repeated until all threads have finished.
    pub(crate) trace: Step,
    pub(crate) after: Vec<Step>,
}

/// Work that completes before the next stage begins.
#[derive(Clone, Debug)]
pub(crate) enum Stage {
    /// Steps on the device.
    Steps(Vec<Step>),
    /// Work on the host, after all earlier steps.
    Host(Host),
}

/// One step for a band.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Step {
    /// Runs a kernel.
    Run {
        /// Its name in times and progress.
        name: &'static str,
        kernel: &'static Kernel,
        /// The view that it works for.
        view: usize,
        launch: Launch,
        /// Index of the view's uniform that it reads. Soft light has one per part, all other steps use the first.
        part: usize,
    },
    /// Copies a view from its source.
    Copy(usize),
    /// Empties the lists.
    EmptyLists,
    /// Empties the 3D buffer.
    EmptySlots,
    /// Empties the T-buffer and the heads of its lists.
    EmptyTBuffer,
}

/// Threads of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Launch {
    /// One per pixel of the band, or per block of pixels if the kernel traces rays.
    Pixels,
    /// One per run of this many pixels in each row of the band.
    Runs(u32),
    /// One per tile of the band.
    Tiles,
    /// One per four tiles of the band.
    WideTiles,
    /// One per row of the band.
    Rows,
    /// One per primitive of the tree.
    Primitives,
    /// By the head of a buffer's list, which an earlier step filled.
    Listed(Resource, u32),
    /// One workgroup.
    Once,
}

/// Work of the host between steps.
#[derive(Clone, Debug)]
pub(crate) enum Host {
    /// Runs Adelson & Hodges' sweep for a view.
    Sweep(usize),
    /// Sizes the 3D buffer for a view, and runs these steps over as many rows at a time as fit it.
    Slots(BufferDepth, usize, Vec<Step>),
}

impl Step {
    /// Returns the same step under another name.
    pub(crate) fn named(self, called: &'static str) -> Self {
        match self {
            Self::Run { kernel, view, launch, part, .. } => Self::Run { name: called, kernel, view, launch, part },
            step => step,
        }
    }

    pub(crate) fn name(&self) -> Option<&'static str> {
        if let Self::Run { name, .. } = self { Some(*name) } else { None }
    }
}

impl Plan {
    /// Returns all steps, including those of the host's stages.
    fn steps(&self) -> impl Iterator<Item = Step> + '_ {
        self.stages.iter().flat_map(|stage| match stage {
            Stage::Steps(steps) => steps.clone(),
            Stage::Host(Host::Slots(_, _, steps)) => steps.clone(),
            Stage::Host(Host::Sweep(_)) => Vec::new(),
        })
    }

    /// Returns what the plan uses of targets, with kernels of this variant.
    pub(crate) fn uses(&self, kernels: &Kernels, with: &Variant) -> Used {
        let mut used = Used { searched: self.samples, ..Used::default() };
        for step in self.steps() {
            match step {
                Step::Run { kernel, view, .. } => {
                    let bound = kernels.bound(kernel, *with);
                    used.objects |= bound.contains(&Resource::ObjectTable);
                    used.places.extend(bound.iter().filter_map(|resource| resource.of(view, self.sources[view])));
                }
                Step::Copy(view) => {
                    used.places.insert((Resource::View, view));
                    used.places.extend(with.linear.then_some((Resource::Linear, view)));
                }
                // Kernels that run use the same buffers.
                Step::EmptyLists | Step::EmptySlots | Step::EmptyTBuffer => {}
            }
        }
        // Statistics are read for every view.
        used.places.extend(views(&self.sources).map(|view| (Resource::Counters, view)));
        used
    }

    /// Returns whether the marks of views must be cleared before the first step, since steps add to them.
    pub(crate) fn clears_marks(&self) -> bool {
        self.made.iter().any(|made| matches!(made, Made::Marked { .. }))
    }

    /// Returns whether a stage runs on the host.
    pub(crate) fn needs_host(&self) -> bool {
        self.stages.iter().any(|stage| matches!(stage, Stage::Host(_)))
    }

    /// Returns the plan's name in progress: that of a band's last step.
    pub(crate) fn name(&self) -> &'static str {
        self.steps().filter_map(|step| step.name()).last().unwrap_or_default()
    }
}

fn views(sources: &[usize]) -> std::ops::Range<usize> {
    0..sources.len()
}

/// Returns the views that are not traced, each with its source.
pub(crate) fn targets(sources: &[usize]) -> impl Iterator<Item = (usize, usize)> + '_ {
    sources.iter().copied().enumerate().filter(|(view, source)| view != source)
}
