//! Renders scenes: the renderer, scenes on a device, frames, samples, the caller's rays, and results.

mod adaptive;
mod array;
mod builder;
mod calibrate;
pub(crate) mod cast;
pub(crate) mod denoise;
mod encode;
mod exposure;
pub(crate) mod frame;
pub(crate) mod pair;
mod passes;
mod renderer;
mod results;
mod samples;
mod shutter;
mod tally;
#[cfg(test)]
mod tests;
mod upload;
mod views;

pub use builder::FrameBuilder;
pub use encode::{Encoded, EncodedView};
pub use passes::Passes;
pub use renderer::Renderer;
pub use shutter::MotionBlur;
pub use upload::{Update, UploadInfo, UploadedScene};
pub use views::{RigView, Views};
