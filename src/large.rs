//! Large primitives: where an eye or a light comes so close to one that f32 is too coarse for its size, kernels compute t twice as
//! exactly (`shaders/shared/double_float.wgsl`). Elsewhere they don't pay for it.

use glam::{DVec3, Vec3};

use crate::{
    Scene, Sphere,
    cpu::intersect::{is_close, is_close_sphere},
};

/// A triangle is large for a point that is nearer to its plane than its longest edge over this; `LARGE` of the kernels.
pub(crate) const LARGE: f32 = 64.0;
/// So many of the largest primitives are looked at. Where more are as large, hits on the others are a little less exact.
const MOST: usize = 1024;

/// The largest primitives of a scene.
#[derive(Clone, Debug)]
pub(crate) struct LargePrimitives {
    triangles: Vec<[Vec3; 3]>,
    spheres: Vec<Sphere>,
}

impl LargePrimitives {
    pub(crate) fn of(scene: &Scene) -> Self {
        let triangles = scene.triangles().iter().filter(|triangle| !triangle.is_degenerate());
        let triangles = triangles.map(|triangle| triangle.corners).collect();
        let edge = |corners: &[Vec3; 3]| longest_edge(corners.map(Vec3::as_dvec3));
        let spheres = scene.spheres().to_vec();
        Self {
            triangles: largest(triangles, edge),
            spheres: largest(spheres, |sphere: &Sphere| f64::from(sphere.radius)),
        }
    }

    /// Whether one of them is large for one of these points.
    pub(crate) fn any_close_to(&self, points: &[Vec3]) -> bool {
        points.iter().any(|&point| {
            self.triangles.iter().any(|corners| is_over(point, *corners) && is_close(point, *corners))
                || self.spheres.iter().any(|sphere| is_close_sphere(point, sphere.center, sphere.radius))
        })
    }
}

/// Whether a point's foot on a triangle's plane lies in the triangle's box, or beside it. A triangle that is seen edge-on from afar is no
/// matter: the mean of the corners' t holds there.
fn is_over(point: Vec3, corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let foot = point.as_dvec3() + normal * (a - point.as_dvec3()).dot(normal);
    let aside = longest_edge([a, b, c]) / 8.0;
    foot.cmpge(a.min(b).min(c) - aside).all() && foot.cmple(a.max(b).max(c) + aside).all()
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
