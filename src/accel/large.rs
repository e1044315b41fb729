//! Tests whether an eye or a light is close to a large primitive. There f32 is too coarse, so kernels compute t with
//! twice the precision (`shaders/shared/double_float.wgsl`). Kernels of other scenes do not have this cost.

use glam::{DVec3, Vec3};

use crate::{Scene, Sphere, accel::bvh::reach_bits, kernel::layout::LARGE, scene::ToSphere};

/// Fraction of the cancellation in the map's products; `CANCELLED` in ellipsoid.wgsl. If an origin is closer to the
/// sphere than that, rounding of the products affects t.
const CANCELLED: f32 = 0.25;
/// Maximum number of primitives of each kind that are checked, the largest ones. If a scene has more, hits on the
/// others may be slightly less exact.
const MOST: usize = 1024;

/// The largest primitives of a scene.
#[derive(Clone, Debug)]
pub(crate) struct LargePrimitives {
    triangles: Vec<[Vec3; 3]>,
    spheres: Vec<Sphere>,
    /// Centre of each ellipsoid, and the map that turns the ellipsoid into a sphere.
    ellipsoids: Vec<(Vec3, ToSphere)>,
}

impl LargePrimitives {
    pub(crate) fn of(scene: &Scene) -> Self {
        let triangles = scene.triangles().iter().filter(|triangle| !triangle.is_degenerate());
        let edge = |corners: &[Vec3; 3]| longest_edge(corners.map(Vec3::as_dvec3));
        Self {
            triangles: largest(triangles.map(|triangle| triangle.corners), edge),
            spheres: largest(scene.spheres().iter().copied(), |sphere| f64::from(sphere.radius)),
            ellipsoids: largest(scene.ellipsoids().iter().map(|one| (one.center, one.to_sphere())), |(_, map)| {
                f64::from(map.radius)
            }),
        }
    }

    /// Returns whether one of these points is so close to a large primitive that t must be computed in sums of two f32.
    pub(crate) fn any_close_to(&self, points: &[Vec3]) -> bool {
        points.iter().any(|&point| {
            self.triangles.iter().any(|corners| is_over(point, *corners) && is_close(point, *corners))
                || self.spheres.iter().any(|sphere| is_close_sphere(point, sphere.center, sphere.radius))
                || self.ellipsoids.iter().any(|(center, map)| is_close_ellipsoid(point, *center, map))
        })
    }
}

/// Returns whether the t of rays from `origin` to a triangle must be computed in sums of two f32.
pub(crate) fn is_close(origin: Vec3, corners: [Vec3; 3]) -> bool {
    let reach = f32::from_bits(reach_bits(corners));
    let [a, b, c] = corners.map(|corner| corner - origin);
    let normal = (b - a).cross(c - a);
    let beside = a.dot(a) < 4.0 * reach * reach;
    normal.dot(a).abs() * LARGE < normal.dot(normal).sqrt() * reach && beside
}

/// Returns whether the t of rays from `origin` to a sphere must be computed in sums of two f32.
pub(crate) fn is_close_sphere(origin: Vec3, center: Vec3, radius: f32) -> bool {
    is_close_to_centered(center - origin, radius)
}

fn is_close_to_centered(to_center: Vec3, radius: f32) -> bool {
    (to_center.dot(to_center) - radius * radius).abs() < 0.5 * radius * radius
}

/// Returns whether the t of rays from `origin` to an ellipsoid must be computed in sums of two f32. The cause is either
/// the size of the sphere or cancellation in the map's products.
pub(crate) fn is_close_ellipsoid(origin: Vec3, center: Vec3, map: &ToSphere) -> bool {
    let from_origin = center - origin;
    let to_center = mapped(map, from_origin);
    let distance = (to_center.dot(to_center) - map.radius * map.radius).abs();
    let products = Vec3::from(map.rows.map(|row| row.abs().dot(from_origin.abs())));
    let far = (products - to_center.abs()).max_element() * CANCELLED;
    let beside = from_origin.dot(from_origin) < 4.0 * map.radius * map.radius;
    is_close_to_centered(to_center, map.radius) || (distance < (2.0 * map.radius + far) * far && beside)
}

pub(crate) fn mapped(map: &ToSphere, v: Vec3) -> Vec3 {
    Vec3::from(map.rows.map(|row| row.dot(v)))
}

/// Returns whether a point's projection onto a triangle's plane lies in the triangle's box or close to it. Distant
/// triangles seen edge-on don't matter, since t is clamped to the corners' t.
fn is_over(point: Vec3, corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let foot = point.as_dvec3() + normal * (a - point.as_dvec3()).dot(normal);
    let aside = longest_edge([a, b, c]) / 8.0;
    foot.cmpge(a.min(b).min(c) - aside).all() && foot.cmple(a.max(b).max(c) + aside).all()
}

/// Returns the `MOST` largest items, unordered. Memory holds at most twice as many items at a time.
fn largest<T>(all: impl Iterator<Item = T>, size: impl Fn(&T) -> f64) -> Vec<T> {
    let mut kept: Vec<(f64, T)> = Vec::new();
    let mut least = f64::NEG_INFINITY;
    let drop_smaller = |kept: &mut Vec<(f64, T)>| {
        kept.select_nth_unstable_by(MOST - 1, |(a, _), (b, _)| b.total_cmp(a));
        kept.truncate(MOST);
        kept[MOST - 1].0
    };
    for one in all {
        let size = size(&one);
        if size > least {
            kept.push((size, one));
        }
        if kept.len() == 2 * MOST {
            least = drop_smaller(&mut kept);
        }
    }
    if kept.len() > MOST {
        drop_smaller(&mut kept);
    }
    kept.into_iter().map(|(_, one)| one).collect()
}

pub(crate) fn longest_edge([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn the_largest_are_those_that_sorting_puts_first() {
        let mut random = Random::new(7);
        for count in [0, 1, MOST, MOST + 1, 2 * MOST, 50 * MOST + 3] {
            // There are so few distinct sizes that many items are equal.
            let all: Vec<f64> = (0..count).map(|_| random.below(5000) as f64).collect();
            let mut found = largest(all.iter().copied(), |&size| size);
            found.sort_by(f64::total_cmp);
            let mut expected = all;
            expected.sort_by(f64::total_cmp);
            assert_eq!(found, expected[count.saturating_sub(MOST)..], "{count}");
        }
    }
}
