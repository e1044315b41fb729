//! The `bracket` method: reprojected samples bound the depth of each tile's search, and each pixel's own ray determines
//! its hit (docs/BRACKET.md).

use super::{Promise, Target};
use crate::{
    ShadowReuse,
    frame::plan::{Made, Stage},
    steps::bracket,
};

pub(super) fn promise(bits: ShadowReuse) -> Promise {
    Promise { bits, samples: true, reaches: bits == ShadowReuse::Block, ..Promise::of(Made::Bracketed) }
}

pub(super) fn stages(Target { view, soft, search, .. }: Target, bits: ShadowReuse) -> Vec<Stage> {
    vec![Stage::Steps([bracket::bound(view, bits), bracket::resolve(view, soft, search)].concat())]
}
