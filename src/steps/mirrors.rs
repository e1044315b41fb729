//! Steps after a view's last step, in scenes with mirrors, glass or veils (partly transparent surfaces). They trace the
//! rays that these surfaces reflect and transmit. First hits may be reused from another view, but each eye traces these
//! rays itself.

use super::step;
use crate::{
    frame::plan::{Launch, Step},
    kernel::layout::TO_TRACE,
    kernel::{Kernel, Resource::Lists, Role, Shading, kernel},
};

pub(crate) const LIST_MIRRORS: Kernel = kernel!("mirrors", "list_mirrors", Role::Shade(Shading::ListMirrors));
pub(crate) const TRACE_MIRRORED: Kernel = kernel!("mirrors", "trace_mirrored", Role::Shade(Shading::Mirrored));

pub(crate) fn of(view: usize) -> Vec<Step> {
    vec![
        Step::EmptyLists,
        step(&LIST_MIRRORS, view, Launch::Pixels),
        step(&TRACE_MIRRORED, view, Launch::Listed(Lists, TO_TRACE)),
    ]
}
