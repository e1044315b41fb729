//! Ground truth of views, and measures of pictures against it.

pub(crate) mod channels;
pub(crate) mod correspondence;
pub(crate) mod disparity;
pub(crate) mod flow;
pub(crate) mod ground_truth;
pub(crate) mod layers;
pub mod metrics;
pub(crate) mod occlusion;
mod other_eye;
mod sight;
pub(crate) mod surface;
