//! Device, buffers, dispatches, read-back and timestamps. This module knows nothing of stereo.

mod adapter;
mod device;
mod pipelines;
mod staging;
mod timing;
mod transfer;
mod wait;

pub use adapter::{ADAPTER_VARIABLE, Adapter};
pub use device::Gpu;
pub(crate) use device::lock;
pub(crate) use pipelines::{
    Built, Pipelines, Program, TEXELS, bind_group, sampled_layers_type, sampled_type, storage_type, texture_type,
    uniform_type,
};
pub(crate) use staging::{Filling, Staging};
pub(crate) use timing::{Timestamps, add_times};
pub(crate) use transfer::{TEXTURE_WIDTH, Texels, check_bytes};
