//! Infinite planes.

use std::ops::{Range, RangeInclusive};

use glam::{DMat3, DVec3, Vec3};

use super::{MaterialId, Scene, Stamp, checks::check_coordinate};
use crate::Error;

/// Maximum number of planes in a scene. Every ray tests all of them.
pub const MAX_PLANES: usize = 8;

/// Largest distance from a ray's origin at which it hits a plane, in world units; beyond it the sky is visible. So hits
/// seen from within [`MAX_COORDINATE`](super::MAX_COORDINATE) are valid positions of eyes.
pub const PLANE_REACH: f32 = 1e8;

/// Range of a plane's tile sides, in world units.
const TILES: RangeInclusive<f32> = 1e-6..=1e8;
/// A plane whose unit normal has less than this height is a wall.
const UPRIGHT: f64 = 0.5;
/// Smallest share of a vector's length that does not count as rounding.
const NOTHING: f64 = 1e-6;

/// An infinite plane. It has two sides, like a triangle, and does not count for a scene's bounds. A plane of glass
/// bounds a half-space of glass, on the side opposite to its normal. A ray that begins exactly in the plane does not
/// hit it, so an eye there sees both sides.
///
/// A texture fills adjacent squares. A point at `offset` from [`Plane::point`] has the texture coordinates
/// `u = offset · û / tile` and `v = offset · (n × û) / tile`. Here n is the unit normal, and û the normalised part of
/// [`Plane::u_axis`] in the plane.
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
    /// Point on the plane, relative to [`Scene::origin`]. Its texture coordinates are 0.
    pub point: Vec3,
    /// Normal, of any length but 0. Kernels use the unit normal rounded to f32, which displaces the plane by up to 1e-7
    /// of the distance from `point`.
    pub normal: Vec3,
    /// Direction of a texture's right. It may have any length but 0, and only its part in the plane counts.
    pub u_axis: Vec3,
    /// Side of the square that a texture fills, in world units, 1e-6 to 1e8.
    pub tile: f32,
    /// Its material.
    pub material: MaterialId,
}

impl Plane {
    /// Makes a plane through `point`, relative to [`Scene::origin`], with a normal of any length but 0. A texture fills
    /// squares with sides of one unit.
    ///
    /// On grounds with slopes up to 60 degrees the texture's right is +x. On level grounds seen from above its top is
    /// at -z. On walls, seen from the side of the normal, its right and top are the viewer's right and top.
    pub fn new(point: Vec3, normal: Vec3, material: MaterialId) -> Self {
        let unit = normal.as_dvec3().normalize_or_zero();
        let is_wall = unit.y.abs() <= UPRIGHT;
        let u_axis = if is_wall { DVec3::Y.cross(unit).normalize_or(DVec3::X).as_vec3() } else { Vec3::X };
        Self { point, normal, u_axis, tile: 1.0, material }
    }

    /// Sets the direction of a texture's right, of any length but 0.
    pub fn u_axis(mut self, axis: Vec3) -> Self {
        self.u_axis = axis;
        self
    }

    /// Sets the side of the square that a texture fills, in world units, 1e-6 to 1e8.
    pub fn tile(mut self, side: f32) -> Self {
        self.tile = side;
        self
    }

    /// Returns the unit normal that kernels use.
    pub(crate) fn unit_normal(&self) -> Vec3 {
        self.normal.as_dvec3().normalize_or_zero().as_vec3()
    }

    /// Returns the vector whose dot product with an offset is the texture coordinate u.
    pub(crate) fn u_per_unit(&self) -> Vec3 {
        (self.in_plane().normalize_or_zero() / f64::from(self.tile)).as_vec3()
    }

    /// Returns the axes of texture coordinates, with the length of a tile, and the unit normal.
    pub(crate) fn axes(&self) -> DMat3 {
        let (u, normal) = (self.in_plane().normalize_or_zero(), self.normal.as_dvec3().normalize_or_zero());
        let tile = f64::from(self.tile);
        DMat3::from_cols(u * tile, normal.cross(u) * tile, normal)
    }

    /// Returns the part of the unit `u_axis` that lies in the plane.
    fn in_plane(&self) -> DVec3 {
        let normal = self.normal.as_dvec3().normalize_or_zero();
        let axis = self.u_axis.as_dvec3().normalize_or_zero();
        axis - normal * axis.dot(normal)
    }

    /// Returns a point's signed distance from the plane, positive on the side of the normal.
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
            return Err(format!("its u axis {} is parallel to its normal {}", self.u_axis, self.normal));
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
    /// [`Error::Scene`] for:
    ///
    /// - a point that is not finite or too large,
    /// - a normal or u axis that is not finite or 0, or a u axis along the normal,
    /// - a tile out of range, or an unknown material,
    /// - more than [`MAX_PLANES`] planes.
    pub fn add_plane(&mut self, plane: Plane) -> Result<(), Error> {
        self.check_plane(self.planes.len(), &plane)?;
        self.planes.push(plane);
        self.spheres_stamp = Stamp::new();
        Ok(())
    }

    /// Returns all planes; the primitive id is the index plus the number of triangles, spheres and ellipsoids.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Returns the planes' primitive ids, which are the last ones.
    pub(crate) fn plane_ids(&self) -> Range<u32> {
        let count = self.primitive_count();
        (count - self.planes.len()) as u32..count as u32
    }

    pub(crate) fn check_plane(&self, index: usize, plane: &Plane) -> Result<(), Error> {
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
            (ground().u_axis(-3.0 * Vec3::Y), "its u axis [-0, -3, -0] is parallel to its normal [0, 1, 0]"),
            (ground().tile(0.0), "its tile is 0; it must be within 1e-6 to 1e8"),
            (ground().tile(f32::NAN), "its tile is NaN"),
            (Plane { material: MaterialId(3), ..ground() }, "no material 3; the scene has 1"),
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
        // A shear along the plane does not move it. Normals are transformed by the cofactors.
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
