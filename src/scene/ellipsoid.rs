//! Ellipsoids: affine images of spheres.

use glam::{DMat3, DVec3, Mat3, Vec3};

use super::{MaterialId, Scene, Stamp, checks::check_coordinate};
use crate::Error;

/// Largest ratio of an ellipsoid's longest semi-axis to its shortest. Flatter ones degenerate in f32: DESIGN, section
/// 2, has the measurements.
pub const MAX_ASPECT: f32 = 1e4;

/// Shortest semi-axis of an ellipsoid, in world units. Squares of smaller ones vanish in f32.
pub const MIN_SEMI_AXIS: f32 = 1e-15;

/// An affine image of the unit sphere: all points `center + axes * v` with `v` of length 1.
///
/// ```
/// use stereotrace::{Ellipsoid, MaterialId, Scene, glam::{Affine3A, Mat3, Vec3}};
///
/// let mut scene = Scene::new();
/// let lens = Ellipsoid::aligned(Vec3::Y, Vec3::new(2.0, 0.5, 2.0), MaterialId(0));
/// scene.add_ellipsoid(Ellipsoid::new(lens.center, Mat3::from_rotation_z(0.5) * lens.axes, lens.material))?;
/// scene.transform_object(0, &Affine3A::from_scale(Vec3::new(1.0, 3.0, 1.0)))?;
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ellipsoid {
    /// Position of the centre, relative to [`Scene::origin`].
    pub center: Vec3,
    /// Images of the unit sphere's axes, as columns. If they are perpendicular, they are the semi-axes.
    pub axes: Mat3,
    /// Its material.
    pub material: MaterialId,
}

impl Ellipsoid {
    /// Makes an ellipsoid from its centre, relative to [`Scene::origin`], and the matrix that maps the unit sphere.
    pub fn new(center: Vec3, axes: Mat3, material: MaterialId) -> Self {
        Self { center, axes, material }
    }

    /// Makes an ellipsoid whose semi-axes are parallel to the world's axes and have the lengths `radii`.
    pub fn aligned(center: Vec3, radii: Vec3, material: MaterialId) -> Self {
        Self::new(center, Mat3::from_diagonal(radii), material)
    }

    /// Returns the semi-axes in any order. One-sided Jacobi rotations (Hestenes 1958) make the columns perpendicular
    /// without changing the surface.
    pub(crate) fn semi_axes(&self) -> [DVec3; 3] {
        let mut columns = [self.axes.x_axis, self.axes.y_axis, self.axes.z_axis].map(Vec3::as_dvec3);
        for (i, j) in [(0, 1), (1, 2), (2, 0)].repeat(SWEEPS) {
            let (a, b) = (columns[i], columns[j]);
            let across = a.dot(b);
            if across.abs() <= 1e-16 * a.length() * b.length() {
                continue;
            }
            let cotangent = (b.length_squared() - a.length_squared()) / (2.0 * across);
            let tangent = 1.0_f64.copysign(cotangent) / (cotangent.abs() + cotangent.hypot(1.0));
            let cosine = 1.0 / tangent.hypot(1.0);
            columns[i] = cosine * (a - tangent * b);
            columns[j] = cosine * (b + tangent * a);
        }
        columns
    }

    /// Returns the map from the ellipsoid to a sphere, for rays.
    pub(crate) fn to_sphere(self) -> ToSphere {
        let axes = self.semi_axes();
        let radius = axes.map(DVec3::length).into_iter().fold(0.0, f64::max) as f32;
        let row = |axis: DVec3| (axis * (f64::from(radius) / axis.length_squared())).as_vec3();
        ToSphere { rows: axes.map(row), radius }
    }

    /// Returns half the extent of the traced surface along each of the world's axes.
    pub(crate) fn half_extent(&self) -> DVec3 {
        self.to_sphere().half_extent()
    }

    /// Returns the corners of the bounding box.
    pub(crate) fn corners(&self) -> [Vec3; 2] {
        let half = self.half_extent().as_vec3();
        [self.center - half, self.center + half]
    }

    /// Returns whether a point is inside or on the surface.
    pub(crate) fn holds(&self, point: Vec3) -> bool {
        let map = self.to_sphere();
        let offset = point.as_dvec3() - self.center.as_dvec3();
        DVec3::from_array(map.rows.map(|row| row.as_dvec3().dot(offset))).length() <= f64::from(map.radius)
    }
}

/// Number of rotation sweeps. Convergence is quadratic, so few are needed.
const SWEEPS: usize = 10;

/// Map of offsets from an ellipsoid's centre to offsets from a sphere's centre. The matrix has three rows, each along a
/// semi-axis, and the sphere's radius is the longest semi-axis. Perpendicular rows keep the rounding of one semi-axis
/// out of the others. A sphere's matrix is the identity, so the intersection is bit-identical to a sphere's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ToSphere {
    pub(crate) rows: [Vec3; 3],
    pub(crate) radius: f32,
}

