//! Twins of shaders/shared/triangle.wgsl and sphere.wgsl, and a search through all primitives in place of the BVH.

use glam::Vec3;

use crate::{MISS, Scene};

/// The ray's t at a triangle, or `None` where it misses: Plücker products with its edges, see
/// shaders/shared/triangle.wgsl.
pub fn intersect_triangle(origin: Vec3, direction: Vec3, corners: [Vec3; 3]) -> Option<f32> {
    let [a, b, c] = corners.map(|corner| corner - origin);
    let edge = |p: Vec3, q: Vec3| direction.dot((p + q).cross(q - p));
    let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
    let determinant = u + v + w;
    if !((u.min(v.min(w)) >= 0.0 || u.max(v.max(w)) <= 0.0) && determinant != 0.0) {
        return None;
    }
    let per_length_squared = 1.0 / direction.dot(direction);
    let [t_a, t_b, t_c] = [a, b, c].map(|corner| direction.dot(corner) * per_length_squared);
    Some((u * t_a + v * t_b + w * t_c) / determinant)
}

/// The nearest t of at least `t_min` at a sphere, or `None` where the ray misses (shaders/shared/sphere.wgsl).
pub fn intersect_sphere(origin: Vec3, direction: Vec3, center: Vec3, radius: f32, t_min: f32) -> Option<f32> {
    let to_center = center - origin;
    let per_length_squared = 1.0 / direction.dot(direction);
    let middle = to_center.dot(direction) * per_length_squared;
    let offset = to_center - direction * middle;
    let inside = radius * radius - offset.dot(offset);
    if inside < 0.0 {
        return None;
    }
    let half = (inside * per_length_squared).sqrt();
    let near = middle - half;
    Some(if near >= t_min { near } else { middle + half })
}

/// The nearest hit with t in `[t_min, t_max]` among all primitives, as (t, id); of equal t the smallest id;
/// `(t_max, MISS)` if there is none.
pub fn closest_hit(scene: &Scene, origin: Vec3, direction: Vec3, t_min: f32, t_max: f32) -> (f32, u32) {
    let triangles = scene.triangles().iter().map(|triangle| {
        if triangle.is_degenerate() { None } else { intersect_triangle(origin, direction, triangle.corners) }
    });
    let spheres =
        scene.spheres().iter().map(|sphere| intersect_sphere(origin, direction, sphere.center, sphere.radius, t_min));
    let mut best = (t_max, MISS);
    for (id, t) in triangles.chain(spheres).enumerate() {
        let Some(t) = t.filter(|&t| t >= t_min) else { continue };
        if t < best.0 || (t == best.0 && (id as u32) < best.1) {
            best = (t, id as u32);
        }
    }
    best
}
