//! Twin of shaders/reproject/reproject.wgsl: assigns left samples to right pixels.

use super::Frame;
use crate::{Pose, frame::driver::slots};

/// Returns the bound on the columns between two samples that land in one column (thesis, Lemma 1).
pub fn lemma1(pose: &Pose, nearest: f32, farthest: f32) -> f64 {
    slots::lemma1(pose, nearest, farthest)
}

/// Returns the columns in the order of a sweep.
pub(super) fn in_sweep(frame: &Frame) -> impl Iterator<Item = usize> + use<> {
    let (width, mirrored) = (frame.size()[0], frame.raw.parallax_px < 0.0);
    (0..width).map(move |place| if mirrored { width - 1 - place } else { place })
}

/// Returns X, where left sample `column` at depth `z` lands: its centre moved by the parallax (DESIGN, section 2).
pub(super) fn landing_x(frame: &Frame, column: usize, z: f32) -> f32 {
    column as f32 + 0.5 + frame.parallax(z)
}

/// Returns the column where left sample `column` at depth `z` lands, `floor(column + 0.5 + parallax)`, or `None`
/// outside the picture (DESIGN, section 2).
pub fn right_column(frame: &Frame, column: usize, z: f32) -> Option<usize> {
    let x = landing_x(frame, column, z);
    (x >= 0.0 && x < frame.size[0] as f32).then(|| x.floor() as usize)
}

/// Returns the nearest sample's key for each target pixel, or 0. A key is the position of the sample's column in the
/// sweep, from 1. The sweep runs from left to right for a target on the right, and otherwise from right to left. A
/// later sample overwrites, since it is nearer.
pub fn reproject(frame: &Frame, left_depth: &[f32]) -> Vec<u32> {
    let [width, height] = frame.size();
    let mut right_source = vec![0; width * height];
    for row in 0..height {
        for (place, column) in in_sweep(frame).enumerate() {
            if let Some(right) = right_column(frame, column, left_depth[row * width + column]) {
                right_source[row * width + right] = place as u32 + 1;
            }
        }
    }
    right_source
}
