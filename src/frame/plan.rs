//! What a method's frame does to each band of rows: steps over views, as data.

use super::{
    driver::Driver,
    targets::{Target, Used, samples_of},
};
use crate::{
    BufferDepth, Check, Error, Method, ShadowReuse, Sweep,
    kernels::{Kernel, Touches},
    steps::{bracket, host, mirrors, reproject, resolve, trace},
    variant::Variant,
};

/// How a view came about, or a band of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Made {
    /// All of its pixels were traced.
    Traced,
    /// All were drawn, but for those that marks in counters say, which were traced.
    Drawn,
    /// All were resolved, with marks of how.
    Bracketed,
    /// They are its source's.
    Copied,
    /// Traced, or those of its source, as marks say; those that are not were checked by a ray each, or not.
    Marked { checked: bool },
    /// Each band as its counters say: traced or bracketed.
    Chosen,
}

/// What a frame does to a band, and what its kernels are made for.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) stages: Vec<Stage>,
    /// Which shadow bits views take over: what is kept of their sources' samples depends on it.
    pub(crate) bits: ShadowReuse,
    /// Whether it takes any of them over.
    pub(crate) samples: bool,
    /// Whether `bracket` searches four tiles at once, as it does where a pixel has several samples.
    pub(crate) wide: bool,
    /// Whether some step looks into the rows above and below, as an edge and a block of a source's samples do.
    pub(crate) reaches: bool,
    /// How each view comes about.
    pub(crate) made: Vec<Made>,
    /// Of each view the one that it is made from; one that is traced is its own.
    pub(crate) sources: Vec<usize>,
}

/// What is done before the next stage begins.
#[derive(Clone, Debug)]
pub(crate) enum Stage {
    /// Steps of the device.
    Steps(Vec<Step>),
    /// What the host does, once all of them are done.
    Host(Host),
}

/// What a step does to a band.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Step {
    /// A kernel runs.
    Run {
        /// What times and progress call it.
        name: &'static str,
        kernel: &'static Kernel,
        /// The view that it works for.
        view: usize,
        launch: Launch,
        /// Which of the view's uniforms it reads: one a part of what is asked of lights that are not points, else the
        /// first.
        part: usize,
    },
    /// A view becomes its source's.
    Copy(usize),
    /// The lists of a buffer are emptied: `Lists` or `Found`.
    EmptyLists(Target),
    /// The 3D buffer is.
    EmptySlots,
    /// The T-buffer and the heads of its lists are.
    EmptyTBuffer,
}

/// Threads of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Launch {
    /// One a pixel of the band, or a block of pixels where the kernel traces rays.
    Pixels,
    /// One a run of so many pixels in each row of the band.
    Runs(u32),
    /// One a tile of the band.
    Tiles,
    /// One for four tiles of the band.
    WideTiles,
    /// One a row of the band.
    Rows,
    /// One a primitive of the tree.
    Primitives,
    /// As the head of a list of a buffer says, which an earlier step filled.
    Listed(Target, u32),
    /// One workgroup.
    Once,
}

/// What the host does between steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Host {
    /// Adelson & Hodges' sweep, for a view.
    Sweep(usize),
    /// Sizes the 3D buffer for a view, and reprojects by it.
    Slots(BufferDepth, usize),
}

impl Host {
    pub(crate) async fn run(self, driver: &mut Driver<'_>) -> Result<(), Error> {
        match self {
            Self::Sweep(view) => host::sweep(driver, view).await,
            Self::Slots(depth, view) => host::slots(driver, depth, view).await,
        }
    }
}

impl Step {
    /// The same under another name.
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
    /// The plan of a method for views with these sources; `mirrors` if the scene has surfaces that send rays on, and of
    /// the parts of what is asked of `soft` light, where there is such; `wide` if a pixel has several samples;
    /// `drawn` if hits of traced views are found by a T-buffer.
    pub(crate) fn of(
        method: Method,
        sources: &[usize],
        mirrors: bool,
        soft: Option<usize>,
        wide: bool,
        drawn: bool,
    ) -> Self {
        let (bits, samples) = match method {
            Method::Auto => (ShadowReuse::Two, true),
            Method::Bracket(shadows) => (shadows, true),
            _ => (ShadowReuse::Rays, false),
        };
        let made = match method {
            Method::Naive if drawn => Made::Drawn,
            Method::Naive => Made::Traced,
            Method::Ideal => Made::Copied,
            Method::Auto => Made::Chosen,
            Method::Bracket(_) => Made::Bracketed,
            Method::Atomic(check) | Method::Buffer(_, check) => Made::Marked { checked: check == Check::All },
            Method::Sweep(_) => Made::Marked { checked: false },
        };
        let reaches = matches!(
            method,
            Method::Atomic(Check::Edges) | Method::Buffer(_, Check::Edges) | Method::Bracket(ShadowReuse::Block)
        );
        let behind = |view| if mirrors { mirrors::of(view) } else { Vec::new() };
        let traced = views(sources).filter(|&view| sources[view] == view);
        let traced = traced.flat_map(|view| [trace::source(view, soft, drawn), behind(view)].concat()).collect();
        let mut stages = vec![Stage::Steps(traced)];
        for (view, source) in targets(sources) {
            stages.extend(target(method, view, source, (soft, wide, drawn)));
            if method != Method::Ideal {
                stages.push(Stage::Steps(behind(view)));
            }
        }
        let traced = if drawn { Made::Drawn } else { Made::Traced };
        let made = views(sources).map(|view| if sources[view] == view { traced } else { made }).collect();
        Self { stages: joined(stages), bits, samples, wide, reaches, made, sources: sources.to_vec() }
    }

