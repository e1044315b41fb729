//! The `naive` method: every view is traced, or drawn into a T-buffer.

use super::{Promise, Target};
use crate::{
    frame::plan::{Made, Stage},
    steps::trace,
};

pub(super) fn promise(drawn: bool) -> Promise {
    Promise::of(if drawn { Made::Drawn } else { Made::Traced })
}

pub(super) fn stages(Target { view, soft, drawn, .. }: Target) -> Vec<Stage> {
    vec![Stage::Steps(trace::target(view, soft, drawn))]
}
