//! Twin of `shaders/resolve_right.wgsl` with `shared/verify_all.wgsl`: which right pixels are taken over.

use glam::Vec3;

use super::{Eye, Frame, intersect::closest_hit};
use crate::{FAR, MISS, PixelSource, Scene};

/// Share of the way to the reused point that must be free.
pub const VERIFY_FRACTION: f32 = 0.999;

/// Each right pixel's fate; `left` is (depth, id) of each left pixel, `right_source` the twin of reprojection's.
pub fn resolve_right(scene: &Scene, frame: &Frame, left: &[(f32, u32)], right_source: &[u32]) -> Vec<PixelSource> {
    let width = frame.size()[0];
    let fate = |(index, &source): (usize, &u32)| {
        if source == 0 {
            return PixelSource::Missed;
        }
        let (row, column) = (index / width, source as usize - 1);
        let (depth, primitive) = left[row * width + column];
        let direction = frame.direction(Eye::Left, column, row);
        let axis: Vec3 = frame.raw.right_axis.into();
        let (aim, limit) = match primitive {
            MISS => (direction, FAR),
            _ => (direction * depth - axis * frame.raw.shift, VERIFY_FRACTION),
        };
        match closest_hit(scene, frame.eye(Eye::Right), aim, 0.0, limit).1 {
            MISS => PixelSource::Reused,
            _ => PixelSource::Bad,
        }
    };
    right_source.iter().enumerate().map(fate).collect()
}
