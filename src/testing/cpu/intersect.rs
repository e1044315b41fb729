//! Twins of shaders/shared/triangle.wgsl, sphere.wgsl, ellipsoid.wgsl, planes.wgsl and cutouts.wgsl, with a search
//! through all primitives in place of the BVH.

use glam::Vec3;

use super::{
    cutouts::has_surface,
    double_float::{Two, Two3, dot, plane_t},
};
use crate::{
    Ellipsoid, MISS, Plane, Scene,
    accel::bvh::{reach_bits, shortest_edge_first},
    accel::large::{is_close, is_close_ellipsoid, is_close_sphere, mapped},
    scene::PLANE_REACH,
};

/// Error bound of edge products, relative to the direction's length, the corners' distance and the longest edge.
const DOUBT: f32 = 22.0 / 16_777_216.0;

/// Returns the ray's t at a triangle, or `None` for a miss. It uses Plücker products with the edges. If rounding could
/// decide their signs, it uses products of the projected corners; see shaders/shared/triangle.wgsl.
pub fn intersect_triangle(origin: Vec3, direction: Vec3, corners: [Vec3; 3]) -> Option<f32> {
    let corners = shortest_edge_first(corners);
    let [a, b, c] = corners.map(|corner| corner - origin);
    let (inside, bound) = inside_edges(origin, direction, corners);
    if inside.abs() <= bound {
        return look_again_triangle(origin, direction, corners);
    }
    let normal = (b - a).cross(c - a);
    let t = normal.dot(a) / direction.dot(normal);
    match inside > bound {
        true if is_close(origin, corners) => look_again_triangle(origin, direction, corners),
        true => Some(t),
        false => None,
    }
}

/// Returns a value that is positive if the ray passes inside all edges, and the size up to which its sign is uncertain.
fn inside_edges(origin: Vec3, direction: Vec3, corners: [Vec3; 3]) -> (f32, f32) {
    let [a, b, c] = corners.map(|corner| corner - origin);
    let edge = |p: Vec3, q: Vec3| direction.dot((p + q).cross(q - p));
    let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
    let inside = u.min(v.min(w)).max(-u.max(v.max(w)));
    let reach = f32::from_bits(reach_bits(corners));
    let length_squared = direction.dot(direction);
    (inside, length_squared.sqrt() * ((a.dot(a).sqrt() + reach) * reach * DOUBT))
}

/// Returns the ray's t at a triangle of a scene, if it has a surface there (shaders/shared/cutouts.wgsl). A cut-out
/// triangle is always tested a second time, with the projected corners.
fn intersect_in_scene(scene: &Scene, id: usize, origin: Vec3, direction: Vec3) -> Option<f32> {
    let triangle = &scene.triangles()[id];
    if triangle.is_degenerate() {
        return None;
    }
    let Some(texture) = scene.cutout_of(triangle) else {
        return intersect_triangle(origin, direction, triangle.corners);
    };
    let corners = shortest_edge_first(triangle.corners);
    let (inside, bound) = inside_edges(origin, direction, corners);
    if inside < -bound {
        return None;
    }
    let t = look_again_triangle(origin, direction, corners)?;
    has_surface(scene, id, texture, origin, direction).then_some(t)
}

fn look_again_triangle(origin: Vec3, direction: Vec3, corners: [Vec3; 3]) -> Option<f32> {
    let relative = corners.map(|corner| corner - origin);
    let [p, q, r] = relative.map(|corner| projected(direction, corner));
    let product = |a: f32, b: f32| Two::new(a) * Two::new(b);
    let pairs = [(q, r), (r, p), (p, q)].map(|(p, q)| (product(p.0, q.1), product(p.1, q.0)));
    let more = |(forth, back): &(Two, Two)| forth.hi > back.hi || forth.hi == back.hi && forth.lo > back.lo;
    let less = |(forth, back): &(Two, Two)| forth.hi < back.hi || forth.hi == back.hi && forth.lo < back.lo;
    if pairs.iter().any(more) == pairs.iter().any(less) {
        return None;
    }
    let [a, b, c] = relative;
    let normal = (b - a).cross(c - a);
    let across = normal.dot(direction);
    let t = match is_close(origin, corners) {
        true => plane_t(origin, direction, corners),
        false => normal.dot(a) / if across == 0.0 { 1.0 } else { across },
    };
    let t_corner = Vec3::from(relative.map(|corner| direction.dot(corner))) / direction.dot(direction);
    Some(t.max(t_corner.min_element()).min(t_corner.max_element()))
}

