//! Writes views to textures on the device, and packs them for reading back.

use crate::kernel::{Kernel, Role, kernel};

pub(crate) const PACK: Kernel = kernel!("show", "pack", Role::Pixels);
pub(crate) const SHOW_COLOR: Kernel = kernel!("show", "show_color", Role::Pixels);
pub(crate) const SHOW_SAMPLES: Kernel = kernel!("show", "show_samples", Role::LinearPixels);
pub(crate) const FILTER_SAMPLES: Kernel = kernel!("show", "filter_samples", Role::LinearPixels);
pub(crate) const SHOW_DEPTH: Kernel = kernel!("show", "show_depth", Role::Pixels);
