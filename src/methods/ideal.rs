//! The `ideal` method: it copies the source. Its time bounds the time that reuse can save.

use super::{Promise, Target};
use crate::frame::plan::{Made, Stage, Step};

pub(super) const PROMISE: Promise = Promise { follows: false, ..Promise::of(Made::Copied) };

pub(super) fn stages(target: Target) -> Vec<Stage> {
    vec![Stage::Steps(vec![Step::Copy(target.view)])]
}
