//! Device, buffers, dispatches, read-back and timestamps. This module is independent of scenes, kernels and stereo.

mod acceleration;
mod adapter;
mod device;
mod pipelines;
mod staging;
mod timing;
mod transfer;
mod wait;
mod work;

pub(crate) use acceleration::{ACCELERATION, Acceleration, Outlines};
pub use adapter::{ADAPTER_VARIABLE, Adapter};
pub use device::Gpu;
#[cfg(test)]
pub(crate) use device::limits_over;
pub(crate) use device::{MAX_WORKGROUPS, lock};
pub(crate) use pipelines::{
    Built, Program, TEXELS, bind_group, sampled_float_type, sampled_layers_type, sampled_type, storage_type,
    texture_type, uniform_type,
};
pub(crate) use staging::{Filling, Staging};
pub use timing::PassTimes;
pub(crate) use timing::{Timestamps, add_times};
#[doc(hidden)] // a part of `Traversal`, which the feature `testing` makes public
pub use transfer::Fetch;
pub(crate) use transfer::{TEXTURE_WIDTH, Texel, Texels, check_bytes};
pub(crate) use wait::Submission;
pub use work::GpuWork;
