//! The surface at a hit, in f64 on the host: normals, barycentric coordinates, object and material.

use glam::{DMat3, DVec3, Vec2, Vec3};

use crate::{
    MISS, MaterialId, Ray, RayHit, Scene,
    scene::{Primitive, ToSphere, Triangle},
};

/// The surface that a ray hits ([`Scene::surface`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Surface {
    /// Geometric normal on the side that the ray comes from: unit length, world frame.
    pub geometric_normal: Vec3,
    /// Shading normal, interpolated where a mesh has normals, on the side of the geometric normal: unit length, world
    /// frame.
    pub shading_normal: Vec3,
    /// Barycentric coordinates of the hit: the weights of the triangle's corners, which are at least 0 and sum to 1.
    /// `None` for spheres, ellipsoids and planes.
    pub barycentric: Option<[f32; 3]>,
    /// Texture coordinates of the hit ([`Mesh::uv`](crate::Mesh::uv)); `None` if the primitive's mesh has none.
    pub uv: Option<Vec2>,
    /// Id of the primitive's object ([`Scene::object_of`]).
    pub object: u32,
    /// Id of the primitive's material.
    pub material: MaterialId,
}

impl Scene {
    /// Returns the surface that a ray hits, or `None` for a miss and for a primitive that the scene lacks. The hit must
    /// come from this scene in its uploaded state.
    ///
    /// ```
    /// use stereotrace::{Gpu, Material, Mesh, Ray, Renderer, Scene, blocking::Wait, glam::{Vec2, Vec3}};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_material(Material::new(Vec3::splat(0.5)));
    /// let corners = [Vec3::ZERO, 4.0 * Vec3::X, 4.0 * Vec3::Y];
    /// let sail = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).vertex_uv(&[Vec2::ZERO, Vec2::X, Vec2::Y])?;
    /// scene.add_mesh(&sail)?;
    /// let renderer = Renderer::new(Gpu::new().wait()?);
    /// let uploaded = renderer.upload(&scene).wait()?;
    /// let ray = Ray::new(Vec3::new(1.0, 2.0, 5.0), -Vec3::Z);
    /// let hit = renderer.closest_hits(&uploaded, &[ray]).wait()?.hits[0];
    /// let surface = scene.surface(&ray, &hit).unwrap();
    /// assert_eq!(surface.geometric_normal, Vec3::Z);
    /// assert_eq!(surface.barycentric, Some([0.25, 0.25, 0.5]));
    /// assert_eq!(surface.uv, Some(Vec2::new(0.25, 0.5)));
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    pub fn surface(&self, ray: &Ray, hit: &RayHit) -> Option<Surface> {
        if hit.primitive == MISS || hit.primitive as usize >= self.primitive_count() {
            return None;
        }
        let (origin, direction) = (ray.origin - self.origin(), ray.direction.as_dvec3());
        let barycentric = match self.primitive(hit.primitive) {
            Primitive::Triangle(triangle) => Some(weights(triangle, origin, direction).map(|weight| weight as f32)),
            _ => None,
        };
        let corners = self.uv_of(hit.primitive);
        let blended =
            |(weights, corners): ([f32; 3], &[Vec2; 3])| weights.iter().zip(corners).map(|(w, uv)| *w * *uv).sum();
        let uv = barycentric.zip(corners).map(blended);
        let found = at(self, hit.primitive, (origin, direction), f64::from(hit.t));
        Some(Surface { barycentric, uv, object: self.object_of(hit.primitive), ..found })
    }
}

/// Returns the surface of a primitive that a ray hits near `t`. The ray is given by a direction and an origin relative
/// to the scene's origin. The function is the f64 counterpart of `surface_of` in shaders/shared. [`Scene::surface`]
/// adds the object and the coordinates on the surface, which pictures do not need.
pub(super) fn at(scene: &Scene, primitive: u32, (origin, direction): (DVec3, DVec3), t: f64) -> Surface {
    match scene.primitive(primitive) {
        Primitive::Triangle(triangle) => of_triangle(triangle, origin, direction),
        Primitive::Plane(plane) => flat(plane.unit_normal().as_dvec3(), direction, plane.material),
        Primitive::Sphere(sphere) => {
            let outward = outward(&ToSphere::identity(sphere.radius), origin - sphere.center.as_dvec3(), direction, t);
            flat(outward, direction, sphere.material)
        }
        Primitive::Ellipsoid(ellipsoid) => {
            let outward = outward(&ellipsoid.to_sphere(), origin - ellipsoid.center.as_dvec3(), direction, t);
            flat(outward, direction, ellipsoid.material)
        }
    }
}

/// A point of a primitive that moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved {
    /// Its position relative to the scene's origin, now and at the other time.
    pub(super) positions: [DVec3; 2],
    /// Outward normal at the other time, of any length; zero for primitives with two sides.
    pub(super) outward: DVec3,
}

