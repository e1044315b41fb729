//! Automatic lights.

use glam::{DVec3, Vec3};

use super::{DEFAULT_AMBIENT, Light, Scene, checks::check_light_count};
use crate::{Error, StereoCamera};

const GOLDEN_ANGLE: f32 = 2.399_963_2;
/// Largest longest side of a scene, in screen distances, for which the bounding box describes the eyes' surroundings.
const FAR_REACHING: f32 = 50.0;
/// Position of a light that something hides from the eye, as a share of the distance to the obstacle.
const BEFORE_OBSTACLE: f32 = 0.9;

impl Scene {
    /// Replaces `lights` by [`Scene::lights_around`] the camera. If `ambient` is `None` it becomes 0.15.
    ///
    /// # Errors
    /// The errors of [`Scene::lights_around`].
    pub fn place_lights(&mut self, count: usize, camera: &StereoCamera) -> Result<(), Error> {
        self.lights = self.lights_around(count, camera)?;
        self.ambient.get_or_insert(Vec3::splat(DEFAULT_AMBIENT));
        Ok(())
    }

    /// Returns `count` lights, with the same rule for every method and scene file (DESIGN, section 3). Light `k` is
    /// beside and above the eyes, at `eye + ρ (r cos θ + u |sin θ|)`. θ is k times the golden angle, and `ρ = d (0.25 +
    /// 0.5 (k + 0.5) / count)`. `d` is the screen's distance, or the target's if the screen is at infinity.
    ///
    /// If the eyes are inside the scene's bounding box, the light is moved into the box shrunk by a tenth. So it is not
    /// behind a wall. The lights add up to 0.85, so with an ambient light of 0.15 white does not saturate.
    ///
    /// A box with a side over 50 `d` does not describe the walls around the eyes, for example in a scene with a wide
    /// ground. In such a box a light keeps its place beside the eyes. If an obstacle is between the eyes and the light,
    /// the light moves to nine tenths of the way to it. The same applies to a light inside a sphere or an ellipsoid
    /// that the eyes are outside of, and to a light behind a plane.
    ///
    /// # Errors
    /// [`Error::Camera`] if the camera is invalid, [`Error::Scene`] for more than [`MAX_LIGHTS`](super::MAX_LIGHTS).
    pub fn lights_around(&self, count: usize, camera: &StereoCamera) -> Result<Vec<Light>, Error> {
        let pose = camera.pose()?;
        check_light_count(count)?;
        let eye = self.local(pose.eye);
        let walls = Walls::around(eye, pose.subject_distance, self.local_bounds());
        let mut near = None;
        let place = |k: usize| {
            let (sin, cos) = (k as f32 * GOLDEN_ANGLE).sin_cos();
            let reach = pose.subject_distance * (0.25 + 0.5 * (k as f32 + 0.5) / count as f32);
            let wanted = eye + (pose.right * cos + pose.up * sin.abs()) * reach;
            let position = match walls {
                Walls::None => Some(wanted),
                Walls::Box(low, high) => Some(wanted.clamp(low, high)),
                Walls::BeyondSight => None,
            };
            let position = position.filter(|&position| !self.enclosed(position, eye));
            let position = position.unwrap_or_else(|| {
                let near = near.get_or_insert_with(|| self.within_reach(eye, pose.subject_distance));
                let way = near.way_to_obstacle(eye.as_dvec3(), (wanted - eye).as_dvec3()) as f32;
                eye + (wanted - eye) * if way < 1.0 { BEFORE_OBSTACLE * way } else { 1.0 }
            });
            Light::point(self.origin + position.as_dvec3(), Vec3::splat((1.0 - DEFAULT_AMBIENT) / count as f32))
        };
        Ok((0..count).map(place).collect())
    }

    /// Returns whether a sphere or an ellipsoid contains `point` but not `eye`, or a plane separates the two.
    fn enclosed(&self, point: Vec3, eye: Vec3) -> bool {
        let of_ellipsoids = || self.ellipsoids.iter().any(|one| one.holds(point) && !one.holds(eye));
        let of_spheres = || {
            self.spheres.iter().any(|sphere| {
                let inside = |at: Vec3| at.as_dvec3().distance(sphere.center.as_dvec3()) <= f64::from(sphere.radius);
                inside(point) && !inside(eye)
            })
        };
        let of_planes = || self.planes.iter().any(|plane| plane.height_of(point) * plane.height_of(eye) <= 0.0);
        of_spheres() || of_ellipsoids() || of_planes()
    }

