//! The `atomic` method: each pixel reuses the nearest sample that lands in it, by atomicMax (thesis, 3.1.2.2). Reused
//! pixels are then checked as [`Check`] says.

use super::{Promise, Target};
use crate::{
    Check,
    frame::plan::{Made, Stage},
    steps::{reproject, resolve},
};

pub(super) fn promise(check: Check) -> Promise {
    let made = Made::Marked { checked: check == Check::All };
    Promise { reaches: check == Check::Edges, ..Promise::of(made) }
}

pub(super) fn stages(Target { view, soft, .. }: Target, check: Check) -> Vec<Stage> {
    vec![Stage::Steps([reproject::atomic(view), resolve::of(view, check, soft)].concat())]
}
