//! Large primitives: where an eye or a light comes so close to one that f32 is too coarse for its size, kernels compute t twice as
//! exactly (`shaders/shared/double_float.wgsl`). Elsewhere they don't pay for it.

use glam::{DVec3, Vec3};

use crate::Scene;

/// A triangle is large for a point that is nearer than its longest edge over this; `LARGE` of the kernels.
pub(crate) const LARGE: f32 = 64.0;
/// So many of the largest primitives are looked at. Where more are as large, hits on the others are a little less exact.
const MOST: usize = 1024;

/// The largest primitives of a scene.
#[derive(Clone, Debug)]
pub(crate) struct LargePrimitives {
    triangles: Vec<[DVec3; 3]>,
    spheres: Vec<(DVec3, f64)>,
}

impl LargePrimitives {
    pub(crate) fn of(scene: &Scene) -> Self {
        let triangles = scene.triangles().iter().filter(|triangle| !triangle.is_degenerate());
        let triangles = triangles.map(|triangle| triangle.corners.map(Vec3::as_dvec3)).collect();
        let spheres =
            scene.spheres().iter().map(|sphere| (sphere.center.as_dvec3(), f64::from(sphere.radius))).collect();
        let triangles = largest(triangles, |corners: &[DVec3; 3]| longest_edge(*corners));
        Self { triangles, spheres: largest(spheres, |sphere: &(DVec3, f64)| sphere.1) }
    }

    /// Whether one of them is large for one of these points.
    pub(crate) fn any_close_to(&self, points: &[Vec3]) -> bool {
        points.iter().map(|point| point.as_dvec3()).any(|point| {
            // Kernels round edges upwards.
            let reach = |corners: &[DVec3; 3]| 1.02 * longest_edge(*corners);
            let large_triangle =
                |corners: &[DVec3; 3]| least_distance(point, *corners) * f64::from(LARGE) < reach(corners);
            // As intersect_sphere has it.
            let large_sphere = |(center, radius): &(DVec3, f64)| {
                let squared = radius * radius;
                (point.distance_squared(*center) - squared).abs() < 0.5 * squared
            };
            self.triangles.iter().any(large_triangle) || self.spheres.iter().any(large_sphere)
        })
    }
}

fn largest<T>(mut all: Vec<T>, size: impl Fn(&T) -> f64) -> Vec<T> {
    if all.len() > MOST {
        all.select_nth_unstable_by(MOST, |a, b| size(b).total_cmp(&size(a)));
        all.truncate(MOST);
    }
    all
}

pub(crate) fn longest_edge([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

/// No more than the distance of a triangle: that of its plane or of its box.
fn least_distance(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let plane = (point - a).dot((b - a).cross(c - a).normalize_or_zero()).abs();
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    plane.max(point.distance(point.clamp(low, high)))
}
