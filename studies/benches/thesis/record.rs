//! Defines the records of measurements. There is one record per method and configuration.

use serde::{Deserialize, Serialize};

/// One method in one configuration. Times are medians over the rounds, in milliseconds, of the passes alone.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    /// Benchmark of the thesis: `dimensions`, `interaxial`, `lights`, `mse-dimensions` or `mse-interaxial`.
    pub(crate) suite: String,
    pub(crate) scene: String,
    pub(crate) triangles: usize,
    pub(crate) spheres: usize,
    /// Name of a `stereotrace::Method`.
    pub(crate) method: String,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) e_px: f32,
    pub(crate) lights: usize,
    pub(crate) rounds: usize,
    pub(crate) left_ms: f64,
    pub(crate) pair_ms: f64,
    pub(crate) pair_ms_min: f64,
    pub(crate) pair_ms_max: f64,
    /// Pairs per second.
    pub(crate) fps: f64,
    /// Cost of the second eye, (pair - left) / left, from times and from counted box and primitive tests.
    pub(crate) second_eye: f64,
    pub(crate) second_eye_counters: f64,
    /// Speed-up, naive pair / pair - 1, from times and from counted tests (1 = 100%).
    pub(crate) speed_up: f64,
    pub(crate) speed_up_counters: f64,
    /// Difference of the right view from naive's, in percent of the pixels.
    pub(crate) identical: f64,
    pub(crate) differing: f64,
    pub(crate) wrong_surface: f64,
    /// The same figures, in percent of the pixels in which either view shows a surface.
    pub(crate) identical_of_surfaces: f64,
    pub(crate) wrong_of_surfaces: f64,
    pub(crate) mean_difference: f64,
    pub(crate) mse: f64,
    /// PSNR in dB, or `None` if the pictures are equal.
    pub(crate) psnr: Option<f64>,
    /// Counts of both eyes.
    pub(crate) rays_primary: u64,
    pub(crate) rays_verification: u64,
    pub(crate) rays_shadow: u64,
    pub(crate) nodes: u64,
    pub(crate) primitive_tests: u64,
    /// Share of traced right pixels, 0 to 1.
    pub(crate) retraced: f64,
    pub(crate) bad: u64,
    pub(crate) missed: u64,
    pub(crate) lost_candidates: u64,
    /// Number of slots per right pixel, for buffers only, and the nanoseconds per slot and pixel for storing and
    /// searching them.
    pub(crate) buffer_depth: u32,
    pub(crate) slot_ns: Option<f64>,
    pub(crate) intermediate_bytes_per_pixel: f64,
    /// Milliseconds of each pass in order.
    pub(crate) passes_ms: Vec<(String, f64)>,
    pub(crate) adapter: String,
    pub(crate) driver: String,
    pub(crate) commit: String,
    /// Date and time in UTC, as 2012-06-30T23:59:59Z.
    pub(crate) date: String,
}
