//! Scenes.

use std::{
    path::PathBuf,
    sync::atomic::{AtomicU64, Ordering},
};

use pyo3::prelude::*;
use sha2::{Digest, Sha256};
use stereotrace::{
    Builtin, Ellipsoid, MaterialId, Mesh, MissingTextures, Plane, SceneFile, SceneOptions, Sky, SkyMap, Sphere,
    StereoCamera, Texture, TextureId, Wrap,
    glam::{Affine3A, Mat3, Mat4, Vec3},
};

use crate::{
    camera::Camera,
    errors::{raised, refused},
    light::Light,
    material::Material,
    values::{self, Color, Point, named, tuple},
};

/// Of all scenes and their states, so that a renderer knows which of them stands on its device.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct State {
    scene: u64,
    change: u64,
}

impl State {
    /// Whether two are states of one scene.
    pub(crate) fn is_of_scene(self, other: Self) -> bool {
        self.scene == other.scene
    }

    fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self { scene: NEXT.fetch_add(1, Ordering::Relaxed), change: 0 }
    }
}

#[pyclass(module = "stereotrace")]
pub(crate) struct Scene {
    pub(crate) inner: stereotrace::Scene,
    pub(crate) state: State,
    /// A file's own cameras.
    cameras: Vec<(String, StereoCamera)>,
    builtin: Option<Builtin>,
}

impl Scene {
    fn of(inner: stereotrace::Scene, cameras: Vec<(String, StereoCamera)>, builtin: Option<Builtin>) -> Self {
        Self { inner, state: State::new(), cameras, builtin }
    }

    /// The scene, which changes now.
    fn changed(&mut self) -> &mut stereotrace::Scene {
        self.state.change += 1;
        &mut self.inner
    }

