//! Twin of `shaders/trace/trace_left.wgsl`: finds what each pixel of a view hits. It does not shade.

use super::{Eye, Frame, intersect::closest_hit};
use crate::{FAR, Scene};

/// Returns (depth, primitive id) of each pixel, row-major; ([`FAR`], [`crate::MISS`]) for a miss.
pub fn trace_left(scene: &Scene, frame: &Frame, eye: Eye) -> Vec<(f32, u32)> {
    let [width, height] = frame.size();
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    pixels
        .map(|(column, row)| closest_hit(scene, frame.eye(eye), frame.direction(eye, column, row), 0.0, FAR))
        .collect()
}