/// Returns the point of a primitive that a ray hits near `t`, and where that point is on the same primitive at another
/// time. The ray is given by a direction and an origin relative to the scene's origin.
pub(super) fn moved(
    (now, then): (&Primitive<'_>, &Primitive<'_>),
    (origin, direction): (DVec3, DVec3),
    t: f64,
) -> Option<Moved> {
    let on_ball = |map: &ToSphere, center: Vec3| {
        let from_center = origin - center.as_dvec3();
        from_center + direction * hit_near(map, from_center, direction, t)
    };
    // Position of the point relative to the primitive's place, the place, and the axes of its coordinates.
    let (offset, [place, other_place], [axes, other_axes], is_closed) = match (now, then) {
        (Primitive::Triangle(now), Primitive::Triangle(then)) => {
            let weights = weights(now, origin, direction);
            let positions = [now, then].map(|triangle| {
                let corners = triangle.corners.iter().zip(weights);
                corners.map(|(corner, weight)| corner.as_dvec3() * weight).sum()
            });
            return Some(Moved { positions, outward: DVec3::ZERO });
        }
        (Primitive::Sphere(now), Primitive::Sphere(then)) => {
            let offset = on_ball(&ToSphere::identity(now.radius), now.center);
            let axes = [now, then].map(|ball| DMat3::from_diagonal(DVec3::splat(ball.radius.into())));
            (offset, [now.center, then.center], axes, true)
        }
        (Primitive::Ellipsoid(now), Primitive::Ellipsoid(then)) => {
            let offset = on_ball(&now.to_sphere(), now.center);
            (offset, [now.center, then.center], [now.axes.as_dmat3(), then.axes.as_dmat3()], true)
        }
        (Primitive::Plane(now), Primitive::Plane(then)) => {
            let (from_point, normal) = (origin - now.point.as_dvec3(), now.unit_normal().as_dvec3());
            let offset = from_point - direction * (from_point.dot(normal) / direction.dot(normal));
            (offset, [now.point, then.point], [now.axes(), then.axes()], false)
        }
        _ => return None,
    };
    let coordinates = axes.inverse() * offset;
    let outward = if is_closed { other_axes.inverse().transpose() * coordinates } else { DVec3::ZERO };
    let after = other_place.as_dvec3() + other_axes * coordinates;
    Some(Moved { positions: [place.as_dvec3() + offset, after], outward })
}

/// Returns a surface that is shaded by its geometric normal. `normal` may have any length but 0.
fn flat(normal: DVec3, direction: DVec3, material: MaterialId) -> Surface {
    let normal = towards_viewer(normal, direction).as_vec3();
    Surface { geometric_normal: normal, shading_normal: normal, barycentric: None, uv: None, object: MISS, material }
}

fn towards_viewer(normal: DVec3, direction: DVec3) -> DVec3 {
    let unit = normal.normalize_or_zero();
    if unit.dot(direction) > 0.0 { -unit } else { unit }
}

/// Returns the barycentric coordinates at which a ray meets a triangle's plane. They are at least 0 and sum to 1.
pub(super) fn weights(triangle: &Triangle, origin: DVec3, direction: DVec3) -> [f64; 3] {
    let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3() - origin);
    // A corner's weight is the volume that the ray spans with the opposite edge. Rounding may leave the point slightly
    // outside.
    let volumes = [b.cross(c), c.cross(a), a.cross(b)].map(|edge| edge.dot(direction));
    let sign = volumes.iter().sum::<f64>().signum();
    let shares = volumes.map(|volume| (sign * volume).max(0.0));
    let sum: f64 = shares.iter().sum();
    // A ray in the triangle's plane does not determine the weights, so equal weights are used.
    if sum > 0.0 { shares.map(|share| share / sum) } else { [1.0 / 3.0; 3] }
}

fn of_triangle(triangle: &Triangle, origin: DVec3, direction: DVec3) -> Surface {
    let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3() - origin);
    let normal = (b - a).cross(c - a);
    let flat = flat(normal, direction, triangle.material);
    if !triangle.is_smooth() {
        return flat;
    }
    let weights = weights(triangle, origin, direction);
    let normals = triangle.normals.map(|normal| normal.as_dvec3().normalize_or_zero());
    let blend = normals.iter().zip(weights).map(|(normal, weight)| *normal * weight).sum::<DVec3>();
    // As in the kernels, the geometric normal is used if the normals cancel each other or the blend is NaN, as with
    // slivers.
    let is_usable = blend.length_squared() > 1e-6;
    if !is_usable {
        return flat;
    }
    let unit = blend.normalize();
    let geometric = towards_viewer(normal, direction);
    Surface { shading_normal: if unit.dot(geometric) < 0.0 { -unit } else { unit }.as_vec3(), ..flat }
}

/// Returns the normal, of any length, where a ray hits an ellipsoid near `t`.
fn outward(map: &ToSphere, from_center: DVec3, direction: DVec3, t: f64) -> DVec3 {
    let rows = map.rows.map(|row| row.as_dvec3());
    let met = from_center + direction * hit_near(map, from_center, direction, t);
    let met = rows.map(|row| row.dot(met));
    rows[0] * met[0] + rows[1] * met[1] + rows[2] * met[2]
}

/// Returns where a ray hits an ellipsoid near `t`. The hit is computed again, because the rounding of a depth may be
/// large compared with the radius of a small ellipsoid.
fn hit_near(map: &ToSphere, from_center: DVec3, direction: DVec3, t: f64) -> f64 {
    let rows = map.rows.map(|row| row.as_dvec3());
    let mapped = |vector: DVec3| DVec3::from_array(rows.map(|row| row.dot(vector)));
    let (origin, along, radius) = (mapped(from_center), mapped(direction), f64::from(map.radius));
    let middle = -origin.dot(along) / along.length_squared();
    let nearest = origin + along * middle;
    // A ray that misses by rounding is taken to hit at its closest approach.
    let half = ((radius * radius - nearest.length_squared()).max(0.0) / along.length_squared()).sqrt();
    if t < middle { middle - half } else { middle + half }
}
