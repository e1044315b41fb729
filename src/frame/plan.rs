//! What a method's frame does: steps over bands of rows, as data.

use super::{
    driver::Driver,
    targets::{Target, Used},
};
use crate::{
    BufferDepth, Check, Error, Method, ShadowReuse, Sweep,
    kernels::{Access, Kernel, Touches},
    steps::{bracket, host, reproject, resolve, trace},
    variant::Variant,
};

/// How a view came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Made {
    /// All of its pixels were traced.
    Traced,
    /// All were resolved, with marks of how.
    Bracketed,
    /// They are its source's.
    Copied,
    /// Traced, or those of its source, as marks say.
    Marked,
}

/// What a frame does, and what its kernels are made for.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) stages: Vec<Stage>,
    /// Which shadow bits views take over: what is kept of their sources' samples depends on it.
    pub(crate) bits: ShadowReuse,
    /// Whether it takes any of them over.
    pub(crate) samples: bool,
    /// How each view comes about.
    pub(crate) made: Vec<Made>,
    /// Of each view the one that it is made from; one that is traced is its own.
    pub(crate) sources: Vec<usize>,
}

/// What is done before the next stage begins.
#[derive(Clone, Debug)]
pub(crate) enum Stage {
    /// Steps over each band of rows, all of a band before the next band.
    Bands(Vec<Step>),
    /// What the host does once all bands are done. It may add steps, over all bands.
    Host(Host),
    /// Nothing, once all bands are done: what follows looks into the rows above and below.
    Wait,
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
    },
    /// A view becomes its source's.
    Copy(usize),
    /// Its lists are emptied.
    EmptyLists,
    /// The 3D buffer is.
    EmptySlots,
}

/// Threads of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Launch {
    /// One a pixel of the band, or a block of pixels where the kernel traces rays.
    Pixels,
    /// One a run of a tile's width in each row of the band.
    Runs,
    /// One a tile of the band.
    Tiles,
    /// One a row of the band.
    Rows,
    /// By a list that an earlier step filled.
    Listed(u32),
}

/// What the host does between bands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Host {
    /// Adelson & Hodges' sweep, for a view.
    Sweep(usize),
    /// Sizes the 3D buffer for a view.
    SizeSlots(BufferDepth, usize),
    /// Chooses how the views that have a source are made.
    Choose,
}

impl Host {
    pub(crate) async fn run(self, driver: &mut Driver<'_>) -> Result<Vec<Step>, Error> {
        match self {
            Self::Sweep(view) => host::sweep(driver, view).await.map(|()| Vec::new()),
            Self::SizeSlots(depth, view) => host::size_slots(driver, depth, view).await.map(|()| Vec::new()),
            Self::Choose => host::choose(driver).await,
        }
    }
}

impl Step {
    /// The same under another name.
    pub(crate) fn named(self, called: &'static str) -> Self {
        match self {
            Self::Run { kernel, view, launch, .. } => Self::Run { name: called, kernel, view, launch },
            step => step,
        }
    }

    pub(crate) fn name(&self) -> Option<&'static str> {
        if let Self::Run { name, .. } = self { Some(*name) } else { None }
    }
}

impl Plan {
    /// The plan of a method for views with these sources.
    pub(crate) fn of(method: Method, sources: &[usize]) -> Self {
        let (bits, samples) = match method {
            Method::Auto => (ShadowReuse::Two, true),
            Method::Bracket(shadows) => (shadows, true),
            _ => (ShadowReuse::Rays, false),
        };
        let made = match method {
            Method::Auto | Method::Naive => Made::Traced,
            Method::Ideal => Made::Copied,
            Method::Bracket(_) => Made::Bracketed,
            Method::Atomic(_) | Method::Buffer(..) | Method::Sweep(_) => Made::Marked,
        };
        let traced: Vec<_> = views(sources).filter(|&view| sources[view] == view).flat_map(trace::source).collect();
        let mut stages = vec![Stage::Bands(traced)];
        for (view, source) in targets(sources) {
            stages.extend(target(method, view, source));
        }
        if method == Method::Auto {
            stages.push(Stage::Host(Host::Choose));
        }
        let made = views(sources).map(|view| if sources[view] == view { Made::Traced } else { made }).collect();
        Self { stages: joined(stages), bits, samples, made, sources: sources.to_vec() }
    }

