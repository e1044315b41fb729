//! What is rendered: triangle meshes, spheres, ellipsoids and planes, materials, lights, ambient light and a sky.

mod beside;
pub mod builtin;
mod checks;
pub(crate) mod components;
mod content;
#[cfg(any(feature = "obj", feature = "ply"))]
mod ears;
mod ellipsoid;
#[cfg(feature = "scene-files")]
mod file;
#[cfg(feature = "gltf")]
mod gltf;
mod light;
mod lights;
mod material;
mod mesh;
mod moving;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "scene-files")]
mod options;
#[cfg(feature = "scene-files")]
mod origin;
mod plane;
#[cfg(feature = "ply")]
mod ply;
#[cfg(any(feature = "obj", feature = "ply"))]
mod polygon;
#[cfg(feature = "serde")]
mod serialised;
mod sky;
mod smooth;
pub mod suite;
mod texture;
#[cfg(feature = "scene-files")]
mod warnings;

pub(crate) use ellipsoid::ToSphere;
pub use ellipsoid::{Ellipsoid, MAX_ASPECT, MIN_SEMI_AXIS};
#[cfg(feature = "scene-files")]
pub use file::SceneFile;
pub use light::{Light, LightShape, MAX_SOFT_LIGHTS};
pub use material::{Finish, Material, MaterialId};
pub use mesh::{Mesh, Triangle};
#[cfg(feature = "scene-files")]
pub use options::{MissingTextures, ObjOptions, OutsideFiles, SceneOptions};
#[cfg(feature = "scene-files")]
pub use origin::Origin;
pub use plane::{MAX_PLANES, PLANE_REACH, Plane};
pub use sky::SkyMap;
pub use texture::{MAX_TEXTURE_SIDE, Texture, TextureId, TextureKind, Wrap};

use glam::{DVec3, Vec3};

pub(crate) use self::moving::Stamp;
use self::{beside::Beside, mesh::Object};
#[cfg(feature = "obj")]
use crate::Limits;
#[cfg(any(feature = "obj", feature = "gltf", feature = "ply"))]
use crate::input::Files;
use crate::{Error, camera::MAX_WORLD_COORDINATE};

/// Coordinates relative to [`Scene::origin`] that are larger than this (in world units) are refused: past it the box
/// tests of the traversal overflow f32.
pub const MAX_COORDINATE: f32 = 1e8;

/// The least length, in world units, of a scene's longest side: the products of an intersection would vanish in f32.
/// What is smaller may stand in a larger scene.
pub const MIN_EXTENT: f32 = 1e-6;

/// Lights that a scene may have at most.
pub const MAX_LIGHTS: usize = 1 << 20;

/// The share of the light that every surface gets where there are lights and nothing else is said.
const DEFAULT_AMBIENT: f32 = 0.15;

/// Of like warnings so many are logged; the rest are counted.
const PRINTED_WARNINGS: usize = 5;

/// What a ray sees that hits nothing, linear RGB.
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
    /// A picture.
    Map(SkyMap),
}

/// A sphere, given by its equation.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sphere {
    /// Position of its centre, relative to [`Scene::origin`].
    pub center: Vec3,
    /// Radius in world units, above 0.
    pub radius: f32,
    /// Its material.
    pub material: MaterialId,
}

impl Sphere {
    /// A sphere about a position relative to [`Scene::origin`]; the radius is in world units, above 0.
    pub fn new(center: Vec3, radius: f32, material: MaterialId) -> Self {
        Self { center, radius, material }
    }
}

