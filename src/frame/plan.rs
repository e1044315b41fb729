//! What a method's frame does: steps over bands of rows, as data.

use std::collections::BTreeSet;

use super::{driver::Driver, targets::Target};
use crate::{
    BufferDepth, Check, Error, Method, ShadowReuse, Sweep,
    kernels::{Kernel, Touches},
    steps::{bracket, compose, host, reproject, resolve, trace},
};

/// A view of the pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Eye {
    Left,
    Right,
}

/// Where the right view's pixels are in the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RightView {
    /// All were traced.
    Traced,
    /// All were resolved, with marks of how.
    Bracketed,
    /// They are the left ones.
    Left,
    /// Traced, or the left ones that their marks name.
    Marked,
}

/// What a frame does, and what its kernels are made for.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) stages: Vec<Stage>,
    /// Which shadow bits right pixels take over: what is kept of left samples depends on it.
    pub(crate) bits: ShadowReuse,
    /// Where right pixels are in the end.
    pub(crate) right: RightView,
}

/// What is done before the next stage begins.
#[derive(Clone, Debug)]
pub(crate) enum Stage {
    /// Steps over each band of rows, all of a band before the next band.
    Bands(Vec<Step>),
    /// What the host does once all bands are done. It may add steps, over all bands.
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
        eye: Eye,
        launch: Launch,
    },
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
    /// Adelson & Hodges' sweep.
    Sweep,
    /// Sizes the 3D buffer.
    SizeSlots(BufferDepth),
    /// Chooses how the right view is made.
    Choose,
}

impl Host {
    pub(crate) async fn run(self, driver: &mut Driver<'_>) -> Result<Vec<Step>, Error> {
        match self {
            Self::Sweep => host::sweep(driver).await.map(|()| Vec::new()),
            Self::SizeSlots(depth) => host::size_slots(driver, depth).await.map(|()| Vec::new()),
            Self::Choose => host::choose(driver).await,
        }
    }
}

impl Step {
    /// The same under another name.
    pub(crate) fn named(self, called: &'static str) -> Self {
        match self {
            Self::Run { kernel, eye, launch, .. } => Self::Run { name: called, kernel, eye, launch },
            step => step,
        }
    }

    pub(crate) fn name(&self) -> Option<&'static str> {
        if let Self::Run { name, .. } = self { Some(*name) } else { None }
    }
}

impl Plan {
    /// The plan of a method.
    pub(crate) fn of(method: Method) -> Self {
        let bits = match method {
            Method::Auto => ShadowReuse::Two,
            Method::Bracket(shadows) => shadows,
            _ => ShadowReuse::Rays,
        };
        let right = match method {
            Method::Auto | Method::Naive => RightView::Traced,
            Method::Ideal => RightView::Left,
            Method::Bracket(_) => RightView::Bracketed,
            Method::Atomic(_) | Method::Buffer(..) | Method::Sweep(_) => RightView::Marked,
        };
        let left = trace::view(Eye::Left);
        let composed = compose::of(right);
        let stages = match method {
            Method::Naive => vec![Stage::Bands(join([left, trace::view(Eye::Right), composed]))],
            Method::Ideal => vec![Stage::Bands(join([left, composed]))],
            Method::Auto => vec![Stage::Bands(join([left, bracket::bound()])), Stage::Host(Host::Choose)],
            Method::Atomic(check) => {
                let carried = join([left, reproject::atomic()]);
                banded(carried, join([resolve::of(check), composed]), check == Check::Edges)
            }
            Method::Buffer(depth, check) => {
                let range = if depth == BufferDepth::Adaptive { reproject::depth_range() } else { Vec::new() };
                let rest = join([resolve::of(check), composed]);
                let sized = vec![Stage::Bands(join([left, range])), Stage::Host(Host::SizeSlots(depth))];
                [sized, banded(reproject::slots(), rest, check == Check::Edges)].concat()
            }
            // What the sweep leaves is trusted: it has cleared the gaps.
            Method::Sweep(Sweep::Scanline) => {
                vec![Stage::Bands(join([left, reproject::scanline(), resolve::of(Check::None), composed]))]
            }
            Method::Sweep(Sweep::Sequential) => {
                let rest = join([resolve::of(Check::None), composed]);
                vec![Stage::Bands(left), Stage::Host(Host::Sweep), Stage::Bands(rest)]
            }
            Method::Bracket(shadows) => {
                let rest = join([bracket::resolve(), composed]);
                banded(join([left, bracket::bound()]), rest, shadows == ShadowReuse::Block)
            }
        };
        Self { stages, bits, right }
    }

    /// Its steps, with those that the host may add.
    fn steps(&self) -> impl Iterator<Item = Step> + '_ {
        self.stages.iter().flat_map(|stage| match stage {
            Stage::Bands(steps) => steps.clone(),
            Stage::Host(Host::Choose) => join([by_naive(), by_bracket()]),
            Stage::Host(_) => Vec::new(),
        })
    }

    /// The buffers that it uses.
    pub(crate) fn targets(&self) -> BTreeSet<Target> {
        let mut targets: BTreeSet<_> = self
            .steps()
            .flat_map(|step| match step {
                Step::Run { kernel, eye, .. } => kernel.storage.iter().map(|(target, _)| target.of(eye)).collect(),
                Step::EmptyLists => vec![Target::Lists],
                Step::EmptySlots => Vec::new(),
            })
            .collect();
        targets.remove(&Target::Slots);
        targets
    }

    /// Whether a step reads the table of objects.
    pub(crate) fn touches_objects(&self) -> bool {
        self.steps().any(|step| matches!(step, Step::Run { kernel, .. } if kernel.touches == Touches::Objects))
    }

    /// How often the picture is gone over.
    pub(crate) fn sweeps(&self) -> u32 {
        let goes_over = |stage: &&Stage| !matches!(stage, Stage::Host(Host::Sweep | Host::SizeSlots(_)));
        self.stages.iter().filter(goes_over).count() as u32
    }
}

/// How `Auto` goes on where it chooses `Naive`.
pub(crate) fn by_naive() -> Vec<Step> {
    join([trace::view(Eye::Right), compose::of(RightView::Traced)])
}

/// How `Auto` goes on where it chooses `bracket`.
pub(crate) fn by_bracket() -> Vec<Step> {
    join([bracket::resolve(), compose::of(RightView::Traced)])
}

/// Two runs of steps, band by band together. Where the second one reaches into the rows above and below (an edge, and a block
/// of left samples do), these must be there: all bands of the first before it begins.
fn banded(first: Vec<Step>, second: Vec<Step>, reaches_out: bool) -> Vec<Stage> {
    match reaches_out {
        true => vec![Stage::Bands(first), Stage::Bands(second)],
        false => vec![Stage::Bands(join([first, second]))],
    }
}

fn join<const N: usize>(parts: [Vec<Step>; N]) -> Vec<Step> {
    parts.concat()
}
