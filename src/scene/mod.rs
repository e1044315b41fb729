//! Scenes: triangle meshes, spheres, ellipsoids, planes, materials, lights, ambient light and the sky.

#[cfg(feature = "scene-files")]
#[cfg_attr(not(feature = "gltf"), allow(dead_code, reason = "only glTF files have animations"))]
pub(crate) mod animation;
mod beside;
pub mod builtin;
pub(crate) mod checks;
pub(crate) mod components;
pub(crate) mod content;
mod ellipsoid;
mod light;
mod lights;
pub(crate) mod material;
pub(crate) mod mesh;
mod moving;
mod plane;
pub(crate) mod principled;
#[cfg(feature = "serde")]
mod serialised;
pub(crate) mod shadowing;
pub(crate) mod sky;
pub(crate) mod smooth;
pub(crate) mod tangents;
pub(crate) mod texture;

pub(crate) use ellipsoid::ToSphere;
pub use ellipsoid::{Ellipsoid, MAX_ASPECT, MIN_SEMI_AXIS};
pub use light::{Cone, Falloff, Light, LightShape, MAX_SOFT_LIGHTS, Projector};
pub use material::{Finish, Material, MaterialId};
pub use mesh::{Mesh, Triangle};
pub use plane::{MAX_PLANES, PLANE_REACH, Plane};
pub use principled::Principled;
pub use sky::SkyMap;
pub use texture::{MAX_TEXTURE_SIDE, Texture, TextureId, TextureKind, Wrap};

use glam::{DVec3, Vec2, Vec3};

pub(crate) use self::moving::Stamp;
use self::{beside::Beside, mesh::Object};
use crate::{Error, view::camera::MAX_WORLD_COORDINATE};

/// Primitive or object id where nothing was hit.
pub const MISS: u32 = u32::MAX;

pub use crate::view::camera::{MAX_COORDINATE, MIN_EXTENT};

/// Maximum number of lights in a scene.
pub const MAX_LIGHTS: usize = 1 << 20;

/// Ambient light of a scene that has lights and sets no ambient light itself.
const DEFAULT_AMBIENT: f32 = 0.15;

/// Number of warnings of one kind that are logged; further ones are only counted.
pub(crate) const PRINTED_WARNINGS: usize = 5;

/// Light along rays that hit nothing, linear RGB.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Sky {
    /// One colour.
    Constant(Vec3),
    /// A blend along the world's y axis.
    Gradient {
        /// Colour straight down.
        nadir: Vec3,
        /// Colour straight up.
        zenith: Vec3,
    },
    /// An environment picture.
    Map(SkyMap),
}

/// A sphere, intersected analytically.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sphere {
    /// Position of the centre, relative to [`Scene::origin`].
    pub center: Vec3,
    /// Radius in world units, above 0.
    pub radius: f32,
    /// Material of the whole surface.
    pub material: MaterialId,
}

impl Sphere {
    /// Makes a sphere from its centre, relative to [`Scene::origin`], and its radius in world units, above 0.
    pub fn new(center: Vec3, radius: f32, material: MaterialId) -> Self {
        Self { center, radius, material }
    }

    /// Returns the corners of the bounding box.
    fn corners(&self) -> [Vec3; 2] {
        [self.center - self.radius, self.center + self.radius]
    }
}

