//! The methods. Each has a file with the stages that make a view from its source, and with its `Promise`.

mod atomic;
pub(crate) mod auto;
mod bracket;
mod buffer;
mod ideal;
mod naive;
mod sweep;

use crate::{
    Method, ShadowReuse,
    frame::history::Recall,
    frame::plan::{InSteps, Made, Plan, Search, Stage, Step, targets},
    steps::{
        history,
        mirrors::{self, Mirrors},
        paths::{self, Paths},
        trace,
    },
    t_buffer::{self, Drawn},
};

/// The views of a frame, and the settings that their steps depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Views<'a> {
    /// The source of each view. A traced view is its own source.
    pub(crate) sources: &'a [usize],
    /// How rays are followed that surfaces reflect or transmit, if there are any.
    pub(crate) mirrors: Option<Mirrors>,
    /// Paths of light, if they are followed.
    pub(crate) paths: Option<Paths>,
    /// Number of parts in which soft light is sampled, or `None` without soft light.
    pub(crate) soft: Option<usize>,
    /// How `bracket` searches tiles.
    pub(crate) search: Search,
    /// Primitives to draw if a T-buffer finds the hits of traced views.
    pub(crate) drawn: Option<Drawn>,
    /// How samples of frames are used for later ones.
    pub(crate) recall: Recall,
    /// Whether a history also keeps the light of paths.
    pub(crate) keeps_light: bool,
}

/// A view that a method makes from another.
#[derive(Clone, Copy, Debug)]
struct Target {
    view: usize,
    source: usize,
    soft: Option<usize>,
    search: Search,
    drawn: Option<Drawn>,
}

/// How a method makes views, and the data that it needs.
#[derive(Clone, Copy, Debug)]
struct Promise {
    made: Made,
    /// Which visibility bits the method reuses.
    bits: ShadowReuse,
    /// Whether source views keep their samples for reuse.
    samples: bool,
    /// Whether some step reads the rows above and below a band.
    reaches: bool,
    /// Whether each view traces its own reflected and transmitted rays. Otherwise it copies the source's colour.
    follows: bool,
}

impl Promise {
    /// Creates the promise of a method that reuses no visibility bits and keeps no samples.
    const fn of(made: Made) -> Self {
        Self { made, bits: ShadowReuse::Rays, samples: false, reaches: false, follows: true }
    }
}

/// Returns the plan of a method.
pub(crate) fn plan(method: Method, views: &Views<'_>) -> Plan {
    let Views { sources, mirrors, paths, soft, search, drawn, .. } = *views;
    let Promise { made, bits, samples, reaches, follows } = promise(method, drawn.is_some());
    let behind = |view| mirrors.map_or(Vec::new(), |mirrors| mirrors::of(view, mirrors));
    let all = 0..sources.len();
    let traced = all.clone().filter(|&view| sources[view] == view);
    let recall = if samples && !reaches && drawn.is_none() { views.recall } else { Recall::Nothing };
    let shares = shares_light(method, paths);
    let (reads, recalls, recalls_light) = match recall {
        Recall::Read { bits: same, light } => {
            (true, same && bits == ShadowReuse::Two, light && shares && views.keeps_light)
        }
        Recall::Nothing | Recall::Keep => (false, false, false),
    };
    let source = |view| match drawn {
        Some(drawn) => t_buffer::view(view, drawn, soft),
        None if reads => history::source(view, soft, search, recalls),
        None => trace::source(view, soft),
    };
    let before = traced.clone().filter(|_| reads).flat_map(|view| history::bound(view, recalls)).collect();
    let keep = |view| {
        [Some(Step::Remember(view)), (shares && views.keeps_light).then(|| paths::kept(view))].into_iter().flatten()
    };
    let kept = traced.clone().filter(|_| recall != Recall::Nothing).flat_map(keep).collect();
    let traced = traced.flat_map(|view| [source(view), behind(view)].concat()).collect();
    let mut stages = vec![Stage::Steps(traced)];
    for (view, source) in targets(sources) {
        stages.extend(stages_of(method, Target { view, source, soft, search, drawn }));
        if follows {
            stages.push(Stage::Steps(behind(view)));
        }
    }
    // Methods that copy colour copy it before paths add to it.
    let (sharing, own): (Vec<usize>, Vec<usize>) = all.clone().partition(|&view| shares && sources[view] != view);
    let followed = |view| paths.map_or(Vec::new(), |paths| paths::of(view, paths));
    let shared = |view| paths.map_or(Vec::new(), |paths| paths::shared(view, paths));
    let own_paths = |view| match paths {
        Some(paths) if recalls_light => paths::recalled(view, paths),
        _ => followed(view),
    };
    stages.extend(own.into_iter().map(|view| Stage::Steps(own_paths(view))));
    stages.extend(sharing.into_iter().map(|view| Stage::Steps(shared(view))));
    stages.push(Stage::Steps(kept));
    let traced = match (drawn, recall) {
        (Some(_), _) => Made::Drawn,
        (None, Recall::Read { .. }) => Made::Recalled,
        (None, _) => Made::Traced,
    };
    let made = all.clone().map(|view| if sources[view] == view { traced } else { made }).collect();
    let in_steps = all.map(|view| InSteps {
        trace: trace::in_steps(view, sources[view]),
        after: [trace::after_steps(view, soft), behind(view), followed(view)].concat(),
    });
    let in_steps = in_steps.collect();
    Plan { before, stages: joined(stages), bits, samples, search, reaches, made, sources: sources.to_vec(), in_steps }
}

/// Returns whether a method reuses the light of paths, from view to view and from frame to frame.
pub(crate) fn shares_light(method: Method, paths: Option<Paths>) -> bool {
    promise(method, false).bits == ShadowReuse::Two && paths.is_some_and(|paths| paths.is_shared)
}

fn promise(method: Method, drawn: bool) -> Promise {
    match method {
        Method::Naive => naive::promise(drawn),
        Method::Ideal => ideal::PROMISE,
        Method::Atomic(check) => atomic::promise(check),
        Method::Buffer(_, check) => buffer::promise(check),
        Method::Sweep(_) => sweep::PROMISE,
        Method::Bracket(bits) => bracket::promise(bits),
        Method::Auto => auto::PROMISE,
    }
}

fn stages_of(method: Method, target: Target) -> Vec<Stage> {
    match method {
        Method::Naive => naive::stages(target),
        Method::Ideal => ideal::stages(target),
        Method::Atomic(check) => atomic::stages(target, check),
        Method::Buffer(depth, check) => buffer::stages(target, depth, check),
        Method::Sweep(sweep) => sweep::stages(target, sweep),
        Method::Bracket(bits) => bracket::stages(target, bits),
        Method::Auto => auto::stages(target),
    }
}

/// Joins consecutive stages of steps.
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
