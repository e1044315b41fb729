//! Device, buffers, dispatches, read-back and timestamps. Knows nothing of stereo.

mod device;
mod pipelines;
mod timing;
mod transfer;

pub(crate) use device::lock;
pub use device::{ADAPTER_VARIABLE, Gpu};
pub(crate) use pipelines::{
    Pipeline, Pipelines, Program, bind_group, bind_group_at, entry, layout_of, storage_type, texture_type, uniform_type,
};
pub(crate) use timing::Timestamps;
pub(crate) use transfer::{TEXTURE_WIDTH, check_bytes};
