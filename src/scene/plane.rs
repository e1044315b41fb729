//! Infinite planes.

use std::ops::{Range, RangeInclusive};

use glam::{DVec3, Vec3};

use super::{MaterialId, Scene, Stamp, checks::check_coordinate};
use crate::Error;

/// A scene can have at most so many planes: every ray is tested against all of them.
pub const MAX_PLANES: usize = 8;

/// How far from where a ray begins it meets a plane, in world units: what is farther is seen as sky. So a plane's
/// points, seen from a scene's coordinates ([`MAX_COORDINATE`](super::MAX_COORDINATE)), are where eyes may be.
pub const PLANE_REACH: f32 = 1e8;

/// Sides of a plane's tile in world units.
const TILES: RangeInclusive<f32> = 1e-6..=1e8;
/// A plane whose normal is less upright than this is a wall.
const UPRIGHT: f64 = 0.5;
/// A share of a vector's length that is taken for nothing: below it the rounding of its coordinates says what is left.
const NOTHING: f64 = 1e-6;

/// An infinite plane. It has two sides, as triangles have, and no extent: it counts for no scene's bounds. A plane of
/// glass is the face of a half-space that is all glass, on the side that its normal points away from. A ray that begins
/// exactly in the plane does not meet it, so that an eye there sees what is on both sides.
///
/// A texture on it fills squares side by side. A point at `offset` from [`Plane::point`] has the texture coordinates
/// `u = offset · û / tile` and `v = offset · (n × û) / tile`: n is the unit normal, û the unit vector along what lies
/// in the plane of [`Plane::u_axis`].
///
/// ```
/// use stereotrace::{MaterialId, Plane, Scene, glam::Vec3};
///
/// let mut scene = Scene::new();
/// scene.add_plane(Plane::new(Vec3::ZERO, Vec3::Y, MaterialId(0)).tile(2.0))?;
/// assert_eq!(scene.bounds(), None);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Plane {
    /// A world position on it: there texture coordinates are 0.
    pub point: Vec3,
    /// Its normal, of any length but 0. What is traced is the plane of the unit normal's rounding to f32, which is off
    /// by up to 1e-7 of the distance from `point`.
    pub normal: Vec3,
    /// Where a texture's right is, of any length but 0. What of it does not lie in the plane does not count.
    pub u_axis: Vec3,
    /// The side in world units of the square that a texture fills once, 1e-6 to 1e8.
    pub tile: f32,
    /// Its material.
    pub material: MaterialId,
}

impl Plane {
    /// A plane through a world position, by its normal, of any length but 0. A texture on it fills squares of a unit's
    /// side. On grounds, up to 60 degrees steep, its right is the world's +x, and on level ones that are seen from
    /// above its top is at -z; on walls, seen from where the normal points, its right is right and its top is up.
    pub fn new(point: Vec3, normal: Vec3, material: MaterialId) -> Self {
        let unit = normal.as_dvec3().normalize_or_zero();
        let is_wall = unit.y.abs() <= UPRIGHT;
        let u_axis = if is_wall { DVec3::Y.cross(unit).normalize_or(DVec3::X).as_vec3() } else { Vec3::X };
        Self { point, normal, u_axis, tile: 1.0, material }
    }

    /// Where a texture's right is, of any length but 0.
    pub fn u_axis(mut self, axis: Vec3) -> Self {
        self.u_axis = axis;
        self
    }

    /// The side in world units of the square that a texture fills once, 1e-6 to 1e8.
    pub fn tile(mut self, side: f32) -> Self {
        self.tile = side;
        self
    }

    /// The unit normal that is traced.
    pub(crate) fn unit_normal(&self) -> Vec3 {
        self.normal.as_dvec3().normalize_or_zero().as_vec3()
    }

    /// By what texture coordinates u are products with offsets: along û, as long as a unit is of a tile.
    pub(crate) fn u_per_unit(&self) -> Vec3 {
        (self.in_plane().normalize_or_zero() / f64::from(self.tile)).as_vec3()
    }