/// What a primitive id names.
pub(crate) enum Primitive<'a> {
    Triangle(&'a Triangle),
    Sphere(&'a Sphere),
    Ellipsoid(&'a Ellipsoid),
    Plane(&'a Plane),
}

/// A scene to render. Primitive ids are its own order: triangles in the order they were added (dropped ones keep
/// their number), then spheres, then ellipsoids, then planes.
///
/// Positions of meshes, spheres, ellipsoids and planes are f32 numbers relative to [`Scene::origin`], which is 0 unless
/// it was set. Lights, cameras, rays and bounds are in world coordinates, in f64. A scene far from the world's origin,
/// such as a city in a national grid, so loses no precision.
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
    /// Empty: only `ambient` lights the surfaces, see [`Scene::place_lights`].
    pub lights: Vec<Light>,
    /// Whether lights cast shadows.
    pub shadows: bool,
    /// Light that reaches every surface from everywhere, linear RGB. `None`, as in a new scene, is light by rule: 1
    /// without lights, and 0.15 with them, or they would add to what is white already. See
    /// [`Scene::rendered_ambient`]. Frames lit by the sky have none.
    pub ambient: Option<Vec3>,
    /// What a ray sees that hits nothing. It lights surfaces where [`Options::sky_rays`](crate::Options::sky_rays)
    /// asks it to.
    pub sky: Sky,
    origin: DVec3,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    triangles: Vec<Triangle>,
    spheres: Vec<Sphere>,
    ellipsoids: Vec<Ellipsoid>,
    planes: Vec<Plane>,
    mesh_objects: Vec<Object>,
    beside: Beside,
    /// How many of the triangles that are traced are smooth.
    smooth: usize,
    /// How many of the triangles are degenerate.
    dropped: usize,
    /// How many meshes were warned of for it.
    dropping_meshes: usize,
    /// Renewed when triangles change, or spheres, ellipsoids or planes: equal ones are of equal primitives.
    pub(crate) triangles_stamp: Stamp,
    pub(crate) spheres_stamp: Stamp,
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

impl Scene {
    /// An empty scene: black sky, ambient light by rule, one grey material (id 0).
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

    /// Adds a sphere as an object of its own.
    ///
    /// # Errors
    /// [`Error::Scene`] for a centre or radius that is not finite or too large, a radius that is not above 0, or a
    /// material that is not there.
    pub fn add_sphere(&mut self, sphere: Sphere) -> Result<(), Error> {
        self.check_sphere(self.spheres.len(), &sphere)?;
        self.spheres.push(sphere);
        self.spheres_stamp = Stamp::new();
        Ok(())
    }

    /// Reads a scene from an OBJ file and the MTL files it names. A face of n corners becomes n - 2 triangles: a fan
    /// from its first corner, or ears cut off where it is concave; one that crosses itself or is far from flat is
    /// fanned and logged. Missing normals make flat triangles, a missing MTL is logged and gives grey. Colours of
    /// vertices (`v x y z r g b`) are taken as sRGB. Textures (`map_Kd`, `map_d`) are read with the feature
    /// `textures`, those of materials that are used. What pictures don't show of a file is logged once a file:
    /// highlights, lines and points, and the like; a mirror or glass without a diffuse colour takes its specular
    /// one. DESIGN, section 8, has all that is read of an MTL. The scene has no lights yet: see
    /// [`Scene::place_lights`].
    ///
    /// # Errors
    /// [`Error::Io`] if the file can't be read or is no regular one; [`Error::TooLarge`] if it is larger than
    /// [`Limits`] says; [`Error::Parse`], naming the line where it is known, if it is UTF-16 or its content is
    /// wrong: numbers that don't parse or are not finite, indices out of range, no faces at all, textures that
    /// can't be read.
    #[cfg(feature = "obj")]
    pub fn from_obj(path: impl AsRef<std::path::Path>) -> Result<Self, Error> {
        Self::from_obj_with(path, &ObjOptions::default())
    }

    /// [`Scene::from_obj`] with other limits than the usual ones.
    ///
    /// # Errors
    /// Those of [`Scene::from_obj`].
    #[cfg(feature = "obj")]
    pub fn from_obj_within(path: impl AsRef<std::path::Path>, limits: &Limits) -> Result<Self, Error> {
        Self::from_obj_with(path, &ObjOptions::default().limits(*limits))
    }

    /// [`Scene::from_obj`] with limits, missing textures and missing normals as `options` say.
    ///
    /// # Errors
    /// Those of [`Scene::from_obj`], and [`Error::Scene`] for a crease angle that is not within 0 to 180 degrees.
    #[cfg(feature = "obj")]
    pub fn from_obj_with(path: impl AsRef<std::path::Path>, options: &ObjOptions) -> Result<Self, Error> {
        obj::read(Files::Disk(&options.folder_of(path.as_ref())), path.as_ref(), options)
    }

    /// Reads a scene from a glTF 2.0 file (.gltf or .glb), with its lights: the meshes of its default scene where its
    /// nodes show them, with base colours, metal and roughness, emission, masks and transparency as our materials
    /// have them. `docs/FORMATS.md` has the rules; what pictures don't show is logged once. [`SceneFile::open`] has
    /// its cameras too.
    ///
    /// # Errors
    /// [`Error::Io`] if the file or one that it names can't be read or is no regular one; [`Error::TooLarge`] if one is
    /// larger than [`Limits`] says, or has more triangles; [`Error::Parse`], naming the item, if its content is
    /// wrong: JSON that is none, indices and lengths out of range, numbers that are not finite, nodes with two
    /// parents, extensions that it requires and that are not known, no triangles at all, textures that can't be read.
    #[cfg(feature = "gltf")]
    pub fn from_gltf(path: impl AsRef<std::path::Path>) -> Result<Self, Error> {
        Self::from_gltf_with(path, &SceneOptions::default())
    }

    /// [`Scene::from_gltf`] with limits, missing textures and missing normals as `options` say.
    ///
    /// # Errors
    /// Those of [`Scene::from_gltf`], and [`Error::Scene`] for a crease angle that is not within 0 to 180 degrees.
    #[cfg(feature = "gltf")]
    pub fn from_gltf_with(path: impl AsRef<std::path::Path>, options: &SceneOptions) -> Result<Self, Error> {
        gltf::read(Files::Disk(&options.folder_of(path.as_ref())), path.as_ref(), options).map(|file| file.scene)
    }

    /// Reads a mesh from a PLY file, text or binary of either byte order: positions, normals, colours (taken as sRGB)
    /// and texture coordinates of vertices, and faces, which become triangles as those of an OBJ do. It is grey,
    /// where its vertices have no colours. `docs/FORMATS.md` has all that is read; what is not is logged once. The
    /// scene has no lights yet: see [`Scene::place_lights`].
    ///
    /// # Errors
    /// [`Error::Io`] if the file can't be read or is no regular one; [`Error::TooLarge`] if it is larger than
    /// [`Limits`] says; [`Error::Parse`], naming element and line where they are known, if its content is wrong: a
    /// header that is none, numbers that are missing or not finite, corners out of range, no faces at all, as in
    /// clouds of points.
    #[cfg(feature = "ply")]
    pub fn from_ply(path: impl AsRef<std::path::Path>) -> Result<Self, Error> {
        Self::from_ply_with(path, &SceneOptions::default())
    }

    /// [`Scene::from_ply`] with limits and missing normals as `options` say.
    ///
    /// # Errors
    /// Those of [`Scene::from_ply`], and [`Error::Scene`] for a crease angle that is not within 0 to 180 degrees.
    #[cfg(feature = "ply")]
    pub fn from_ply_with(path: impl AsRef<std::path::Path>, options: &SceneOptions) -> Result<Self, Error> {
        ply::read(Files::Disk(&options.folder_of(path.as_ref())), path.as_ref(), options)
    }

    /// The ambient light that is rendered: [`Scene::ambient`] where it is given, else 1 without lights and 0.15 with
    /// them.
    pub fn rendered_ambient(&self) -> Vec3 {
        self.ambient.unwrap_or(if self.lights.is_empty() { Vec3::ONE } else { Vec3::splat(DEFAULT_AMBIENT) })
    }

    /// World position that the positions of meshes, spheres, ellipsoids and planes are relative to.
    ///
    /// Readers of scene files choose it by [`SceneOptions::origin`](crate::SceneOptions::origin); a new scene has 0.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Sets [`Scene::origin`]. What was added keeps its positions relative to the origin, so that it moves along.
    /// Lights stay where they are in the world.
    ///
    /// # Errors
    /// [`Error::Scene`] for a coordinate that is not a number within ±1e13 ([`MAX_WORLD_COORDINATE`]).
    ///
    /// [`MAX_WORLD_COORDINATE`]: crate::camera::MAX_WORLD_COORDINATE
    pub fn set_origin(&mut self, origin: impl Into<DVec3>) -> Result<(), Error> {
        let origin = origin.into();
        if !(origin.is_finite() && origin.abs().max_element() <= MAX_WORLD_COORDINATE) {
            let reason = format!("it is {origin}; its coordinates must be numbers within ±{MAX_WORLD_COORDINATE:e}");
            return Err(Error::Scene { element: "origin".into(), reason });
        }
        self.origin = origin;
        Ok(())
    }

    /// A world position relative to the origin.
    pub(crate) fn local(&self, point: DVec3) -> Vec3 {
        (point - self.origin).as_vec3()
    }

    /// The axis-aligned box around all primitives that can be hit but planes, in world coordinates; `None` if there are
    /// none.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        self.local_bounds().map(|(low, high)| (self.origin + low.as_dvec3(), self.origin + high.as_dvec3()))
    }

    /// The same relative to the origin.
    pub(crate) fn local_bounds(&self) -> Option<(Vec3, Vec3)> {
        let triangles = self.triangles.iter().filter(|t| !t.is_degenerate()).flat_map(|t| t.corners);
        let spheres = self.spheres.iter().flat_map(|s| [s.center - s.radius, s.center + s.radius]);
        let ellipsoids = self.ellipsoids.iter().flat_map(Ellipsoid::corners);
        triangles.chain(spheres).chain(ellipsoids).fold(None, |bounds: Option<(Vec3, Vec3)>, point| {
            let (low, high) = bounds.unwrap_or((point, point));
            Some((low.min(point), high.max(point)))
        })
    }

    /// Number of primitive ids: triangles (dropped ones too), then spheres, ellipsoids and planes.
    pub fn primitive_count(&self) -> usize {
        self.triangles.len() + self.ball_count() + self.planes.len()
    }

    /// The memory that the scene takes, in bytes, about: its primitives, and the pixels of its textures and sky, which
    /// clones share.
    pub fn memory(&self) -> usize {
        let lists = size_of_val(&*self.triangles)
            + size_of_val(&*self.beside.uv)
            + size_of_val(&*self.beside.colors)
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

    /// A primitive by its id, which must be there.
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

    /// Number of spheres and ellipsoids.
    fn ball_count(&self) -> usize {
        self.spheres.len() + self.ellipsoids.len()
    }

    /// Triangles without area, which are counted and not traced.
    pub fn degenerate_count(&self) -> usize {
        self.dropped
    }

    /// All triangles, degenerate ones too; index = primitive id.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// All spheres; index + number of triangles = primitive id.
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// All materials; index = [`MaterialId`].
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Some triangle that is traced has normals for smooth shading.
    pub fn has_normals(&self) -> bool {
        self.smooth > 0
    }

    /// Number of objects: meshes, then spheres, ellipsoids and planes.
    pub fn object_count(&self) -> usize {
        self.mesh_objects.len() + self.ball_count() + self.planes.len()
    }

    /// The object of a primitive: meshes count first, in the order they were added, then spheres, ellipsoids and
    /// planes. [`MISS`](crate::MISS) for numbers out of range.
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

    /// The name of an object: its mesh's, empty for spheres, ellipsoids, planes and for numbers out of range.
    pub fn object_name(&self, object: u32) -> &str {
        self.mesh_objects.get(object as usize).map_or("", |object| &object.name)
    }
}

/// The light of an sRGB value (IEC 61966-2-1).
#[cfg(any(feature = "scene-files", feature = "sky"))]
fn linear(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
