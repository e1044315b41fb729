//! A whole view, traced and shaded.

use super::{COUNT, LIGHT_TRACED};
use crate::{
    frame::{
        plan::{Eye, Launch, Step},
        targets::Target,
    },
    kernels::{Access::Write, Kernel, Touches},
    variant::{Part, part},
};

const KEEP_PIXELS: Part = part!("shared/keep_pixels.wgsl");

pub(crate) const TRACE_LEFT: Kernel = Kernel {
    name: "trace_left",
    touches: Touches::Shading,
    storage: &[(Target::Color, Write), (Target::Hits, Write), (Target::Counters, Write)],
    extra: &[COUNT, LIGHT_TRACED, KEEP_PIXELS],
    main: part!("trace_left.wgsl"),
};
/// The same, its threads going on in the next dispatch.
pub(crate) const TRACE_IN_STEPS: Kernel =
    Kernel { name: "trace_in_steps", main: part!("trace_in_steps.wgsl"), ..TRACE_LEFT };

/// One view.
pub(crate) fn view(eye: Eye) -> Vec<Step> {
    let name = match eye {
        Eye::Left => "trace_left",
        Eye::Right => "trace_right",
    };
    vec![Step::Run { name, kernel: &TRACE_LEFT, eye, launch: Launch::Pixels }]
}