/// The primitive that an id refers to.
pub(crate) enum Primitive<'a> {
    Triangle(&'a Triangle),
    Sphere(&'a Sphere),
    Ellipsoid(&'a Ellipsoid),
    Plane(&'a Plane),
}

/// A scene to render. Primitive ids follow the scene's order: triangles as they were added, then spheres, ellipsoids
/// and planes. Degenerate triangles are not traced, but keep their ids.
///
/// Positions of meshes, spheres, ellipsoids and planes are f32 numbers relative to [`Scene::origin`], which is 0 by
/// default. Lights, cameras, rays and bounds are in world coordinates, in f64. So a scene far from the world's origin,
/// such as a city in a national grid, loses no precision.
///
/// ```
/// use stereotrace::{Material, Scene, Sphere, glam::Vec3};
///
/// let mut scene = Scene::new();
/// let red = scene.add_material(Material::new(Vec3::new(0.8, 0.1, 0.1)));
/// scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, red))?;
/// assert_eq!(scene.primitive_count(), 1);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    /// Lights in world coordinates. If there are none, only `ambient` lights the surfaces. See also
    /// [`Scene::place_lights`].
    pub lights: Vec<Light>,
    /// Whether lights cast shadows.
    pub shadows: bool,
    /// Light that reaches every surface from everywhere, linear RGB. `None`, the default, means 1 without lights and
    /// 0.15 with lights; see [`Scene::rendered_ambient`]. Frames lit by the sky have no ambient light.
    pub ambient: Option<Vec3>,
    /// Light along rays that hit nothing. It lights surfaces if [`Options::sky_rays`](crate::Options::sky_rays) is set.
    pub sky: Sky,
    origin: DVec3,
    pub(crate) materials: Vec<Material>,
    pub(crate) textures: Vec<Texture>,
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) spheres: Vec<Sphere>,
    ellipsoids: Vec<Ellipsoid>,
    planes: Vec<Plane>,
    mesh_objects: Vec<Object>,
    beside: Beside,
    /// Number of traced triangles with smooth shading.
    smooth: usize,
    /// Number of degenerate triangles.
    pub(crate) dropped: usize,
    /// Number of meshes with a warning about degenerate triangles.
    dropping_meshes: usize,
    /// Stamp that changes whenever triangles change. Scenes with equal stamps have equal primitives. `spheres_stamp`
    /// does the same for spheres, ellipsoids and planes.
    pub(crate) triangles_stamp: Stamp,
    pub(crate) spheres_stamp: Stamp,
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

impl Scene {
    /// Makes an empty scene: black sky, default ambient light, one grey material (id 0).
    pub fn new() -> Self {
        Self {
            lights: Vec::new(),
            shadows: true,
            ambient: None,
            sky: Sky::Constant(Vec3::ZERO),
            origin: DVec3::ZERO,
            materials: vec![Material::new(Vec3::splat(0.7))],
            textures: Vec::new(),
            triangles: Vec::new(),
            spheres: Vec::new(),
            ellipsoids: Vec::new(),
            planes: Vec::new(),
            mesh_objects: Vec::new(),
            beside: Beside::default(),
            smooth: 0,
            dropped: 0,
            dropping_meshes: 0,
            triangles_stamp: Stamp::new(),
            spheres_stamp: Stamp::new(),
        }
    }

    /// Adds a material and returns its id.
    pub fn add_material(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        MaterialId(self.materials.len() as u32 - 1)
    }

    /// Adds a sphere as a separate object.
    ///
    /// # Errors
    /// [`Error::Scene`] for a centre or radius that is not finite or too large, a radius that is not above 0, or an
    /// unknown material.
    pub fn add_sphere(&mut self, sphere: Sphere) -> Result<(), Error> {
        self.check_sphere(self.spheres.len(), &sphere)?;
        self.spheres.push(sphere);
        self.spheres_stamp = Stamp::new();
        Ok(())
    }

    /// Returns the ambient light that is rendered: [`Scene::ambient`] if it is set. Otherwise it is 1 without lights
    /// and 0.15 with lights.
    pub fn rendered_ambient(&self) -> Vec3 {
        self.ambient.unwrap_or(if self.lights.is_empty() { Vec3::ONE } else { Vec3::splat(DEFAULT_AMBIENT) })
    }

    /// Returns the world position that positions of meshes, spheres, ellipsoids and planes are relative to.
    ///
    /// Readers of scene files choose it by [`SceneOptions::origin`](crate::SceneOptions::origin); a new scene has 0.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Sets [`Scene::origin`]. Primitives keep their positions relative to the origin, so they move with it. Lights
    /// keep their world positions.
    ///
    /// # Errors
    /// [`Error::Scene`] for a coordinate that is not a number within ±1e13 ([`MAX_WORLD_COORDINATE`]).
    ///
    /// [`MAX_WORLD_COORDINATE`]: crate::view::camera::MAX_WORLD_COORDINATE
    pub fn set_origin(&mut self, origin: impl Into<DVec3>) -> Result<(), Error> {
        let origin = origin.into();
        if !(origin.is_finite() && origin.abs().max_element() <= MAX_WORLD_COORDINATE) {
            let reason = format!("it is {origin}; its coordinates must be numbers within ±{MAX_WORLD_COORDINATE:e}");
            return Err(Error::Scene { element: "origin".into(), reason });
        }
        self.origin = origin;
        Ok(())
    }

    /// Converts a world position to one relative to the origin.
    pub(crate) fn local(&self, point: DVec3) -> Vec3 {
        (point - self.origin).as_vec3()
    }

    /// Returns the axis-aligned box (low and high corner, world coordinates) around all traced primitives except
    /// planes, or `None` if there are none.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        self.local_bounds().map(|(low, high)| (self.origin + low.as_dvec3(), self.origin + high.as_dvec3()))
    }

    /// Returns [`Scene::bounds`] relative to the origin.
    pub(crate) fn local_bounds(&self) -> Option<(Vec3, Vec3)> {
        let triangles = self.triangles.iter().filter(|t| !t.is_degenerate()).flat_map(|t| t.corners);
        let spheres = self.spheres.iter().flat_map(Sphere::corners);
        let ellipsoids = self.ellipsoids.iter().flat_map(Ellipsoid::corners);
        shadowing::around(triangles.chain(spheres).chain(ellipsoids)).map(|[low, high]| (low, high))
    }

    /// Returns the number of primitive ids. Degenerate triangles count.
    pub fn primitive_count(&self) -> usize {
        self.triangles.len() + self.ball_count() + self.planes.len()
    }

    /// Returns the approximate size of the scene in bytes: its primitives, and the pixels of its textures and sky.
    /// Clones share the pixels.
    pub fn memory(&self) -> usize {
        let lists = size_of_val(&*self.triangles)
            + size_of_val(&*self.beside.uv)
            + size_of_val(&*self.beside.colors)
            + size_of_val(&*self.beside.tangents)
            + size_of_val(&*self.spheres)
            + size_of_val(&*self.ellipsoids)
            + size_of_val(&*self.lights);
        let pixels = self.textures.iter().map(|texture| match texture.kind() {
            TextureKind::Image { pixels, .. } => size_of_val(&**pixels),
            TextureKind::Checkerboard { .. } => 0,
        });
        let sky = if let Sky::Map(map) = &self.sky { size_of_val(map.pixels()) } else { 0 };
        lists + pixels.sum::<usize>() + sky
    }

    /// Returns a primitive by its id, which must be below [`Scene::primitive_count`].
    pub(crate) fn primitive(&self, id: u32) -> Primitive<'_> {
        let index = id as usize;
        let (triangles, spheres) = (self.triangles.len(), self.spheres.len());
        match self.triangles.get(index) {
            Some(triangle) => Primitive::Triangle(triangle),
            None if index < triangles + spheres => Primitive::Sphere(&self.spheres[index - triangles]),
            None if index < triangles + self.ball_count() => {
                Primitive::Ellipsoid(&self.ellipsoids[index - triangles - spheres])
            }
            None => Primitive::Plane(&self.planes[index - triangles - self.ball_count()]),
        }
    }

    /// Returns the number of spheres and ellipsoids.
    fn ball_count(&self) -> usize {
        self.spheres.len() + self.ellipsoids.len()
    }

    /// Returns the number of triangles without area. They are not traced.
    pub fn degenerate_count(&self) -> usize {
        self.dropped
    }

    /// Returns all triangles, including degenerate ones; the index is the primitive id.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Returns all spheres; the primitive id is the index plus the number of triangles.
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// Returns all materials; the index is the [`MaterialId`].
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Returns whether some traced triangle has normals for smooth shading.
    pub fn has_normals(&self) -> bool {
        self.smooth > 0
    }

    /// Returns the number of objects: meshes, spheres, ellipsoids and planes.
    pub fn object_count(&self) -> usize {
        self.mesh_objects.len() + self.ball_count() + self.planes.len()
    }

    /// Returns the object of a primitive. Objects count meshes as they were added, then spheres, ellipsoids and planes.
    /// Ids out of range give [`MISS`].
    pub fn object_of(&self, primitive: u32) -> u32 {
        let triangles = self.triangles.len() as u32;
        if primitive as usize >= self.primitive_count() {
            return crate::MISS;
        }
        if primitive >= triangles {
            return self.mesh_objects.len() as u32 + (primitive - triangles);
        }
        self.mesh_objects.partition_point(|object| object.first_primitive <= primitive) as u32 - 1
    }

    /// Returns the texture coordinates at a triangle's corners, or `None` if its mesh has none.
    pub(crate) fn uv_of(&self, primitive: u32) -> Option<&[Vec2; 3]> {
        let mesh = self.mesh_objects.get(self.object_of(primitive) as usize)?;
        self.uv().get(primitive as usize).filter(|_| mesh.has_uv)
    }

    /// Returns the box of each object, relative to the origin; `None` for planes and empty meshes.
    #[cfg(feature = "dataset")]
    pub(crate) fn object_boxes(&self) -> Vec<Option<(Vec3, Vec3)>> {
        let mut boxes = vec![None; self.object_count()];
        for (primitive, triangle) in (0..).zip(&self.triangles) {
            let own: &mut Option<(Vec3, Vec3)> = &mut boxes[self.object_of(primitive) as usize];
            for corner in triangle.corners {
                let (low, high) = own.unwrap_or((corner, corner));
                *own = Some((low.min(corner), high.max(corner)));
            }
        }
        let balls = self.spheres.iter().map(Sphere::corners).chain(self.ellipsoids.iter().map(Ellipsoid::corners));
        for (own, [low, high]) in boxes[self.mesh_objects.len()..].iter_mut().zip(balls) {
            *own = Some((low, high));
        }
        boxes
    }

    /// Returns the name of a mesh object. It is empty for other objects and for indices out of range.
    pub fn object_name(&self, object: u32) -> &str {
        self.mesh_objects.get(object as usize).map_or("", |object| &object.name)
    }
}

/// Converts an sRGB value to linear light (IEC 61966-2-1).
#[cfg(any(feature = "scene-files", feature = "sky"))]
pub(crate) fn linear(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
