//! Changes to a scene. [`Renderer::update`](crate::Renderer::update) uploads them.

use std::{
    ops::Range,
    sync::atomic::{AtomicU64, Ordering},
};

use glam::{Affine3A, DVec3, Mat3, Vec3};

use super::{
    Ellipsoid, Material, MaterialId, Mesh, Plane, Scene, Sphere, Triangle, checks::check_coordinate, mesh::Object,
};
use crate::{Error, message::counted};

/// Largest relative deviation of a transform's axes from equal length and right angles for which spheres stay spheres.
const ROUND: f64 = 1e-5;

/// A number that is unique in this process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp(u64);

impl Stamp {
    pub(crate) fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

impl Scene {
    /// Moves, turns, scales or shears an object ([`Scene::object_of`]) from its current place. Triangles that lose
    /// their area are dropped, and logged as in [`Scene::add_mesh`]. A plane's texture is turned and scaled with its u
    /// axis, but not sheared.
    ///
    /// Repeated transforms accumulate rounding. For long films keep the object's first state and use
    /// [`Scene::set_mesh`], [`Scene::set_sphere`], [`Scene::set_ellipsoid`] or [`Scene::set_plane`].
    ///
    /// ```
    /// use stereotrace::{MaterialId, Scene, Sphere, glam::{Affine3A, Vec3}};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_sphere(Sphere::new(Vec3::X, 1.0, MaterialId(0)))?;
    /// scene.transform_object(0, &Affine3A::from_translation(Vec3::Y))?;
    /// assert_eq!(scene.spheres()[0].center, Vec3::new(1.0, 1.0, 0.0));
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Scene`] for an unknown object, and if a coordinate becomes infinite, not a number or larger than
    /// [`MAX_COORDINATE`](super::MAX_COORDINATE). Spheres must not be scaled to nothing, scaled unequally or sheared;
    /// add an ellipsoid for that. Ellipsoids have the errors of [`Scene::add_ellipsoid`], and planes the errors of
    /// [`Scene::add_plane`]. After an error the scene is unchanged.
    pub fn transform_object(&mut self, object: u32, transform: &Affine3A) -> Result<(), Error> {
        match self.place_of(object)? {
            Place::Sphere(index) => {
                let sphere = self.spheres[index];
                let scale = scale_of(transform)
                    .map_err(|reason| Error::Scene { element: format!("sphere {index}"), reason })?;
                let center = transform.transform_point3(sphere.center);
                let radius = (f64::from(sphere.radius) * scale) as f32;
                self.set_sphere(object, Sphere { center, radius, ..sphere })
            }
            Place::Ellipsoid(index) => {
                let ellipsoid = self.ellipsoids[index];
                let center = transform.transform_point3(ellipsoid.center);
                let axes = Mat3::from(transform.matrix3) * ellipsoid.axes;
                self.set_ellipsoid(object, Ellipsoid { center, axes, ..ellipsoid })
            }
            Place::Plane(index) => self.set_plane(object, transformed_plane(&self.planes[index], transform)),
            Place::Triangles(range) => {
                let moved = self.triangles[range.clone()].iter().map(|triangle| transformed(triangle, transform));
                let moved: Vec<Triangle> = moved.collect();
                for (index, triangle) in moved.iter().enumerate() {
                    let check = triangle.corners.into_iter().try_for_each(check_coordinate);
                    check.map_err(|reason| Error::Scene {
                        element: format!("mesh '{}', triangle {index}, transformed", self.object_name(object)),
                        reason,
                    })?;
                }
                self.beside.transform_tangents(range.clone(), transform);
                self.replace_and_warn(object, range, moved);
                Ok(())
            }
        }
    }

    /// Replaces a mesh, as the same object. If the number of triangles changes, so do the ids of all later primitives.
    /// The scene must then be updated by [`Update::Rebuild`](crate::Update).
    ///
    /// # Errors
    /// [`Error::Scene`] for the errors of [`Scene::add_mesh`], and if the object is unknown or not a mesh. After an
    /// error the scene is unchanged.
    pub fn set_mesh(&mut self, object: u32, mesh: &Mesh) -> Result<(), Error> {
        let range = match self.place_of(object)? {
            Place::Triangles(range) => range,
            other => return Err(other.refuses(object)),
        };
        let triangles = self.checked_triangles(mesh)?;
        if triangles.len() != range.len() {
            for later in &mut self.mesh_objects[object as usize + 1..] {
                later.first_primitive = (later.first_primitive as usize - range.len() + triangles.len()) as u32;
            }
        }
        let tangents = self.tangents_of(mesh, &triangles);
        let place = &mut self.mesh_objects[object as usize];
        self.beside.replace(range.clone(), (mesh, &tangents), Some(place), self.triangles.len());
        *place = Object::new(mesh, !tangents.is_empty(), place.first_primitive);
        self.replace_and_warn(object, range, triangles);
        Ok(())
    }

    /// Replaces a sphere, as the same object. Object indices count meshes, then spheres, then ellipsoids.
    ///
    /// # Errors
    /// [`Error::Scene`] for the errors of [`Scene::add_sphere`], and if the object is unknown or not a sphere. After an
    /// error the scene is unchanged.
    pub fn set_sphere(&mut self, object: u32, sphere: Sphere) -> Result<(), Error> {
        let index = match self.place_of(object)? {
            Place::Sphere(index) => index,
            other => return Err(other.refuses(object)),
        };
        self.check_sphere(index, &sphere)?;
        self.spheres[index] = sphere;
        self.spheres_stamp = Stamp::new();
        Ok(())
    }

    /// Replaces an ellipsoid, as the same object.
    ///
    /// # Errors
    /// [`Error::Scene`] for the errors of [`Scene::add_ellipsoid`], and if the object is unknown or not an ellipsoid.
    /// After an error the scene is unchanged.
    pub fn set_ellipsoid(&mut self, object: u32, ellipsoid: Ellipsoid) -> Result<(), Error> {
        let index = match self.place_of(object)? {
            Place::Ellipsoid(index) => index,
            other => return Err(other.refuses(object)),
        };
        self.check_ellipsoid(index, &ellipsoid)?;
        self.ellipsoids[index] = ellipsoid;
        self.spheres_stamp = Stamp::new();
        Ok(())
    }

    /// Replaces a plane, as the same object. Planes have the last object indices.
    ///
    /// # Errors
    /// [`Error::Scene`] for the errors of [`Scene::add_plane`], and if the object is unknown or not a plane. After an
    /// error the scene is unchanged.
    pub fn set_plane(&mut self, object: u32, plane: Plane) -> Result<(), Error> {
        let index = match self.place_of(object)? {
            Place::Plane(index) => index,
            other => return Err(other.refuses(object)),
        };
        self.check_plane(index, &plane)?;
        self.planes[index] = plane;
        self.spheres_stamp = Stamp::new();
        Ok(())
    }

    /// Replaces a material.
    ///
    /// # Errors
    /// [`Error::Scene`] for an unknown material.
    pub fn set_material(&mut self, id: MaterialId, material: Material) -> Result<(), Error> {
        let check = self.check_material(id);
        check.map_err(|reason| Error::Scene { element: format!("material '{}'", material.name), reason })?;
        self.materials[id.0 as usize] = material;
        Ok(())
    }

    /// Returns whether an object is a mesh with this name and number of triangles.
    #[cfg(feature = "scene-files")]
    pub(crate) fn has_mesh(&self, object: u32, name: &str, triangles: usize) -> bool {
        let range = self.place_of(object).ok();
        let is_like = |place| matches!(place, Place::Triangles(range) if range.len() == triangles);
        range.is_some_and(is_like) && self.object_name(object) == name
    }

    /// Describes how a scene's objects differ from this scene's in more than their positions; `None` if they do not.
    pub(crate) fn other_topology(&self, other: &Self) -> Option<String> {
        let counts =
            |scene: &Self| [scene.mesh_objects.len(), scene.spheres.len(), scene.ellipsoids.len(), scene.planes.len()];
        let kinds = ["meshes", "spheres", "ellipsoids", "planes"];
        let lists = kinds.iter().zip(counts(self)).zip(counts(other));
        if let Some(((kind, own), found)) = lists.into_iter().find(|((_, own), found)| own != found) {
            return Some(format!("it has {found} {kind} instead of {own}"));
        }
        let size = |scene: &Self, object: usize| {
            let end = scene.mesh_objects.get(object + 1).map(|next| next.first_primitive as usize);
            end.unwrap_or(scene.triangles.len()) - scene.mesh_objects[object].first_primitive as usize
        };
        let object = (0..self.mesh_objects.len()).find(|&object| size(self, object) != size(other, object))?;
        let [own, found] = [self, other].map(|scene| size(scene, object));
        let name = self.object_name(object as u32);
        Some(format!("mesh {object} '{name}' has {found} triangles instead of {own}"))
    }

    fn replace_and_warn(&mut self, object: u32, range: Range<usize>, by: Vec<Triangle>) {
        let (dropped, whole) = (self.dropped, range.start..range.start + by.len());
        self.replace_triangles(range, by);
        self.mesh_objects[object as usize].stamp = Stamp::new();
        let name = self.object_name(object).to_owned();
        self.warn_of_dropped(&name, self.dropped.saturating_sub(dropped), whole);
    }

    fn place_of(&self, object: u32) -> Result<Place, Error> {
        let object = object as usize;
        if object >= self.object_count() {
            let reason = format!("the scene has {}", counted(self.object_count(), "object", "objects"));
            return Err(Error::Scene { element: format!("object {object}"), reason });
        }
        let first = |object: usize| self.mesh_objects.get(object).map(|mesh| mesh.first_primitive as usize);
        Ok(match first(object) {
            Some(begin) => Place::Triangles(begin..first(object + 1).unwrap_or(self.triangles.len())),
            None => {
                let index = object - self.mesh_objects.len();
                let (spheres, balls) = (self.spheres.len(), self.ball_count());
                match index {
                    _ if index < spheres => Place::Sphere(index),
                    _ if index < balls => Place::Ellipsoid(index - spheres),
                    _ => Place::Plane(index - balls),
                }
            }
        })
    }
}

/// Kind of an object, and the indices of its primitives in their list.
enum Place {
    Triangles(Range<usize>),
    Sphere(usize),
    Ellipsoid(usize),
    Plane(usize),
}

impl Place {
    /// Returns the error for an object of another kind than expected.
    fn refuses(&self, object: u32) -> Error {
        let reason = match self {
            Self::Triangles(_) => "it is a mesh: use set_mesh",
            Self::Sphere(_) => "it is a sphere: use set_sphere",
            Self::Ellipsoid(_) => "it is an ellipsoid: use set_ellipsoid",
            Self::Plane(_) => "it is a plane: use set_plane",
        };
        Error::Scene { element: format!("object {object}"), reason: reason.into() }
    }
}

fn axes(transform: &Affine3A) -> [DVec3; 3] {
    [transform.x_axis, transform.y_axis, transform.z_axis].map(|axis| Vec3::from(axis).as_dvec3())
}

/// Returns the factor by which a transform scales spheres.
fn scale_of(transform: &Affine3A) -> Result<f64, String> {
    let [x, y, z] = axes(transform);
    let lengths = [x, y, z].map(DVec3::length);
    let scale = lengths.iter().sum::<f64>() / 3.0;
    let is_equal = lengths.iter().all(|length| (length - scale).abs() <= ROUND * scale);
    let is_square = [x.dot(y), y.dot(z), z.dot(x)].iter().all(|dot| dot.abs() <= ROUND * scale * scale);
    if !scale.is_finite() || (is_equal && is_square) {
        return Ok(scale); // the check of coordinates refuses non-finite values
    }
    let [x, y, z] = lengths;
    let shear = if is_square { "" } else { ", and sheared" };
    Err(format!("scaled by {x}, {y} and {z} along its axes{shear}; a sphere needs the same factor on all axes"))
}

/// Transforms a normal by the cofactors, which are the transposed inverse up to a factor. They exist even if the
/// inverse does not.
fn transformed_normal(normal: Vec3, transform: &Affine3A) -> Vec3 {
    let [x, y, z] = axes(transform);
    let cofactors = [y.cross(z), z.cross(x), x.cross(y)];
    let side = if x.dot(cofactors[0]) < 0.0 { -1.0 } else { 1.0 };
    let [a, b, c] = normal.as_dvec3().to_array();
    (side * (cofactors[0] * a + cofactors[1] * b + cofactors[2] * c)).normalize_or_zero().as_vec3()
}

fn transformed(triangle: &Triangle, transform: &Affine3A) -> Triangle {
    Triangle {
        corners: triangle.corners.map(|corner| transform.transform_point3(corner)),
        normals: triangle.normals.map(|normal| transformed_normal(normal, transform)),
        material: triangle.material,
    }
}

/// Transforms a plane. The tile scales with the part of the u axis in the plane.
fn transformed_plane(plane: &Plane, transform: &Affine3A) -> Plane {
    let u_axis = transform.transform_vector3(plane.u_per_unit());
    Plane {
        point: transform.transform_point3(plane.point),
        normal: transformed_normal(plane.normal, transform),
        u_axis,
        tile: plane.tile * plane.tile * u_axis.length(),
        ..*plane
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;

    fn scene() -> Scene {
        let mut scene = Scene::new();
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let normals = vec![[Vec3::Z; 3]];
        scene.add_mesh(&Mesh::new(corners.clone(), vec![[0, 1, 2]]).normals(normals).name("sail")).unwrap();
        scene.add_mesh(&Mesh::new(corners, vec![[0, 1, 2], [0, 0, 1]])).unwrap();
        scene.add_sphere(Sphere::new(Vec3::X, 1.0, MaterialId(0))).unwrap();
        scene
    }

    #[test]
    fn an_object_moves_alone_with_normals_across_its_triangles() {
        let mut scene = scene();
        let others = scene.triangles()[1..].to_vec();
        let shear =
            Affine3A::from_cols(Vec3::X.into(), Vec3::Y.into(), Vec3::new(3.0, 0.0, 0.5).into(), Vec3::Z.into());
        let turn = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.7), Vec3::new(1.0, 2.0, 3.0));
        let mirror = Affine3A::from_scale(Vec3::new(-2.0, 1.0, 0.3));
        for transform in [shear, turn, mirror] {
            scene.transform_object(0, &transform).unwrap();
            let Triangle { corners: [a, b, c], normals, .. } = scene.triangles()[0];
            for normal in normals {
                assert!((normal.length() - 1.0).abs() < 1e-6, "{normal}");
                assert!(normal.dot(b - a).abs() < 1e-6 && normal.dot(c - a).abs() < 1e-6, "{normal}");
            }
        }
        assert_eq!(
            scene.triangles()[1..].iter().map(|t| t.corners).collect::<Vec<_>>(),
            [others[0].corners, others[1].corners]
        );
        assert!(scene.has_normals());
        scene.transform_object(0, &Affine3A::from_scale(Vec3::ZERO)).unwrap();
        assert!(!scene.has_normals() && scene.degenerate_count() == 2);
    }

    #[test]
    fn spheres_scale_alike_in_all_directions_or_not_at_all() {
        let mut scene = scene();
        let turn = Affine3A::from_scale_rotation_translation(Vec3::splat(2.0), Quat::from_rotation_x(2.0), Vec3::Z);
        scene.transform_object(2, &turn).unwrap();
        assert!((scene.spheres()[0].radius - 2.0).abs() < 1e-6);
        let before = scene.spheres()[0];
        let shear =
            Affine3A::from_cols(Vec3::X.into(), Vec3::new(0.6, 0.8, 0.0).into(), Vec3::Z.into(), Vec3::ZERO.into());
        for (transform, word) in [
            (Affine3A::from_scale(Vec3::new(1.0, 1.0, 1.1)), "1.1"),
            (shear, "sheared"),
            (Affine3A::from_scale(Vec3::ZERO), "radius 0"),
            (Affine3A::from_translation(Vec3::splat(f32::NAN)), "NaN"),
            (Affine3A::from_scale(Vec3::splat(f32::INFINITY)), "finite"),
            (Affine3A::from_translation(Vec3::splat(1e9)), "1000000000"),
        ] {
            let message = scene.transform_object(2, &transform).unwrap_err().to_string();
            assert!(message.contains("sphere 0") && message.contains(word), "{message}");
            assert_eq!(scene.spheres()[0], before);
        }
    }

    #[test]
    fn another_mesh_shifts_what_stands_behind_it_and_faults_change_nothing() {
        let mut scene = scene();
        let quad = Mesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y], vec![[0, 1, 2], [0, 2, 3], [1, 1, 1]]);
        scene.set_mesh(0, &quad.clone().name("quad")).unwrap();
        assert_eq!((0..6).map(|id| scene.object_of(id)).collect::<Vec<_>>(), [0, 0, 0, 1, 1, 2]);
        assert_eq!((scene.object_name(0), scene.degenerate_count(), scene.has_normals()), ("quad", 2, false));
        let fault = |result: Result<(), Error>| result.unwrap_err().to_string();
        assert!(fault(scene.set_mesh(2, &quad)).contains("set_sphere"));
        assert!(fault(scene.set_mesh(3, &quad)).contains("3 objects"));
        assert!(fault(scene.set_sphere(1, scene.spheres()[0])).contains("set_mesh"));
        assert!(fault(scene.set_sphere(2, Sphere::new(Vec3::ZERO, -1.0, MaterialId(0)))).contains("radius -1"));
        assert!(fault(scene.set_mesh(1, &Mesh::new(vec![Vec3::NAN], vec![]))).contains("NaN"));
        assert!(fault(scene.transform_object(1, &Affine3A::from_scale(Vec3::splat(1e30)))).contains("triangle 0"));
        assert!(
            fault(scene.set_material(MaterialId(7), Material::new(Vec3::ONE)))
                .contains("no material 7; the scene has 1")
        );
        assert_eq!((scene.primitive_count(), scene.spheres()[0].radius), (6, 1.0));
        scene.set_material(MaterialId(0), Material::new(Vec3::ONE)).unwrap();
        assert_eq!(scene.materials()[0].albedo, Vec3::ONE);
    }
}