    fn check_material(&self, id: u32) -> PyResult<()> {
        let count = self.inner.materials().len();
        match (id as usize) < count {
            true => Ok(()),
            false => Err(refused(format!("material {id}: the scene has {count}, counted from 0"))),
        }
    }
}

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Self::of(stereotrace::Scene::new(), Vec::new(), None)
    }

    #[staticmethod]
    #[pyo3(signature = (path, *, crease_angle = None, missing_textures = "error"))]
    fn open(py: Python<'_>, path: PathBuf, crease_angle: Option<f32>, missing_textures: &str) -> PyResult<Self> {
        let missing = match missing_textures {
            "error" => MissingTextures::Error,
            "warn" => MissingTextures::Warn,
            other => return Err(refused(format!("missing_textures: '{other}' is neither 'error' nor 'warn'"))),
        };
        let options = SceneOptions::default().crease_angle(crease_angle).missing_textures(missing);
        let SceneFile { scene, cameras, .. } = py.detach(|| SceneFile::open(path, &options)).map_err(raised)?;
        Ok(Self::of(scene, cameras, None))
    }

    #[staticmethod]
    fn builtin(py: Python<'_>, name: &str) -> PyResult<Self> {
        let builtin: Builtin = named(name)?;
        Ok(Self::of(py.detach(|| builtin.scene()), Vec::new(), Some(builtin)))
    }

    fn copy(&self) -> Self {
        Self::of(self.inner.clone(), self.cameras.clone(), self.builtin)
    }

    fn __copy__(&self) -> Self {
        self.copy()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.copy()
    }

    #[pyo3(signature = (name = None, size = (640, 480)))]
    fn camera(&self, name: Option<&str>, size: (u32, u32)) -> PyResult<Camera> {
        let own = match name {
            None => self.cameras.first(),
            Some(name) => match self.cameras.iter().find(|(own, _)| own == name) {
                None => {
                    let own = self.camera_names().join(", ");
                    let there_are = if own.is_empty() { "none".into() } else { own };
                    return Err(refused(format!("no camera '{name}' in this scene; there are: {there_are}")));
                }
                found => found,
            },
        };
        match (self.builtin, own) {
            (Some(builtin), _) => Camera::checked(builtin.camera(size.0, size.1)),
            (None, Some((_, camera))) => Camera::checked(camera.size(size.0, size.1)),
            (None, None) => {
                let bounds = self.inner.bounds();
                let bounds = bounds.ok_or_else(|| refused("the scene is empty, or has only infinite planes"))?;
                Camera::checked(StereoCamera::fitting(bounds, size.0, size.1))
            }
        }
    }

    #[getter]
    fn camera_names(&self) -> Vec<&str> {
        self.cameras.iter().map(|(name, _)| name.as_str()).collect()
    }

    #[pyo3(signature = (vertices, faces, *, name = "", material = None, normals = None, uv = None, colors = None, crease_angle = None))]
    #[expect(clippy::too_many_arguments, reason = "Python's keywords")]
    fn add_mesh(
        &mut self,
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        name: &str,
        material: Option<&Bound<'_, PyAny>>,
        normals: Option<&Bound<'_, PyAny>>,
        uv: Option<&Bound<'_, PyAny>>,
        colors: Option<&Bound<'_, PyAny>>,
        crease_angle: Option<f32>,
    ) -> PyResult<u32> {
        let positions = values::points("vertices", vertices)?;
        let (count, faces) = (positions.len(), values::faces(faces)?);
        if normals.is_some() && crease_angle.is_some() {
            return Err(refused("mesh: normals are given, and crease_angle would make others; give one of them"));
        }
        let mut mesh = Mesh::new(positions, Vec::new()).name(name);
        if let Some(material) = material {
            let ids = values::indices("material", material)?;
            mesh = mesh.materials(ids.into_iter().map(MaterialId).collect());
        }
        if let Some(normals) = normals {
            mesh = mesh.normals(values::corner_normals(normals, count, &faces)?);
        }
        if let Some(uv) = uv {
            mesh = mesh.uv(values::corner_uv(uv, count, &faces)?);
        }
        if let Some(colors) = colors {
            mesh = mesh.colors(values::corner_colors(colors, count, &faces)?);
        }
        mesh.triangles = faces;
        if let Some(degrees) = crease_angle {
            mesh = mesh.smooth(degrees).map_err(raised)?;
        }
        self.changed().add_mesh(&mesh).map_err(raised)?;
        // Meshes count first among objects: those behind this one are spheres, ellipsoids and planes.
        Ok(self.inner.object_of(self.inner.triangles().len().saturating_sub(1) as u32))
    }

    #[pyo3(signature = (center, radius, material = 0))]
    fn add_sphere(&mut self, center: Point, radius: f32, material: u32) -> PyResult<()> {
        self.changed().add_sphere(Sphere::new(center.0, radius, MaterialId(material))).map_err(raised)
    }

    #[pyo3(signature = (centers, radii, materials = None))]
    fn add_spheres(
        &mut self,
        centers: &Bound<'_, PyAny>,
        radii: &Bound<'_, PyAny>,
        materials: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let centers = values::points("centers", centers)?;
        let radii: Vec<f32> = match radii.extract::<f32>() {
            Ok(radius) => vec![radius; centers.len()],
            Err(_) => radii.extract().map_err(|_| refused("radii: they must be a number, or one a sphere"))?,
        };
        let materials = materials.map_or(Ok(vec![0]), |ids| values::indices("materials", ids))?;
        for (what, found) in [("radii", radii.len()), ("materials", materials.len())] {
            if found != centers.len() && !(what == "materials" && found == 1) {
                return Err(refused(format!("{what}: {found} for {} spheres", centers.len())));
            }
        }
        // All of them or none.
        let mut scene = self.inner.clone();
        for (index, (&center, &radius)) in centers.iter().zip(&radii).enumerate() {
            let material = MaterialId(materials[if materials.len() == 1 { 0 } else { index }]);
            scene.add_sphere(Sphere::new(center, radius, material)).map_err(raised)?;
        }
        *self.changed() = scene;
        Ok(())
    }

    #[pyo3(signature = (center, axes, material = 0))]
    fn add_ellipsoid(&mut self, center: Point, axes: &Bound<'_, PyAny>, material: u32) -> PyResult<()> {
        let axes = match axes.extract::<[f32; 3]>() {
            Ok(radii) => Mat3::from_diagonal(Vec3::from_array(radii)),
            // Rows as NumPy has them; glam's columns.
            Err(_) => Mat3::from_cols_array_2d(&matrix::<3>("axes", axes)?).transpose(),
        };
        self.changed().add_ellipsoid(Ellipsoid::new(center.0, axes, MaterialId(material))).map_err(raised)
    }

    #[pyo3(signature = (point, normal = Point(Vec3::Y), material = 0, *, tile = 1.0))]
    fn add_plane(&mut self, point: Point, normal: Point, material: u32, tile: f32) -> PyResult<()> {
        let plane = Plane::new(point.0, normal.0, MaterialId(material)).tile(tile);
        self.changed().add_plane(plane).map_err(raised)
    }

    fn add_material(&mut self, material: Material) -> u32 {
        self.changed().add_material(material.0).0
    }

    fn set_material(&mut self, id: u32, material: Material) -> PyResult<()> {
        self.check_material(id)?;
        self.changed().set_material(MaterialId(id), material.0).map_err(raised)
    }

    #[getter]
    fn materials(&self) -> Vec<Material> {
        self.inner.materials().iter().cloned().map(Material).collect()
    }

    #[pyo3(signature = (picture, wrap = "repeat"))]
    fn add_texture(&mut self, picture: &Bound<'_, PyAny>, wrap: &str) -> PyResult<u32> {
        let wrap = match wrap {
            "repeat" => Wrap::Repeat,
            "mirror" => Wrap::Mirror,
            "clamp" => Wrap::Clamp,
            other => return Err(refused(format!("wrap: '{other}' is none; there are repeat, mirror and clamp"))),
        };
        let texture = match picture.extract::<PathBuf>() {
            Ok(path) => Texture::open(path),
            Err(_) => {
                let (width, height, pixels) = values::pixels("texture", picture)?;
                Texture::image(width, height, pixels)
            }
        };
        let TextureId(id) = self.changed().add_texture(texture.map_err(raised)?.wrap(wrap));
        Ok(id)
    }

    fn add_checkerboard(&mut self, first: Color, second: Color, squares: u32) -> PyResult<u32> {
        let texture = Texture::checkerboard(first.0, second.0, squares).map_err(raised)?;
        Ok(self.changed().add_texture(texture).0)
    }

    #[getter]
    fn lights(&self) -> Vec<Light> {
        self.inner.lights.iter().copied().map(Light).collect()
    }

    #[setter]
    fn set_lights(&mut self, lights: Vec<Light>) {
        self.changed().lights = lights.into_iter().map(|light| light.0).collect();
    }

    fn add_light(&mut self, light: Light) {
        self.changed().lights.push(light.0);
    }

    fn place_lights(&mut self, count: usize, camera: Camera) -> PyResult<()> {
        self.changed().place_lights(count, &camera.0).map_err(raised)
    }

    /// The lights that `place_lights` would place; the scene stays as it is.
    fn lights_around(&mut self, count: usize, camera: Camera) -> PyResult<Vec<Light>> {
        let before = (std::mem::take(&mut self.inner.lights), self.inner.ambient);
        let placed = self.inner.place_lights(count, &camera.0);
        let lights = std::mem::replace(&mut self.inner.lights, before.0);
        self.inner.ambient = before.1;
        placed.map_err(raised)?;
        Ok(lights.into_iter().map(Light).collect())
    }

    #[getter]
    fn shadows(&self) -> bool {
        self.inner.shadows
    }

    #[setter]
    fn set_shadows(&mut self, shadows: bool) {
        self.changed().shadows = shadows;
    }

    #[getter]
    fn ambient(&self) -> (f32, f32, f32) {
        tuple(self.inner.rendered_ambient())
    }

    /// What was given: `None` where it is by rule.
    #[getter]
    fn given_ambient(&self) -> Option<(f32, f32, f32)> {
        self.inner.ambient.map(tuple)
    }

    #[setter]
    fn set_ambient(&mut self, ambient: Option<Color>) {
        self.changed().ambient = ambient.map(|color| color.0);
    }

    #[pyo3(signature = (color, zenith = None))]
    fn set_sky(&mut self, color: Color, zenith: Option<Color>) {
        self.changed().sky = match zenith {
            None => Sky::Constant(color.0),
            Some(zenith) => Sky::Gradient { nadir: color.0, zenith: zenith.0 },
        };
    }

    fn set_sky_map(&mut self, picture: &Bound<'_, PyAny>) -> PyResult<()> {
        let map = match picture.extract::<PathBuf>() {
            Ok(path) if path.as_os_str() == "procedural" => SkyMap::procedural(1024),
            Ok(path) => SkyMap::open(path),
            Err(_) => {
                let (width, height, pixels) = values::linear_pixels("sky", picture)?;
                SkyMap::new(width, height, pixels)
            }
        };
        self.changed().sky = Sky::Map(map.map_err(raised)?);
        Ok(())
    }

    fn transform_object(&mut self, object: u32, transform: &Bound<'_, PyAny>) -> PyResult<()> {
        let rows = matrix::<4>("transform", transform)?;
        if rows[3] != [0.0, 0.0, 0.0, 1.0] {
            return Err(refused(format!("transform: its last row must be 0, 0, 0, 1, not {:?}", rows[3])));
        }
        let transform = Affine3A::from_mat4(Mat4::from_cols_array_2d(&rows).transpose());
        self.changed().transform_object(object, &transform).map_err(raised)
    }

    #[getter]
    fn bounds(&self) -> Option<[(f32, f32, f32); 2]> {
        self.inner.bounds().map(|(low, high)| [tuple(low), tuple(high)])
    }

    #[getter]
    fn triangle_count(&self) -> usize {
        self.inner.triangles().len()
    }

    #[getter]
    fn primitive_count(&self) -> usize {
        self.inner.primitive_count()
    }

    #[getter]
    fn object_count(&self) -> usize {
        self.inner.object_count()
    }

    fn object_of(&self, primitive: u32) -> u32 {
        self.inner.object_of(primitive)
    }

    fn object_name(&self, object: u32) -> &str {
        self.inner.object_name(object)
    }

    /// A hash of all that pictures of the scene depend on.
    fn sha256(&self, py: Python<'_>) -> String {
        py.detach(|| {
            let mut hash = Sha256::new();
            self.inner.content(|bytes| hash.update(bytes));
            hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
        })
    }

    fn __repr__(&self) -> String {
        let scene = &self.inner;
        format!(
            "Scene({} triangles, {} objects, {} materials, {} lights)",
            scene.triangles().len(),
            scene.object_count(),
            scene.materials().len(),
            scene.lights.len()
        )
    }
}

/// A square matrix, row by row.
fn matrix<const N: usize>(what: &str, value: &Bound<'_, PyAny>) -> PyResult<[[f32; N]; N]> {
    let rows = values::rows::<N>(what, value)?;
    rows.try_into().map_err(|rows: Vec<_>| refused(format!("{what}: {} rows of {N}; there must be {N}", rows.len())))
}
