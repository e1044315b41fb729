//! Plan of a method, as data: the steps that run over the views for each band of rows.

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
    /// All pixels were drawn into a T-buffer, except pixels counted as missed, which were traced.
    Drawn,
    /// All pixels were found within bounds by an earlier frame, or traced.
    Recalled,
    /// All pixels were resolved by `bracket`. The marks say how.
    Bracketed,
    /// All pixels were copied from the source.
    Copied,
    /// Pixels were traced or reused from the source, as their marks say. `checked` says whether a ray verified each
    /// reused pixel.
    Marked { checked: bool },
    /// Each band was either traced or resolved by `bracket`, as its counters say.
    Chosen,
}

/// The stages that a frame runs on each band, and the properties that specialise its kernels.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// Steps over the whole picture, before the first band.
    pub(crate) before: Vec<Step>,
    pub(crate) stages: Vec<Stage>,
    /// Rule by which views reuse visibility bits. It also determines which data of source samples are kept.
    pub(crate) bits: ShadowReuse,
    /// Whether source samples are kept for reuse.
    pub(crate) samples: bool,
    /// How `bracket` searches tiles.
    pub(crate) search: Search,
    /// Whether some step reads the rows above and below a band, for edges or blocks of samples.
    pub(crate) reaches: bool,
    /// How each view was made.
    pub(crate) made: Vec<Made>,
    /// The source of each view. A traced view is its own source.
    pub(crate) sources: Vec<usize>,
    /// How each view is traced in steps, so that no adapter's limit on a thread's loop rounds ends the work early.
    pub(crate) in_steps: Vec<InSteps>,
}

/// How `bracket` searches tiles. All forms list the same primitives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Search {
    /// One thread per tile.
    Alone,
    /// One thread per four tiles, for several samples per pixel.
    Wide,
    /// One workgroup per tile. A GPU needs more threads than a picture has tiles.
    Together,
}

impl Search {
    /// Returns the form for a number of samples per pixel. `together` is set on adapters with many threads.
    pub(crate) fn of(together: bool, samples: u32) -> Self {
        match (together, samples) {
            (true, _) => Self::Together,
            (false, 1) => Self::Alone,
            (false, _) => Self::Wide,
        }
    }

    pub(crate) fn launch(self) -> Launch {
        match self {
            Self::Alone => Launch::Tiles,
            Self::Wide => Launch::WideTiles,
            Self::Together => Launch::EachTile,
        }
    }
}

/// Steps of a view that is traced in several dispatches.
#[derive(Clone, Debug)]
pub(crate) struct InSteps {
    /// Step that is repeated until all threads have finished.
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
        /// Name in timings and progress reports.
        name: &'static str,
        kernel: &'static Kernel,
        /// View for which the kernel runs.
        view: usize,
        launch: Launch,
        /// Index of the view's uniform that the kernel reads. Soft light, paths and rounds of mirrors have one uniform
        /// per part; all other steps use the first.
        part: usize,
    },
    /// Copies a view from its source.
    Copy(usize),
    /// Copies the bounds that an earlier frame gives for the tiles of a view's band.
    CopyBounds(usize),
    /// Keeps the samples of a view's band for later frames.
    Remember(usize),
    /// Empties the lists.
    EmptyLists,
    /// Empties the lists of paths.
    EmptyPaths,
    /// Empties the lists of pixels in rounds of secondary rays.
    EmptyBounced,
    /// Empties the 3D buffer.
    EmptySlots,
    /// Clears a buffer, or its first bytes.
    Clear(Resource, Option<u64>),
}

/// Number of threads of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Launch {
    /// One thread per pixel of the band, or per block of pixels if the kernel traces rays.
    Pixels,
    /// One thread per run of this many pixels in each row of the band.
    Runs(u32),
    /// One thread per tile of the band.
    Tiles,
    /// One thread per four tiles of the band.
    WideTiles,
    /// One workgroup per tile of the band.
    EachTile,
    /// One thread per row of the band.
    Rows,
    /// One thread per block of this size, of the whole picture.
    Picture([u32; 2]),
    /// This number of workgroups, whatever the band's size is.
    Number([u32; 3]),
    /// Indirect dispatch by the head of a list in a buffer: the buffer, and the list's index. An earlier step filled
    /// the list.
    Listed(Resource, u32),
    /// One workgroup for the whole band.
    Once,
}

/// Work on the host between steps.
#[derive(Clone, Debug)]
pub(crate) enum Host {
    /// Runs Adelson & Hodges' sweep for a view.
    Sweep(usize),
    /// Sizes the 3D buffer for a view, and runs these steps over as many rows at a time as it has room for.
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
    /// Returns all steps, including the steps in stages on the host.
    fn steps(&self) -> impl Iterator<Item = Step> + '_ {
        let stages = self.stages.iter().flat_map(|stage| match stage {
            Stage::Steps(steps) => steps.clone(),
            Stage::Host(Host::Slots(_, _, steps)) => steps.clone(),
            Stage::Host(Host::Sweep(_)) => Vec::new(),
        });
        self.before.iter().copied().chain(stages)
    }

    /// Returns the kernels of all steps, each once or more.
    pub(crate) fn kernels(&self) -> impl Iterator<Item = &'static Kernel> + '_ {
        self.steps().filter_map(|step| if let Step::Run { kernel, .. } = step { Some(kernel) } else { None })
    }

    /// Returns the number of steps, without those that run on the host.
    pub(crate) fn step_count(&self) -> usize {
        self.stages.iter().map(|stage| if let Stage::Steps(steps) = stage { steps.len() } else { 0 }).sum()
    }

    /// Returns the buffers and textures that the plan uses, with kernels of this variant.
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
                // These steps add no places, since the plan's kernels bind the same buffers.
                Step::EmptyLists | Step::EmptyPaths | Step::EmptyBounced | Step::EmptySlots | Step::Clear(..) => {}
                Step::CopyBounds(_) | Step::Remember(_) => {}
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

    /// Returns whether the samples of some view are kept for later frames.
    pub(crate) fn remembers(&self) -> bool {
        self.steps().any(|step| matches!(step, Step::Remember(_)))
    }

    /// Returns whether a stage runs on the host.
    pub(crate) fn needs_host(&self) -> bool {
        self.stages.iter().any(|stage| matches!(stage, Stage::Host(_)))
    }

    /// Returns the plan's name in progress reports: the name of a band's last step.
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
