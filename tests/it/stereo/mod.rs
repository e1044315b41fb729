//! Tests stereo pairs by every method.

use crate::common;
mod devices;
mod frames;
mod methods;
mod scenes;

use common::render;
use stereotrace::{Method, StereoPair, scene::builtin::Builtin};

/// A picture size that is no multiple of the workgroup in either direction.
pub(crate) const SIZE: (u32, u32) = (190, 107);

pub(crate) fn render_builtin(builtin: Builtin, method: Method) -> StereoPair {
    render(&builtin.scene(), &builtin.camera(SIZE.0, SIZE.1), method)
}