impl ToSphere {
    /// Returns the map of a sphere.
    pub(crate) fn identity(radius: f32) -> Self {
        Self { rows: [Vec3::X, Vec3::Y, Vec3::Z], radius }
    }

    fn half_extent(&self) -> DVec3 {
        let [a, b, c] = self.rows.map(Vec3::as_dvec3);
        let axes = DMat3::from_cols(a, b, c).transpose().inverse() * f64::from(self.radius);
        DVec3::from_array([0, 1, 2].map(|axis| axes.row(axis).length()))
    }
}

impl Scene {
    /// Adds an ellipsoid as an object of its own.
    ///
    /// # Errors
    /// [`Error::Scene`] for:
    ///
    /// - a centre or axes that are not finite or too large,
    /// - semi-axes below [`MIN_SEMI_AXIS`],
    /// - a longest semi-axis over [`MAX_ASPECT`] times the shortest, also if `axes` has no inverse,
    /// - an unknown material.
    pub fn add_ellipsoid(&mut self, ellipsoid: Ellipsoid) -> Result<(), Error> {
        self.check_ellipsoid(self.ellipsoids.len(), &ellipsoid)?;
        self.ellipsoids.push(ellipsoid);
        self.spheres_stamp = Stamp::new();
        Ok(())
    }

    /// Returns all ellipsoids; the primitive id is the index plus the number of triangles and spheres.
    pub fn ellipsoids(&self) -> &[Ellipsoid] {
        &self.ellipsoids
    }

    pub(crate) fn check_ellipsoid(&self, index: usize, ellipsoid: &Ellipsoid) -> Result<(), Error> {
        let check = || {
            check_coordinate(ellipsoid.center)?;
            ellipsoid.axes.to_cols_array_2d().into_iter().map(Vec3::from_array).try_for_each(check_coordinate)?;
            let lengths = ellipsoid.semi_axes().map(DVec3::length);
            let [shortest, longest] =
                [lengths.into_iter().fold(f64::INFINITY, f64::min), lengths.into_iter().fold(0.0, f64::max)];
            let [a, b, c] = lengths.map(|length| length as f32);
            if longest > shortest * f64::from(MAX_ASPECT) {
                return Err(format!(
                    "semi-axes {a}, {b} and {c}: the longest can be at most {MAX_ASPECT} times the shortest"
                ));
            }
            if shortest < f64::from(MIN_SEMI_AXIS) {
                return Err(format!("semi-axes {a}, {b} and {c}: each must be at least {MIN_SEMI_AXIS:e}"));
            }
            let [low, high] = ellipsoid.corners();
            check_coordinate(low)?;
            check_coordinate(high)?;
            self.check_material(ellipsoid.material)
        };
        check().map_err(|reason| Error::Scene { element: format!("ellipsoid {index}"), reason })
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat};

    use super::*;
    use crate::{Sphere, random::Random};

    fn turned(random: &mut Random, radii: Vec3) -> Ellipsoid {
        let turn = Mat3::from_quat(Quat::from_axis_angle(random.point(1.0).normalize(), random.between(0.0, 6.0)));
        Ellipsoid::new(random.point(1.0), turn * Mat3::from_diagonal(radii), MaterialId(0))
    }

    /// Tests ten thousand ellipsoids with random axes: the columns' surface is mapped to a sphere, and the box is
    /// tight.
    #[test]
    fn the_map_takes_the_surface_to_a_sphere_and_the_box_touches_it() {
        let mut random = Random::new(5);
        let mut worst = [0.0_f64; 3];
        for index in 0..10_000 {
            let radii = Vec3::new(1.0, random.between(0.01, 1.0), random.between(0.3, 3.0));
            let turned = turned(&mut random, radii);
            let sheared = Mat3::from_cols(random.point(1.0), random.point(1.0), random.point(1.0));
            let axes = if index % 2 == 0 { turned.axes } else { sheared };
            let one = Ellipsoid { axes, ..turned };
            if one.semi_axes().map(DVec3::length).into_iter().fold(f64::INFINITY, f64::min) < 0.01 {
                continue;
            }
            let map = one.to_sphere();
            let half = one.half_extent();
            for _ in 0..4 {
                let point = axes.as_dmat3() * random.point(1.0).normalize().as_dvec3();
                let mapped = DVec3::from_array(map.rows.map(|row| row.as_dvec3().dot(point)));
                worst[0] = worst[0].max((mapped.length() / f64::from(map.radius) - 1.0).abs());
                assert!(point.abs().cmple(half * (1.0 + 1e-6)).all());
            }
            // The closed form of the box is the norms of the matrix's rows.
            let norms = DVec3::from_array([0, 1, 2].map(|axis| axes.as_dmat3().row(axis).length()));
            worst[1] = worst[1].max((half / norms - 1.0).abs().max_element());
            let [a, b, c] = map.rows.map(Vec3::as_dvec3);
            worst[2] = worst[2]
                .max(a.dot(b).abs() / (a.length() * b.length()))
                .max(b.dot(c).abs() / (b.length() * c.length()));
        }
        println!("{worst:?}");
        assert!(worst[0] < 2e-5 && worst[1] < 2e-5 && worst[2] < 2e-7, "{worst:?}");
    }

