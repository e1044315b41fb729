//! Pass 4: both views as 8-bit sRGB.

use super::{MARKS, right};
use crate::{
    frame::{
        plan::{Launch, RightView, Step},
        targets::Target::{LeftColor, Pictures, RightColor, RightSource},
    },
    kernels::{
        Access::{Read, Write},
        Kernel, Touches,
    },
    variant::part,
};

/// Every right pixel was traced.
pub(crate) const COMPOSE: Kernel = Kernel {
    name: "compose",
    touches: Touches::Pixels,
    storage: &[(Pictures, Write), (LeftColor, Read), (RightColor, Read)],
    extra: &[MARKS, part!("shared/right_traced.wgsl")],
    main: part!("compose.wgsl"),
};
/// The right view is the left one.
pub(crate) const COMPOSE_LEFT: Kernel = Kernel {
    name: "compose_left",
    storage: &[(Pictures, Write), (LeftColor, Read)],
    extra: &[MARKS, part!("shared/right_is_left.wgsl")],
    ..COMPOSE
};
/// Right pixels are where their marks say.
pub(crate) const COMPOSE_MARKED: Kernel = Kernel {
    name: "compose_marked",
    storage: &[(Pictures, Write), (LeftColor, Read), (RightColor, Read), (RightSource, Read)],
    extra: &[MARKS, part!("shared/right_marked.wgsl")],
    ..COMPOSE
};

pub(crate) fn of(view: RightView) -> Vec<Step> {
    let kernel = match view {
        RightView::Traced | RightView::Bracketed => &COMPOSE,
        RightView::Left => &COMPOSE_LEFT,
        RightView::Marked => &COMPOSE_MARKED,
    };
    vec![right(kernel, Launch::Pixels).named(COMPOSE.name)]
}