    /// Its steps, with those of the host's stages.
    fn steps(&self) -> impl Iterator<Item = Step> + '_ {
        self.stages.iter().flat_map(|stage| match stage {
            Stage::Steps(steps) => steps.clone(),
            Stage::Host(Host::Slots(_, view)) => reproject::slots(*view),
            Stage::Host(Host::Sweep(_)) => Vec::new(),
        })
    }

    /// What it uses, its kernels specialised so.
    pub(crate) fn uses(&self, with: &Variant) -> Used {
        let mut used = Used::default();
        for step in self.steps() {
            match step {
                Step::Run { kernel, view, .. } => {
                    let source = self.sources[view];
                    let targets = kernel
                        .storage
                        .iter()
                        .map(|(target, _)| *target)
                        .chain(kernel.linear(with).iter().map(|(target, _)| *target));
                    used.places.extend(targets.map(|target| target.of(view, source)));
                    used.samples.extend(kernel.samples(with).map(|access| samples_of(view, source, access)));
                }
                Step::Copy(view) => {
                    used.places.insert((Target::View, view));
                    used.places.extend(with.linear.then_some((Target::Linear, view)));
                }
                // Of kernels that run.
                Step::EmptyLists(_) | Step::EmptySlots | Step::EmptyTBuffer => {}
            }
        }
        used.places.remove(&(Target::Slots, 0)); // made when its depth is known
        // Statistics are read of every view.
        used.places.extend(views(&self.sources).map(|view| (Target::Counters, view)));
        used
    }

    /// Whether a step reads the table of objects.
    pub(crate) fn touches_objects(&self) -> bool {
        self.steps().any(|step| matches!(step, Step::Run { kernel, .. } if kernel.touches == Touches::Objects))
    }

    /// Whether views' marks are to be empty before the first step, since steps add to them.
    pub(crate) fn clears_marks(&self) -> bool {
        self.made.iter().any(|made| matches!(made, Made::Marked { .. }))
    }

    /// Whether the host has a part in it.
    pub(crate) fn needs_host(&self) -> bool {
        self.stages.iter().any(|stage| matches!(stage, Stage::Host(_)))
    }

    /// What progress calls it: the last step of a band.
    pub(crate) fn name(&self) -> &'static str {
        self.steps().filter_map(|step| step.name()).last().unwrap_or_default()
    }
}

fn views(sources: &[usize]) -> std::ops::Range<usize> {
    0..sources.len()
}

/// The views that are not traced, each with its source.
pub(crate) fn targets(sources: &[usize]) -> impl Iterator<Item = (usize, usize)> + '_ {
    sources.iter().copied().enumerate().filter(|(view, source)| view != source)
}

/// The stages by which a method makes a view from its source.
fn target(method: Method, view: usize, source: usize, (soft, wide, drawn): (Option<usize>, bool, bool)) -> Vec<Stage> {
    let steps = match method {
        Method::Naive => trace::target(view, soft, drawn),
        Method::Ideal => vec![Step::Copy(view)],
        Method::Auto => bracket::or_traced(view, soft, wide),
        Method::Atomic(check) => [reproject::atomic(view), resolve::of(view, check, soft)].concat(),
        Method::Buffer(depth, check) => {
            let range = if depth == BufferDepth::Adaptive { reproject::depth_range(source) } else { Vec::new() };
            return vec![
                Stage::Steps(range),
                Stage::Host(Host::Slots(depth, view)),
                Stage::Steps(resolve::of(view, check, soft)),
            ];
        }
        // What the sweep leaves is trusted: it has cleared the gaps.
        Method::Sweep(Sweep::Scanline) => [reproject::scanline(view), resolve::of(view, Check::None, soft)].concat(),
        Method::Sweep(Sweep::Sequential) => {
            return vec![Stage::Host(Host::Sweep(view)), Stage::Steps(resolve::of(view, Check::None, soft))];
        }
        Method::Bracket(bits) => [bracket::bound(view, bits), bracket::resolve(view, soft, wide)].concat(),
    };
    vec![Stage::Steps(steps)]
}

/// With steps that follow each other as one stage.
fn joined(stages: Vec<Stage>) -> Vec<Stage> {
    let mut all: Vec<Stage> = Vec::new();
    for stage in stages {
        match (all.last_mut(), stage) {
            (Some(Stage::Steps(steps)), Stage::Steps(more)) => steps.extend(more),
            (_, stage) => all.push(stage),
        }
    }
    all
}