fn projected(direction: Vec3, corner: Vec3) -> (f32, f32) {
    let m = corner.cross(direction);
    let size = direction.abs();
    if size.x >= size.y && size.x >= size.z {
        (m.y, m.z)
    } else if size.z > size.y {
        (m.x, m.y)
    } else {
        (m.z, m.x)
    }
}

/// Returns the nearest t at a sphere that is at least `t_min`, or `None` for a miss (shaders/shared/sphere.wgsl).
pub fn intersect_sphere(origin: Vec3, direction: Vec3, center: Vec3, radius: f32, t_min: f32) -> Option<f32> {
    if is_close_sphere(origin, center, radius) {
        return look_again(Two3::difference(center, origin), Two3::new(direction), radius, t_min);
    }
    meet(center - origin, direction, radius, t_min)
}

/// Returns the nearest t at an ellipsoid that is at least `t_min`, or `None` for a miss
/// (shaders/shared/ellipsoid.wgsl).
pub fn intersect_ellipsoid(origin: Vec3, direction: Vec3, ellipsoid: &Ellipsoid, t_min: f32) -> Option<f32> {
    let (center, map) = (ellipsoid.center, ellipsoid.to_sphere());
    if is_close_ellipsoid(origin, center, &map) {
        let mapped = |v: Two3| Two3(map.rows.map(|row| dot(Two3::new(row), v)));
        let to_center = mapped(Two3::difference(center, origin));
        return look_again(to_center, mapped(Two3::new(direction)), map.radius, t_min);
    }
    meet(mapped(&map, center - origin), mapped(&map, direction), map.radius, t_min)
}

/// Returns the ray's t at a plane (shaders/shared/planes.wgsl). It is `None` if the ray begins in the plane, is
/// parallel to it, or meets it farther than [`PLANE_REACH`] away. It is negative if the ray points away from the plane.
pub fn intersect_plane(origin: Vec3, direction: Vec3, plane: &Plane) -> Option<f32> {
    let normal = plane.unit_normal();
    let height = dot(Two3::new(normal), Two3::difference(plane.point, origin)).hi;
    let across = direction.x * normal.x + direction.y * normal.y + direction.z * normal.z;
    let length = direction.dot(direction).sqrt();
    (height != 0.0 && across.abs() * PLANE_REACH >= height.abs() * length).then(|| height / across)
}

fn meet(to_center: Vec3, direction: Vec3, radius: f32, t_min: f32) -> Option<f32> {
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

fn look_again(to_center: Two3, way: Two3, radius: f32, t_min: f32) -> Option<f32> {
    let squared = Two::new(radius) * Two::new(radius);
    let outside = dot(to_center, to_center) + -squared;
    let middle = dot(to_center, way);
    let length_squared = dot(way, way);
    let root = (middle * middle + -(length_squared * outside)).hi;
    if root < 0.0 {
        return None;
    }
    let both = middle.hi + if middle.hi >= 0.0 { root.sqrt() } else { -root.sqrt() };
    let larger_root = both / length_squared.hi;
    let other_root = if both == 0.0 { 0.0 } else { outside.hi / both };
    let near = larger_root.min(other_root);
    Some(if near >= t_min { near } else { larger_root.max(other_root) })
}

/// Returns the nearest hit with t in `[t_min, t_max]` among all primitives, as (t, id). At equal t the smallest id
/// wins. A miss is `(t_max, MISS)`.
pub fn closest_hit(scene: &Scene, origin: Vec3, direction: Vec3, t_min: f32, t_max: f32) -> (f32, u32) {
    let triangles = (0..scene.triangles().len()).map(|id| intersect_in_scene(scene, id, origin, direction));
    let spheres =
        scene.spheres().iter().map(|sphere| intersect_sphere(origin, direction, sphere.center, sphere.radius, t_min));
    let mut best = (t_max, MISS);
    let ellipsoids = scene.ellipsoids().iter().map(|one| intersect_ellipsoid(origin, direction, one, t_min));
    let planes = scene.planes().iter().map(|plane| intersect_plane(origin, direction, plane));
    for (id, t) in triangles.chain(spheres).chain(ellipsoids).chain(planes).enumerate() {
        let Some(t) = t.filter(|&t| t >= t_min) else { continue };
        if t < best.0 || (t == best.0 && (id as u32) < best.1) {
            best = (t, id as u32);
        }
    }
    best
}
