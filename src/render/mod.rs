//! Renders scenes: the renderer, scenes on a device, frames, samples, rays of the caller, and results.

mod adaptive;
pub mod cast;
mod encode;
pub(crate) mod frame;
pub mod pair;
mod renderer;
mod results;
mod samples;
pub(crate) mod shadow_buffer;
mod tally;
#[cfg(test)]
mod tests;
mod upload;
mod views;

pub use encode::{Encoded, EncodedView};
pub use renderer::{Renderer, render_stereo_async, render_views_async};
pub use upload::{Update, UploadInfo, UploadedScene};
pub use views::{RigView, Views};
