//! Twins of shaders/shared/triangle.wgsl and sphere.wgsl, and a search through all primitives in place of the BVH.

use glam::Vec3;

use crate::{MISS, Scene};

/// The ray's t at a triangle, or `None` where it misses (Woop, Benthin & Wald 2013; see shaders/shared/triangle.wgsl).
pub fn intersect_triangle(origin: Vec3, direction: Vec3, [a, b, c]: [Vec3; 3]) -> Option<f32> {
    let size = direction.abs();
    let (axis_x, axis_y, axis_z) = if size.x >= size.y && size.x >= size.z {
        (Vec3::Y, Vec3::Z, Vec3::X)
    } else if size.y >= size.z {
        (Vec3::Z, Vec3::X, Vec3::Y)
    } else {
        (Vec3::X, Vec3::Y, Vec3::Z)
    };
    let dz = direction.dot(axis_z);
    let shear_x = axis_x - axis_z * (direction.dot(axis_x) / dz);
    let shear_y = axis_y - axis_z * (direction.dot(axis_y) / dz);
    let shear_z = axis_z * (1.0 / dz);
    let [a, b, c] = [a - origin, b - origin, c - origin];
    let [ax, bx, cx] = [a, b, c].map(|corner| shear_x.dot(corner));
    let [ay, by, cy] = [a, b, c].map(|corner| shear_y.dot(corner));
    let [az, bz, cz] = [a, b, c].map(|corner| shear_z.dot(corner));
    let products = [(cx * by, cy * bx), (ax * cy, ay * cx), (bx * ay, by * ax)];
    let inside = products.iter().all(|(plus, minus)| plus >= minus) || products.iter().all(|(p, m)| p <= m);
    let [u, v, w] = products.map(|(plus, minus)| plus - minus);
    let determinant = u + v + w;
    if !inside || determinant == 0.0 {
        return None;
    }
    let t = (u * az + v * bz + w * cz) / determinant;
    Some(t.clamp(az.min(bz.min(cz)), az.max(bz.max(cz))))
}

/// The nearest t of at least `t_min` at a sphere, or `None` where the ray misses (shaders/shared/sphere.wgsl).
pub fn intersect_sphere(origin: Vec3, direction: Vec3, center: Vec3, radius: f32, t_min: f32) -> Option<f32> {
    let to_center = center - origin;
    let length_squared = direction.dot(direction);
    let middle = to_center.dot(direction) / length_squared;
    let offset = to_center - direction * middle;
    let inside = radius * radius - offset.dot(offset);
    if inside < 0.0 {
        return None;
    }
    let half = (inside / length_squared).sqrt();
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
