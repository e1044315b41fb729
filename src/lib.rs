//! Stereo ray tracing.
#![forbid(unsafe_code)]
pub use glam;
pub use wgpu;

mod bvh;
pub mod camera;
#[cfg(feature = "json")]
mod camera_file;
pub mod cpu;
mod error;
pub mod gpu;
mod kernels;
mod layout;
pub mod method;
pub mod metrics;
pub mod output;
pub mod pair;
pub mod scene;
pub mod stereo;

pub use camera::{Comfort, FAR, Pose, StereoCamera};
pub use error::Error;
pub use gpu::Gpu;
pub use method::{BufferDepth, Method, Overlap, Verify};
pub use pair::{MISS, PassTimes, PixelSource, Rays, Statistics, StereoPair, View, Work};
pub use scene::{Material, MaterialId, Mesh, PointLight, Scene, Sky, Sphere, Triangle};
pub use stereo::{Options, Progress, Renderer, UploadedScene, render_stereo};