    /// Returns the distance to the first surface along `way`, as a share of its length, or infinity. Holes of cut-outs
    /// count as surface.
    fn way_to_obstacle(&self, eye: DVec3, way: DVec3) -> f64 {
        let triangles = self.triangles.iter().filter(|triangle| !triangle.is_degenerate());
        let triangles = triangles.filter_map(|triangle| {
            let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3() - eye);
            let (ab, ac) = (b - a, c - a);
            let across = way.cross(ac);
            let determinant = ab.dot(across);
            let (u, v) = (-a.dot(across) / determinant, way.dot(ab.cross(a)) / determinant);
            let is_inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
            is_inside.then(|| ac.dot(ab.cross(a)) / determinant)
        });
        let of_ball = |to_center: DVec3, way: DVec3, radius: f64| {
            let (middle, squared) = (way.dot(to_center), way.length_squared());
            let root = middle * middle - squared * (to_center.length_squared() - radius * radius);
            let near = (middle - root.sqrt()) / squared;
            if near >= 0.0 { near } else { (middle + root.sqrt()) / squared }
        };
        let spheres = self.spheres.iter();
        let spheres = spheres.map(|sphere| of_ball(sphere.center.as_dvec3() - eye, way, sphere.radius.into()));
        let ellipsoids = self.ellipsoids.iter().map(|one| {
            let map = one.to_sphere();
            let mapped = |v: DVec3| DVec3::from_array(map.rows.map(|row| row.as_dvec3().dot(v)));
            of_ball(mapped(one.center.as_dvec3() - eye), mapped(way), map.radius.into())
        });
        let planes = self.planes.iter().map(|plane| {
            let normal = plane.unit_normal().as_dvec3();
            normal.dot(plane.point.as_dvec3() - eye) / normal.dot(way)
        });
        let all = triangles.chain(spheres).chain(ellipsoids).chain(planes);
        all.filter(|t| *t >= 0.0).fold(f64::INFINITY, f64::min)
    }

    /// Returns a scene of the primitives that may be between the eyes and a light.
    fn within_reach(&self, eye: Vec3, distance: f32) -> Self {
        let (low, high) = (eye - distance, eye + distance);
        let meets = |from: Vec3, to: Vec3| from.cmple(high).all() && to.cmpge(low).all();
        let mut near = Self::new();
        near.triangles.extend(self.triangles.iter().filter(|triangle| {
            let [a, b, c] = triangle.corners;
            meets(a.min(b).min(c), a.max(b).max(c))
        }));
        near.spheres.extend(
            self.spheres.iter().filter(|sphere| meets(sphere.center - sphere.radius, sphere.center + sphere.radius)),
        );
        near.ellipsoids.extend(self.ellipsoids.iter().filter(|one| {
            let [low, high] = one.corners();
            meets(low, high)
        }));
        near.planes.clone_from(&self.planes);
        near
    }
}

/// The eyes' surroundings, by the scene's bounding box.
enum Walls {
    /// The eyes are outside the box.
    None,
    /// Lights belong between these corners.
    Box(Vec3, Vec3),
    /// The box is too large to describe the surroundings.
    BeyondSight,
}

impl Walls {
    fn around(eye: Vec3, subject_distance: f32, bounds: Option<(Vec3, Vec3)>) -> Self {
        match bounds {
            Some((low, high)) if eye.cmpgt(low).all() && eye.cmplt(high).all() => {
                let inset = (high - low) * 0.05;
                match (high - low).max_element() > FAR_REACHING * subject_distance {
                    true => Self::BeyondSight,
                    false => Self::Box(low + inset, high - inset),
                }
            }
            _ => Self::None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Ellipsoid, MaterialId, Mesh, Plane, Sphere, glam::Mat3, random::Random, testing::cpu::intersect::closest_hit,
    };

    #[test]
    fn the_first_surface_on_a_way_is_the_one_that_rays_hit() {
        let mut random = Random::new(11);
        let mut scene = Scene::new();
        let corners = (0..120).map(|_| random.point(2.0)).collect();
        let triangles = (0..40).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
        scene.add_mesh(&Mesh::new(corners, triangles)).unwrap();
        scene.add_sphere(Sphere::new(Vec3::new(1.0, 1.0, 0.0), 0.7, MaterialId(0))).unwrap();
        let axes = Mat3::from_diagonal(Vec3::new(0.4, 0.9, 0.5));
        scene.add_ellipsoid(Ellipsoid::new(Vec3::new(-1.0, 0.5, 0.3), axes, MaterialId(0))).unwrap();
        scene.add_plane(Plane::new(-2.0 * Vec3::Y, Vec3::new(0.1, 1.0, 0.0), MaterialId(0))).unwrap();
        let mut hits = 0;
        for _ in 0..2000 {
            let (eye, way) = (random.point(3.0), random.point(4.0));
            let (expected, _) = closest_hit(&scene, eye, way, 0.0, f32::INFINITY);
            let found = scene.way_to_obstacle(eye.as_dvec3(), way.as_dvec3()) as f32;
            hits += usize::from(expected.is_finite());
            assert!((found - expected).abs() <= 1e-4 * expected.max(1.0) || found == expected, "{found} {expected}");
        }
        assert!(hits > 500, "{hits}");
    }
}
