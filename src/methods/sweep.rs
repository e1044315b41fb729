//! Adelson & Hodges' sweep, on the device or on the host. Its pixels are reused without checks, since the sweep has
//! cleared the gaps.

use super::{Promise, Target};
use crate::{
    Check, Sweep,
    frame::plan::{Host, Made, Stage},
    steps::{reproject, resolve},
};

pub(super) const PROMISE: Promise = Promise::of(Made::Marked { checked: false });

pub(super) fn stages(Target { view, soft, .. }: Target, sweep: Sweep) -> Vec<Stage> {
    let resolve = resolve::of(view, Check::None, soft);
    match sweep {
        Sweep::Scanline => vec![Stage::Steps([reproject::scanline(view), resolve].concat())],
        Sweep::Sequential => vec![Stage::Host(Host::Sweep(view)), Stage::Steps(resolve)],
    }
}
