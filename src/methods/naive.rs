//! The `naive` method: every view is traced, or drawn into a T-buffer.

use super::{Promise, Target};
use crate::{
    frame::plan::{Made, Stage},
    steps::trace,
    t_buffer,
};

pub(super) fn promise(drawn: bool) -> Promise {
    Promise::of(if drawn { Made::Drawn } else { Made::Traced })
}

pub(super) fn stages(Target { view, soft, drawn, .. }: Target) -> Vec<Stage> {
    let steps = drawn.map_or_else(|| trace::target(view, soft), |drawn| t_buffer::view(view, drawn, soft));
    vec![Stage::Steps(steps)]
}
