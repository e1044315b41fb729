//! Progress of a frame, and its cancellation.

use std::ops::ControlFlow;

/// Progress of a frame, or of a report ([`Report::measure`](crate::Report::measure)).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Last step of the finished band of rows, or `denoise` before rows are denoised. In a report, the next scene.
    pub pass: &'static str,
    /// Share of the frame's rows that are done, 0 to 1. It restarts if a frame is rendered again
    /// ([`Statistics::in_steps`](crate::Statistics::in_steps)).
    pub done: f32,
}

/// Callback that receives the progress of a frame and may stop it. It is `Send`, except on wasm32.
#[cfg(not(target_arch = "wasm32"))]
pub type OnProgress<'a> = dyn FnMut(Progress) -> ControlFlow<()> + Send + 'a;

/// Callback that receives the progress of a frame and may stop it.
#[cfg(target_arch = "wasm32")]
pub type OnProgress<'a> = dyn FnMut(Progress) -> ControlFlow<()> + 'a;