    #[test]
    fn of_equal_axes_the_map_is_the_identity() {
        for radius in [1e-9, 0.3, 1.0, 0.7, 1e6, 12345.678] {
            let map = Ellipsoid::aligned(Vec3::ONE, Vec3::splat(radius), MaterialId(0)).to_sphere();
            assert_eq!((map.rows, map.radius), (ToSphere::identity(radius).rows, radius));
        }
    }

    #[test]
    fn what_no_f32_can_trace_is_refused_by_name() {
        let mut scene = Scene::new();
        let nan = Mat3::from_diagonal(Vec3::new(1.0, f32::NAN, 1.0));
        let flat = |thin| Mat3::from_rotation_x(0.3) * Mat3::from_diagonal(Vec3::new(1.0, thin, 1.0));
        let plane = Mat3::from_cols(Vec3::X, Vec3::Y, Vec3::X + Vec3::Y);
        for (axes, word) in [
            (nan, "NaN is not a finite"),
            (Mat3::ZERO, "at least 1e-15"),
            (Mat3::from_diagonal(Vec3::splat(1e-16)), "at least 1e-15"),
            (Mat3::from_diagonal(Vec3::splat(1e9)), "1000000000 is beyond"),
            (Mat3::from_diagonal(Vec3::splat(f32::INFINITY)), "finite"),
            (plane, "times the shortest"),
            (flat(9.9e-5), "times the shortest"),
        ] {
            let error = scene.add_ellipsoid(Ellipsoid::new(Vec3::X, axes, MaterialId(0))).unwrap_err().to_string();
            assert!(error.contains("ellipsoid 0: ") && error.contains(word), "{error}");
        }
        let unknown = Ellipsoid::aligned(Vec3::X, Vec3::ONE, MaterialId(3));
        assert!(scene.add_ellipsoid(unknown).unwrap_err().to_string().contains("no material 3; the scene has 1"));
        scene.add_ellipsoid(Ellipsoid::new(Vec3::X, flat(1.1e-4), MaterialId(0))).unwrap();
        assert_eq!(scene.ellipsoids().len(), 1);
    }

    #[test]
    fn ellipsoids_count_behind_spheres_and_take_any_map_that_has_an_inverse() {
        let mut scene = Scene::new();
        scene.add_ellipsoid(Ellipsoid::aligned(Vec3::X, Vec3::new(1.0, 2.0, 3.0), MaterialId(0))).unwrap();
        scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, MaterialId(0))).unwrap();
        assert_eq!([0, 1, 2].map(|id| scene.object_of(id)), [0, 1, crate::MISS]);
        assert_eq!((scene.primitive_count(), scene.object_count(), scene.object_name(1)), (2, 2, ""));
        let shear = Affine3A::from_mat3(Mat3::from_cols(Vec3::X, Vec3::new(0.5, 1.0, 0.0), 2.0 * Vec3::Z));
        scene.transform_object(1, &shear).unwrap();
        let moved = scene.ellipsoids()[0];
        assert_eq!((moved.center, moved.axes.y_axis), (Vec3::X, Vec3::new(1.0, 2.0, 0.0)));
        assert!(scene.local_bounds().unwrap().1.distance(Vec3::new(1.0 + 2.0_f32.sqrt(), 2.0, 6.0)) < 1e-6);
        for (transform, word) in [
            (Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0)), "times the shortest"),
            (Affine3A::from_translation(Vec3::splat(1e9)), "1000000000"),
            (Affine3A::from_scale(Vec3::splat(f32::NAN)), "NaN"),
        ] {
            let message = scene.transform_object(1, &transform).unwrap_err().to_string();
            assert!(message.contains("ellipsoid 0") && message.contains(word), "{message}");
            assert_eq!(scene.ellipsoids(), [moved]);
        }
        assert!(scene.set_sphere(1, scene.spheres()[0]).unwrap_err().to_string().contains("set_ellipsoid"));
        assert!(scene.set_ellipsoid(0, moved).unwrap_err().to_string().contains("set_sphere"));
        scene.set_ellipsoid(1, Ellipsoid::aligned(Vec3::Y, Vec3::ONE, MaterialId(0))).unwrap();
        assert!(scene.ellipsoids()[0].holds(Vec3::new(0.0, 1.99, 0.0)) && !scene.ellipsoids()[0].holds(Vec3::ONE));
    }
}