    /// What of `u_axis` lies in the plane, as a share of its length.
    fn in_plane(&self) -> DVec3 {
        let normal = self.normal.as_dvec3().normalize_or_zero();
        let axis = self.u_axis.as_dvec3().normalize_or_zero();
        axis - normal * axis.dot(normal)
    }

    /// How high a point is over it, where its normal points.
    pub(crate) fn height_of(&self, point: Vec3) -> f64 {
        self.normal.as_dvec3().normalize_or_zero().dot(point.as_dvec3() - self.point.as_dvec3())
    }

    fn check(&self) -> Result<(), String> {
        check_coordinate(self.point)?;
        for (name, vector) in [("normal", self.normal), ("u axis", self.u_axis)] {
            if !vector.is_finite() || vector == Vec3::ZERO {
                return Err(format!("its {name} is {vector}; it must be finite and not 0"));
            }
        }
        if self.in_plane().length() < NOTHING {
            return Err(format!("its u axis {} is along its normal {}", self.u_axis, self.normal));
        }
        if !TILES.contains(&self.tile) {
            let (least, most) = (TILES.start(), TILES.end());
            return Err(format!("its tile is {}; it must be within {least:e} to {most:e}", self.tile));
        }
        Ok(())
    }
}

impl Scene {
    /// Adds an infinite plane as an object of its own.
    ///
    /// # Errors
    /// [`Error::Scene`] for a point that is not finite or too large, a normal or u axis that is not finite or 0, a u
    /// axis along the normal, a tile out of range, a material that is not there, and for more than [`MAX_PLANES`].
    pub fn add_plane(&mut self, plane: Plane) -> Result<(), Error> {
        self.check_plane(self.planes.len(), &plane)?;
        self.planes.push(plane);
        self.spheres_stamp = Stamp::new();
        Ok(())
    }

    /// All planes; index + number of triangles, spheres and ellipsoids = primitive id.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Their primitive ids, the last ones.
    pub(crate) fn plane_ids(&self) -> Range<u32> {
        let count = self.primitive_count();
        (count - self.planes.len()) as u32..count as u32
    }

    pub(super) fn check_plane(&self, index: usize, plane: &Plane) -> Result<(), Error> {
        let check = || {
            if index >= MAX_PLANES {
                return Err(format!("a scene can have at most {MAX_PLANES} planes"));
            }
            plane.check()?;
            self.check_material(plane.material)
        };
        check().map_err(|reason| Error::Scene { element: format!("plane {index}"), reason })
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat};

    use super::*;
    use crate::Sphere;

    fn ground() -> Plane {
        Plane::new(Vec3::ZERO, Vec3::Y, MaterialId(0))
    }

    #[test]
    fn what_is_no_plane_is_refused_by_name() {
        let mut scene = Scene::new();
        let nan = Vec3::new(0.0, f32::NAN, 0.0);
        for (plane, word) in [
            (Plane { point: nan, ..ground() }, "NaN is not a finite"),
            (Plane { point: 2e8 * Vec3::X, ..ground() }, "200000000 is beyond"),
            (Plane::new(Vec3::ZERO, Vec3::ZERO, MaterialId(0)), "its normal is [0, 0, 0]; it must be finite and not 0"),
            (Plane::new(Vec3::ZERO, nan, MaterialId(0)), "its normal is [0, NaN, 0]"),
            (Plane::new(Vec3::ZERO, f32::INFINITY * Vec3::Y, MaterialId(0)), "its normal is"),
            (ground().u_axis(Vec3::ZERO), "its u axis is [0, 0, 0]"),
            (ground().u_axis(-3.0 * Vec3::Y), "its u axis [-0, -3, -0] is along its normal [0, 1, 0]"),
            (ground().tile(0.0), "its tile is 0; it must be within 1e-6 to 1e8"),
            (ground().tile(f32::NAN), "its tile is NaN"),
            (Plane { material: MaterialId(3), ..ground() }, "material 3 of 1"),
        ] {
            let error = scene.add_plane(plane).unwrap_err().to_string();
            assert!(error.contains("plane 0: ") && error.contains(word), "{word}: {error}");
        }
        for index in 0..MAX_PLANES {
            let tiny = 1e-30 * Vec3::new(1.0, index as f32, 0.0);
            scene.add_plane(Plane::new(Vec3::ZERO, tiny, MaterialId(0))).unwrap();
        }
        let error = scene.add_plane(ground()).unwrap_err().to_string();
        assert!(error.contains("plane 8: a scene can have at most 8 planes"), "{error}");
    }

