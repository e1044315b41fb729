//! The `buffer` method: a 3D buffer keeps all samples that land in a pixel, and is searched for the nearest (thesis,
//! 3.1.2.1). Reused pixels are then checked as [`Check`] says.

use super::{Promise, Target, atomic};
use crate::{
    BufferDepth, Check,
    frame::plan::{Host, Stage},
    steps::{reproject, resolve},
};

pub(super) fn promise(check: Check) -> Promise {
    atomic::promise(check)
}

pub(super) fn stages(Target { view, source, soft, .. }: Target, depth: BufferDepth, check: Check) -> Vec<Stage> {
    let range = if depth == BufferDepth::Adaptive { reproject::depth_range(source) } else { Vec::new() };
    vec![
        Stage::Steps(range),
        Stage::Host(Host::Slots(depth, view, reproject::slots(view))),
        Stage::Steps(resolve::of(view, check, soft)),
    ]
}
