//! What the device's ray queries look for: slightly larger triangles than those of the scene, or boxes around its
//! primitives. The kernels' own test decides on each that is found (`shaders/shared/ray_queries.wgsl`).

use glam::{DVec3, Vec3};

use super::bvh::boxes_of;
use crate::{Scene, gpu::Outlines};

/// Margin of each outline, as a share of the largest coordinate of any primitive, but at most the primitive's own size,
/// so that small primitives beside huge ones do not all overlap. It covers the rounding of the
/// device's and of the kernels' tests, for rays from up to a few times the scene's size away.
const MARGIN: f64 = 1.0 / 131_072.0;
/// Maximum distance that a corner of a triangle moves, in margins. The corner of a thin triangle would move far.
const FARTHEST_MOVE: f64 = 64.0;

/// Returns the outlines of all primitives but planes in the tree's order, given the ids of all primitives in that
/// order; `None` if there are only planes.
pub(crate) fn outlines_of(scene: &Scene, ids: &[u32]) -> Option<Outlines> {
    let ids = &ids[scene.planes().len()..];
    if ids.is_empty() {
        return None;
    }
    if scene.spheres().is_empty() && scene.ellipsoids().is_empty() {
        let all = || ids.iter().map(|&id| scene.triangles()[id as usize].corners.map(|corner| corner.as_dvec3()));
        let margin = farthest(all().flatten()) * MARGIN;
        let rounded = |corners: [DVec3; 3]| corners.map(|corner| corner.as_vec3().to_array());
        let wide = |corners: [DVec3; 3]| rounded(widened(corners, margin.min(size_of(&corners))));
        return Some(Outlines::Triangles(all().map(wide).collect()));
    }
    let boxes: Vec<[Vec3; 2]> = boxes_of(scene).map(|one| [one.min.into(), one.max.into()]).collect();
    let own = || ids.iter().map(|&id| boxes[id as usize].map(|corner| corner.as_dvec3()));
    let margin = farthest(own().flatten()) * MARGIN;
    let wide = |[low, high]: [DVec3; 2]| {
        let margin = margin.min(size_of(&[low, high]));
        [low - margin, high + margin].map(|corner| corner.as_vec3().to_array())
    };
    Some(Outlines::Boxes(own().map(wide).collect()))
}

/// Returns the largest coordinate.
fn farthest(corners: impl Iterator<Item = DVec3>) -> f64 {
    corners.fold(0.0, |most, corner| most.max(corner.abs().max_element()))
}

/// Returns the longest side of the box around a primitive's corners.
fn size_of(corners: &[DVec3]) -> f64 {
    let low = corners.iter().fold(DVec3::MAX, |low, corner| low.min(*corner));
    let high = corners.iter().fold(DVec3::MIN, |high, corner| high.max(*corner));
    (high - low).max_element()
}

/// Moves a triangle's edges outwards by a margin, in its plane.
fn widened(corners: [DVec3; 3], margin: f64) -> [DVec3; 3] {
    std::array::from_fn(|index| {
        let corner = corners[index];
        let [one, other] = [1, 2].map(|step| (corners[(index + step) % 3] - corner).normalize_or_zero());
        let outwards = -(one + other).normalize_or_zero();
        let sine_of_half = ((1.0 - one.dot(other)) / 2.0).max(0.0).sqrt();
        corner + outwards * (margin / sine_of_half).min(margin * FARTHEST_MOVE)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_move_outwards_by_the_margin_and_corners_not_far() {
        let flat = |x: f64, y: f64| DVec3::new(x, y, 0.5 * x - y);
        let right = [flat(0.0, 0.0), flat(3.0, 0.0), flat(0.0, 2.0)];
        let blunt = [flat(0.0, 0.0), flat(1.0, 0.1), flat(2.0, 0.0)];
        for corners in [right, blunt] {
            let moved = widened(corners, 1e-3);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            for index in 0..3 {
                let [p, q] = [0, 1].map(|step| corners[(index + step) % 3]);
                let [p_moved, q_moved] = [0, 1].map(|step| moved[(index + step) % 3]);
                let outwards = (q - p).cross(normal).normalize();
                for beside in [p_moved - p, q_moved - q] {
                    assert!((beside.dot(outwards) - 1e-3).abs() < 1e-8, "{beside}");
                    assert!(beside.dot(normal).abs() < 1e-12);
                }
            }
        }
        let needle = [flat(0.0, 0.0), flat(1000.0, 1e-9), flat(1000.0, -1e-9)];
        let farthest = |[from, to]: [[DVec3; 3]; 2]| (0..3).map(|at| from[at].distance(to[at])).fold(0.0, f64::max);
        assert!(farthest([needle, widened(needle, 1e-3)]) <= 0.064 + 1e-12);
        let point = [DVec3::ONE; 3];
        assert_eq!(widened(point, 1e-3), point);
    }
}