    /// Its steps, with those that the host may add.
    fn steps(&self) -> impl Iterator<Item = Step> + '_ {
        self.stages.iter().flat_map(move |stage| match stage {
            Stage::Bands(steps) => steps.clone(),
            Stage::Host(Host::Choose) => targets(&self.sources)
                .flat_map(|(view, _)| join([trace::target(view), bracket::resolve(view)]))
                .collect(),
            Stage::Host(_) | Stage::Wait => Vec::new(),
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
                    match kernel.samples(with) {
                        Some(Access::Write) => drop(used.samples.insert(view)),
                        Some(Access::Read) => drop(used.samples.insert(source)),
                        None => {}
                    }
                }
                Step::Copy(view) => {
                    used.places.insert((Target::View, view));
                    used.places.extend(with.linear.then_some((Target::Linear, view)));
                }
                // Of kernels that run.
                Step::EmptyLists | Step::EmptySlots => {}
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

    /// How often the picture is gone over.
    pub(crate) fn sweeps(&self) -> u32 {
        let goes_over = |stage: &&Stage| matches!(stage, Stage::Bands(_) | Stage::Host(Host::Choose));
        self.stages.iter().filter(goes_over).count() as u32
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
fn target(method: Method, view: usize, source: usize) -> Vec<Stage> {
    match method {
        Method::Naive => vec![Stage::Bands(trace::target(view))],
        Method::Ideal => vec![Stage::Bands(vec![Step::Copy(view)])],
        Method::Auto => vec![Stage::Bands(bracket::bound(view))],
        Method::Atomic(check) => banded(reproject::atomic(view), resolve::of(view, check), check == Check::Edges),
        Method::Buffer(depth, check) => {
            let range = if depth == BufferDepth::Adaptive { reproject::depth_range(source) } else { Vec::new() };
            let sized = vec![Stage::Bands(range), Stage::Host(Host::SizeSlots(depth, view))];
            [sized, banded(reproject::slots(view), resolve::of(view, check), check == Check::Edges)].concat()
        }
        // What the sweep leaves is trusted: it has cleared the gaps.
        Method::Sweep(Sweep::Scanline) => banded(reproject::scanline(view), resolve::of(view, Check::None), false),
        Method::Sweep(Sweep::Sequential) => {
            vec![Stage::Host(Host::Sweep(view)), Stage::Bands(resolve::of(view, Check::None))]
        }
        Method::Bracket(shadows) => banded(bracket::bound(view), bracket::resolve(view), shadows == ShadowReuse::Block),
    }
}

/// What is carried to a view, and then the rest: where that reaches into the rows above and below, as an edge and a block of a
/// source's samples do, only once all of these are there.
fn banded(carried: Vec<Step>, rest: Vec<Step>, reaches: bool) -> Vec<Stage> {
    match reaches {
        true => vec![Stage::Bands(carried), Stage::Wait, Stage::Bands(rest)],
        false => vec![Stage::Bands(join([carried, rest]))],
    }
}

/// With steps over bands that follow each other as one stage.
fn joined(stages: Vec<Stage>) -> Vec<Stage> {
    let mut all: Vec<Stage> = Vec::new();
    for stage in stages {
        match (all.last_mut(), stage) {
            (Some(Stage::Bands(steps)), Stage::Bands(more)) => steps.extend(more),
            (_, stage) => all.push(stage),
        }
    }
    all
}

fn join<const N: usize>(parts: [Vec<Step>; N]) -> Vec<Step> {
    parts.concat()
}