    #[test]
    fn textures_stand_upright_on_walls_and_along_x_on_grounds() {
        let axes = |normal: Vec3| {
            let plane = Plane::new(Vec3::ZERO, normal, MaterialId(0)).tile(0.5);
            (plane.u_per_unit(), plane.unit_normal().cross(plane.u_per_unit()))
        };
        for (normal, u, v) in [
            (Vec3::Y, Vec3::X, Vec3::NEG_Z),
            (Vec3::NEG_Y, Vec3::X, Vec3::Z),
            (3.0 * Vec3::Z, Vec3::X, Vec3::Y),
            (Vec3::NEG_Z, Vec3::NEG_X, Vec3::Y),
            (Vec3::X, Vec3::NEG_Z, Vec3::Y),
            (Vec3::NEG_X, Vec3::Z, Vec3::Y),
        ] {
            assert_eq!(axes(normal), (2.0 * u, 2.0 * v), "{normal}");
        }
        let (u, v) = axes(Vec3::new(0.3, 1.0, 0.2));
        assert!(u.normalize().x > 0.9 && v.normalize().z < -0.9 && u.dot(Vec3::new(0.3, 1.0, 0.2)).abs() < 1e-6);
    }

    #[test]
    fn planes_count_last_and_move_with_their_textures() {
        let mut scene = Scene::new();
        scene.add_plane(ground().tile(2.0)).unwrap();
        scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, MaterialId(0))).unwrap();
        assert_eq!([0, 1, 2].map(|id| scene.object_of(id)), [0, 1, crate::MISS]);
        assert_eq!((scene.primitive_count(), scene.object_count(), scene.plane_ids()), (2, 2, 1..2));
        assert_eq!(scene.local_bounds(), Some((Vec3::NEG_ONE, Vec3::ONE)));
        let turn = Quat::from_rotation_x(0.5);
        let transform = Affine3A::from_scale_rotation_translation(Vec3::splat(3.0), turn, Vec3::Y);
        scene.transform_object(1, &transform).unwrap();
        let moved = scene.planes()[0];
        assert!(moved.unit_normal().distance(turn * Vec3::Y) < 1e-6 && moved.point == Vec3::Y);
        assert!((moved.tile - 6.0).abs() < 1e-5 && moved.u_per_unit().distance(Vec3::X / 6.0) < 1e-6);
        // A shear along the plane leaves the plane where it is; a normal goes by the cofactors.
        scene.set_plane(1, ground()).unwrap();
        let shear = Affine3A::from_cols(
            Vec3::X.into(),
            Vec3::new(5.0, 1.0, 0.0).into(),
            Vec3::new(0.0, 1.0, 1.0).into(),
            Vec3::ZERO.into(),
        );
        scene.transform_object(1, &shear).unwrap();
        let normal = scene.planes()[0].unit_normal();
        assert!(normal.dot(Vec3::X).abs() < 1e-6 && normal.dot(Vec3::new(0.0, 1.0, 1.0)).abs() < 1e-6, "{normal}");
        let before = scene.planes()[0];
        for (transform, word) in [
            (Affine3A::from_scale(Vec3::ZERO), "normal"),
            (Affine3A::from_translation(1e9 * Vec3::X), "1000000000"),
            (Affine3A::from_scale(Vec3::splat(f32::NAN)), "NaN"),
        ] {
            let message = scene.transform_object(1, &transform).unwrap_err().to_string();
            assert!(message.contains("plane 0") && message.contains(word), "{message}");
            assert_eq!(scene.planes(), [before]);
        }
        assert!(scene.set_sphere(1, scene.spheres()[0]).unwrap_err().to_string().contains("set_plane"));
        assert!(scene.set_plane(0, before).unwrap_err().to_string().contains("set_sphere"));
    }
}
