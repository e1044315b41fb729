//! Twin of `shaders/resolve/resolve_right.wgsl` and of `are_bad` in `shared/verify.wgsl`: decides which right pixels
//! are reused.

use glam::Vec3;

use super::{Eye, Frame, intersect::closest_hit, reproject::in_sweep};
use crate::{FAR, MISS, PixelSource, Scene};

/// Share of the distance to the reused point that must be free of occluders.
pub const VERIFY_FRACTION: f32 = 0.999;

/// Returns the source of each target pixel. `left` has (depth, id) of each source pixel; `keys` is the result of the
/// twin of reprojection.
pub fn resolve_right(scene: &Scene, frame: &Frame, left: &[(f32, u32)], keys: &[u32]) -> Vec<PixelSource> {
    let width = frame.size()[0];
    let columns: Vec<usize> = in_sweep(frame).collect();
    let fate = |(index, &key): (usize, &u32)| {
        if key == 0 {
            return PixelSource::Missed;
        }
        let (row, column) = (index / width, columns[key as usize - 1]);
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
    keys.iter().enumerate().map(fate).collect()
}
