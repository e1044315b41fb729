//! Stereo ray tracing.
#![forbid(unsafe_code)]
pub use glam;
pub use wgpu;
pub mod camera;
mod error;
pub mod pair;
pub mod metrics;
pub mod output;
pub mod scene;
pub use camera::{Comfort, FAR, Pose, StereoCamera};
pub use error::Error;
pub use pair::{MISS, PassTimes, PixelSource, Rays, Statistics, StereoPair, View, Work};
pub use scene::{Material, MaterialId, Mesh, PointLight, Scene, Sky, Sphere, Triangle};
