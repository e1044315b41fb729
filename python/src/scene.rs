//! Scenes.

use std::{
    collections::HashMap,
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use numpy::{IntoPyArray, PyArray3, ndarray::Array3};
use pyo3::{prelude::*, types::PyString};
use stereotrace::{
    Animation, Builtin, Ellipsoid, MaterialId, Mesh, MissingTextures, Origin, OutsideFiles, Plane, SceneFile,
    SceneOptions, Sky, SkyMap, Sphere, StereoCamera, Texture, TextureId, Wrap,
    glam::{Affine3A, Mat3, Mat4, Vec3},
};

use crate::{
    camera::Camera,
    errors::{raised, refused},
    light::Light,
    material::Material,
    pickled::{self, Reduced, reduced},
    values::{self, Color, Point, Position, Size, named, shown, tuple},
};

/// Identity of a scene and of its state, by which a renderer knows what it has uploaded.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct State {
    scene: u64,
    change: u64,
}

impl State {
    /// Returns whether both are states of one scene.
    pub(crate) fn is_of_scene(self, other: Self) -> bool {
        self.scene == other.scene
    }

    fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self { scene: NEXT.fetch_add(1, Ordering::Relaxed), change: 0 }
    }
}

/// A scene to render: meshes, spheres, ellipsoids and planes, their materials, lights and a sky.
///
/// ``Scene()`` is empty: the sky is black, ambient light has its default (see ``ambient``), and there is one grey
/// material, id 0. ``Scene.open`` reads a file, and ``Scene.builtin`` makes a built-in scene.
///
/// World space is right-handed with y up. Coordinates are in world units, within 1e8. Colours are linear RGB, 0 to 1,
/// or 0 or more for lights and skies; one number stands for three equal channels. Array arguments may be anything that
/// ``numpy.asarray`` accepts.
///
/// Ids count from 0. Primitives are the triangles in the order of addition, including those without area, then spheres,
/// ellipsoids and planes. Objects are the meshes in the order of addition, then each sphere, ellipsoid and plane. So a
/// new mesh shifts the ids of spheres, ellipsoids and planes.
///
/// A renderer uploads changes when it next renders the scene. It then checks materials, lights and sky too, and raises
/// ``ValueError`` for values out of range. Changing a scene while it is rendered raises ``RuntimeError``.
///
/// Scenes can be pickled, including their cameras but not their animations. Renderers can't.
#[pyclass(module = "stereotrace")]
pub(crate) struct Scene {
    pub(crate) inner: stereotrace::Scene,
    pub(crate) state: State,
    /// Names and cameras of the scene's file.
    cameras: Vec<(Arc<str>, StereoCamera)>,
    /// Animations of the scene's file.
    animations: Vec<Animation>,
    builtin: Option<Builtin>,
}

impl Scene {
    pub(crate) fn of(
        inner: stereotrace::Scene,
        cameras: Vec<(Arc<str>, StereoCamera)>,
        builtin: Option<Builtin>,
    ) -> Self {
        Self { inner, state: State::new(), cameras, animations: Vec::new(), builtin }
    }

    /// Returns an animation by its name or place. `None` stands for the first one.
    fn animation(&self, wanted: Option<&AnimationName>) -> PyResult<&Animation> {
        let found = match wanted {
            None => self.animations.first(),
            Some(AnimationName::Place(place)) => self.animations.get(*place),
            Some(AnimationName::Name(name)) => self.animations.iter().find(|animation| animation.name() == name),
        };
        found.ok_or_else(|| {
            let wanted = match wanted {
                None => String::new(),
                Some(AnimationName::Place(place)) => format!(" {place}"),
                Some(AnimationName::Name(name)) => format!(" '{name}'"),
            };
            // The message lists at most 20 names.
            let own: Vec<&str> = self.animations.iter().take(20).map(Animation::name).collect();
            let own = if own.is_empty() { "none".into() } else { own.join(", ") };
            refused(format!("no animation{wanted} in this scene; its animations are: {own}"))
        })
    }

    /// Returns the scene to change, and counts the change.
    fn changed(&mut self) -> &mut stereotrace::Scene {
        self.state.change += 1;
        &mut self.inner
    }

    /// Restores a pickled scene.
    pub(crate) fn restored(py: Python<'_>, state: &[u8]) -> PyResult<Self> {
        let (inner, cameras, builtin): (stereotrace::Scene, Vec<(String, String)>, Option<String>) =
            py.detach(|| pickled::value("Scene", state))?;
        let cameras = cameras.into_iter().map(|(name, text)| {
            let camera = StereoCamera::from_json_str(&text).map_err(raised)?;
            Ok((name.into(), camera))
        });
        let builtin = builtin.as_deref().map(named).transpose()?;
        Ok(Self::of(inner, cameras.collect::<PyResult<_>>()?, builtin))
    }

    fn check_material(&self, id: u32) -> PyResult<()> {
        let count = self.inner.materials().len();
        match (id as usize) < count {
            true => Ok(()),
            false => Err(refused(format!("material {id}: the scene has {count}, counted from 0"))),
        }
    }
}

/// Parts of a mesh beside vertices and faces, as Python's keywords.
struct Parts<'a, 'py> {
    name: &'a str,
    material: Option<&'a Bound<'py, PyAny>>,
    normals: Option<&'a Bound<'py, PyAny>>,
    uv: Option<&'a Bound<'py, PyAny>>,
    colors: Option<&'a Bound<'py, PyAny>>,
    crease_angle: Option<f32>,
}

impl Parts<'_, '_> {
    fn mesh(self, vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> PyResult<Mesh> {
        let positions = values::points("vertices", vertices)?;
        let (count, faces) = (positions.len(), values::faces(faces)?);
        if self.normals.is_some() && self.crease_angle.is_some() {
            return Err(refused("mesh: normals are given, but crease_angle would replace them; give one of them"));
        }
        let mut mesh = Mesh::new(positions, Vec::new()).name(self.name);
        if let Some(material) = self.material {
            let ids = values::indices("material", material)?;
            mesh = mesh.materials(ids.into_iter().map(MaterialId).collect());
        }
        if let Some(normals) = self.normals {
            mesh = mesh.normals(values::corner_normals(normals, count, &faces)?);
        }
        if let Some(uv) = self.uv {
            mesh = mesh.uv(values::corner_uv(uv, count, &faces)?);
        }
        if let Some(colors) = self.colors {
            mesh = mesh.colors(values::corner_colors(colors, count, &faces)?);
        }
        mesh.triangles = faces;
        match self.crease_angle {
            Some(degrees) => mesh.smooth(degrees).map_err(raised),
            None => Ok(mesh),
        }
    }
}

/// An animation's name, or its place in the list.
#[derive(FromPyObject)]
enum AnimationName {
    Place(usize),
    Name(String),
}

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Self::of(stereotrace::Scene::new(), Vec::new(), None)
    }

    /// Reads a scene from a file: OBJ with its MTL files, glTF 2.0 (.gltf, .glb) or PLY. The content determines the
    /// format. If it does not, the file's ending does.
    ///
    /// Only glTF files bring lights and cameras (``camera_names``). For other files see ``place_lights``.
    ///
    /// - ``crease_angle``: in degrees, 0 to 180. Objects without normals get smooth edges where adjacent triangles
    ///   differ by less than this angle. Default: such objects are flat.
    /// - ``missing_textures``: ``"error"`` raises for a texture that can't be read; ``"warn"`` logs a warning and
    ///   leaves the texture out.
    /// - ``outside_files``: ``"refuse"`` raises if the scene names files outside its folder, such as ``../textures``;
    ///   ``"allow"`` reads them.
    /// - ``origin``: world position that the file's coordinates are stored relative to: three numbers, ``"none"`` for
    ///   (0, 0, 0), or ``"auto"``, the default. ``"auto"`` is (0, 0, 0) too, unless the file lies farther away than 8
    ///   times its longest side. Then it is the rounded middle of the file. Cameras, lights, bounds and ground truth
    ///   stay in world coordinates, in double precision.
    ///
    /// Raises ``OSError`` if the file can't be read. Raises ``ValueError`` for other formats, for files over 1 GiB, and
    /// for wrong content, where the message names the line or item.
    #[staticmethod]
    #[pyo3(signature = (
        path, *, crease_angle = None, missing_textures = "error", outside_files = "refuse", origin = None
    ))]
    fn open(
        py: Python<'_>,
        path: PathBuf,
        crease_angle: Option<f32>,
        missing_textures: &str,
        outside_files: &str,
        origin: Option<OriginArgument>,
    ) -> PyResult<Self> {
        let missing = match missing_textures {
            "error" => MissingTextures::Error,
            "warn" => MissingTextures::Warn,
            other => return Err(refused(format!("missing_textures: '{other}' is neither 'error' nor 'warn'"))),
        };
        let outside = match outside_files {
            "refuse" => OutsideFiles::Refuse,
            "allow" => OutsideFiles::Allow,
            other => return Err(refused(format!("outside_files: '{other}' is neither 'refuse' nor 'allow'"))),
        };
        let options = SceneOptions::default().crease_angle(crease_angle).missing_textures(missing);
        let options = options.outside_files(outside).outside_option_name("outside_files=\"allow\"");
        let options = options.origin(origin.map_or(Origin::Auto, |origin| origin.0));
        let file = py.detach(|| SceneFile::open(path, &options)).map_err(raised)?;
        let SceneFile { scene, cameras, animations, .. } = file;
        Ok(Self { animations, ..Self::of(scene, cameras, None) })
    }

    /// Makes a built-in scene with lights and a sky, one of ``BUILTINS``. ``camera`` returns its camera. Raises
    /// ``ValueError`` for another name.
    #[staticmethod]
    fn builtin(py: Python<'_>, name: &str) -> PyResult<Self> {
        let builtin: Builtin = named(name)?;
        Ok(Self::of(py.detach(|| builtin.scene()), Vec::new(), Some(builtin)))
    }

    /// Returns an independent copy, with the same cameras and animations. ``copy.copy`` and ``copy.deepcopy`` do the
    /// same.
    fn copy(&self) -> Self {
        let animations = self.animations.clone();
        Self { animations, ..Self::of(self.inner.clone(), self.cameras.clone(), self.builtin) }
    }

    /// Names and durations of the file's animations, in its order: a list of tuples of a str and seconds. A duration is
    /// the time of the last key frame. Only glTF files have animations.
    #[getter]
    fn animations(&self) -> Vec<(&str, f64)> {
        self.animations.iter().map(|animation| (animation.name(), animation.duration())).collect()
    }

    /// Moves the scene's objects, lights and cameras to their places at a time of an animation.
    ///
    /// ``seconds`` counts from the animation's begin. Before its first key frame and after its last one, a property
    /// keeps that key frame's value. ``animation`` is a name, or a place in ``animations``; by default it is the first.
    /// Lights with another shape or intensity than the file's do not move. Raises ``ValueError`` for an unknown
    /// animation and for a time that is not finite. Also raises it if an object has another number of triangles.
    #[pyo3(signature = (seconds, animation = None))]
    fn pose(&mut self, seconds: f64, animation: Option<AnimationName>) -> PyResult<()> {
        let animation = self.animation(animation.as_ref())?.clone();
        animation.pose(self.changed(), seconds).map_err(raised)?;
        let cameras = animation.cameras(seconds).map_err(raised)?;
        for ((_, camera), posed) in self.cameras.iter_mut().zip(cameras) {
            *camera = posed;
        }
        Ok(())
    }

    fn __copy__(&self) -> Self {
        self.copy()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.copy()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let cameras = self.cameras.iter().map(|(name, camera)| Ok((name, camera.to_json().map_err(raised)?)));
        let cameras = cameras.collect::<PyResult<Vec<_>>>()?;
        let builtin = self.builtin.map(|builtin| builtin.to_string());
        let state = py.detach(|| pickled::bytes(&(&self.inner, cameras, builtin)))?;
        reduced(py, "Scene", &state)
    }

    /// Returns the scene's camera: the camera of a built-in scene, else the file's camera ``name`` or its first. A
    /// scene without cameras gets the camera of ``Camera.fitting``.
    ///
    /// ``size`` is a tuple of width and height in pixels. The interaxial of a built-in scene's camera is 15 pixels at a
    /// width of 600 pixels, and scales with the width. Raises ``ValueError`` for an unknown name, for an invalid size,
    /// and if a scene without cameras is empty or has only infinite planes.
    #[pyo3(signature = (name = None, size = Size(640, 480)))]
    fn camera(&self, name: Option<&str>, size: Size) -> PyResult<Camera> {
        let own = match name {
            None => self.cameras.first(),
            Some(name) => match self.cameras.iter().find(|(own, _)| **own == *name) {
                None => {
                    // The message lists at most 20 names.
                    let own: Vec<&str> = self.cameras.iter().take(20).map(|(name, _)| &**name).collect();
                    let own = own.join(", ");
                    let there_are = if own.is_empty() { "none".into() } else { own };
                    return Err(refused(format!("no camera '{name}' in this scene; its cameras are: {there_are}")));
                }
                found => found,
            },
        };
        match (self.builtin, own) {
            (Some(builtin), _) => Camera::checked(builtin.camera(size.0, size.1)),
            (None, Some((_, camera))) => Camera::checked(camera.size(size.0, size.1)),
            (None, None) => Camera::fitting(self, size),
        }
    }

    /// Names of the file's cameras, in its order: a list of str. Only glTF files have cameras.
    #[getter]
    fn camera_names<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyString>> {
        // Thousands of cameras may share one long name.
        let mut known = HashMap::new();
        let mut string = |name| known.entry(Arc::as_ptr(name)).or_insert_with(|| PyString::new(py, name)).clone();
        self.cameras.iter().map(|(name, _)| string(name)).collect()
    }

    /// Adds triangles as one object and returns the object's id.
    ///
    /// - ``vertices``: positions relative to ``origin`` (by default world positions), ``(n, 3)``.
    /// - ``faces``: indices of the corners of each triangle, whole numbers, ``(m, 3)``.
    /// - ``name``: name of the object.
    /// - ``material``: id of a material, or one id for each triangle. Default 0, the grey material.
    /// - ``normals``: unit normals for smooth shading, for each vertex ``(n, 3)`` or each corner ``(m, 3, 3)``. A
    ///   triangle with a zero normal is flat.
    /// - ``uv``: texture coordinates, ``(n, 2)`` or ``(m, 3, 2)``. (0, 0) is the lower left corner of a texture, (1, 1)
    ///   the upper right.
    /// - ``colors``: factors of the albedo, ``(n, 3)`` or ``(m, 3, 3)``. Floats are linear RGB, bytes (uint8) are sRGB.
    ///   A fourth channel is ignored.
    /// - ``crease_angle``: in degrees, 0 to 180. Makes normals that are smooth across edges where adjacent triangles
    ///   differ by less than this angle. Not with ``normals``.
    ///
    /// Triangles without area are dropped with a log message; they keep their ids. Raises ``ValueError``, which names
    /// the element, for an array of another shape and for an index or material out of range. Also raises it for a
    /// coordinate larger than 1e8, a value that is not finite, and a negative colour. The scene then stays unchanged.
    #[pyo3(signature = (
        vertices, faces, *, name = "", material = None, normals = None, uv = None, colors = None, crease_angle = None
    ))]
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
        let parts = Parts { name, material, normals, uv, colors, crease_angle };
        let mesh = parts.mesh(vertices, faces)?;
        // Meshes are the first objects.
        let scene = self.changed();
        let others = scene.spheres().len() + scene.ellipsoids().len() + scene.planes().len();
        let object = scene.object_count() - others;
        scene.add_mesh(&mesh).map_err(raised)?;
        Ok(object as u32)
    }

    /// Replaces a mesh by another one, as the same object. The arguments are those of ``add_mesh``.
    ///
    /// A mesh with as many triangles keeps the ids of all primitives, so ``Renderer.flow`` can follow its points.
    /// Raises ``ValueError`` as ``add_mesh`` does, and for an object that is not a mesh. The scene then stays
    /// unchanged.
    #[pyo3(signature = (
        object, vertices, faces, *, name = "", material = None, normals = None, uv = None, colors = None,
        crease_angle = None
    ))]
    #[expect(clippy::too_many_arguments, reason = "Python's keywords")]
    fn set_mesh(
        &mut self,
        object: u32,
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        name: &str,
        material: Option<&Bound<'_, PyAny>>,
        normals: Option<&Bound<'_, PyAny>>,
        uv: Option<&Bound<'_, PyAny>>,
        colors: Option<&Bound<'_, PyAny>>,
        crease_angle: Option<f32>,
    ) -> PyResult<()> {
        let parts = Parts { name, material, normals, uv, colors, crease_angle };
        let mesh = parts.mesh(vertices, faces)?;
        self.changed().set_mesh(object, &mesh).map_err(raised)
    }

    /// Corners of all triangles relative to ``origin``, by primitive id: float32, ``(n, 3, 3)``.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f32>> {
        let corners = self.inner.triangles().iter().map(|triangle| triangle.corners.map(|corner| corner.to_array()));
        let corners: Vec<[[f32; 3]; 3]> = corners.collect();
        let shape = (corners.len(), 3, 3);
        let flat = corners.into_flattened().into_flattened();
        match Array3::from_shape_vec(shape, flat) {
            Ok(array) => array.into_pyarray(py),
            Err(_) => unreachable!("a triangle has nine numbers"),
        }
    }

    /// Adds a sphere as an object. ``center`` is relative to ``origin``; ``radius`` is in world units, above 0. Raises
    /// ``ValueError`` for values that are not finite or too large, a radius that is not above 0, and an unknown
    /// material.
    #[pyo3(signature = (center, radius, material = 0))]
    fn add_sphere(&mut self, center: Point, radius: f32, material: u32) -> PyResult<()> {
        self.changed().add_sphere(Sphere::new(center.0, radius, MaterialId(material))).map_err(raised)
    }

    /// Adds spheres, each as an object. ``centers`` are relative to ``origin``, ``(n, 3)``. ``radii`` are in world
    /// units: one number, or one for each sphere. ``materials`` are ids: one, or one for each sphere; default 0. Raises
    /// ``ValueError`` as ``add_sphere`` does. The scene then stays unchanged.
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
            Err(_) => radii.extract().map_err(|_| refused("radii: they must be one number, or one per sphere"))?,
        };
        let materials = materials.map_or(Ok(vec![0]), |ids| values::indices("materials", ids))?;
        for (what, found) in [("radii", radii.len()), ("materials", materials.len())] {
            if found != centers.len() && !(what == "materials" && found == 1) {
                return Err(refused(format!("{what}: {found} for {} spheres", centers.len())));
            }
        }
        let spheres = centers.iter().zip(&radii).enumerate().map(|(index, (&center, &radius))| {
            Sphere::new(center, radius, MaterialId(materials[if materials.len() == 1 { 0 } else { index }]))
        });
        // Either all spheres are added or none: a trial scene with the same materials checks them first.
        let mut trial = stereotrace::Scene::new();
        for material in &self.inner.materials()[1..] {
            trial.add_material(material.clone());
        }
        spheres.clone().try_for_each(|sphere| trial.add_sphere(sphere)).map_err(raised)?;
        let scene = self.changed();
        spheres.into_iter().try_for_each(|sphere| scene.add_sphere(sphere)).map_err(raised)
    }

    /// Adds an ellipsoid as an object: all points ``center + axes @ v`` for vectors ``v`` of length 1. ``center`` is
    /// relative to ``origin``.
    ///
    /// ``axes`` are three semi-axes along the world's axes, in world units. A matrix ``(3, 3)`` is also accepted: its
    /// columns are the images of the unit sphere's axes. Raises ``ValueError`` for values that are not finite or too
    /// large, and for an unknown material. Also raises it for semi-axes below 1e-15, and if the longest is over 10000
    /// times the shortest.
    #[pyo3(signature = (center, axes, material = 0))]
    fn add_ellipsoid(&mut self, center: Point, axes: &Bound<'_, PyAny>, material: u32) -> PyResult<()> {
        let axes = match axes.extract::<[f32; 3]>() {
            Ok(radii) => Mat3::from_diagonal(Vec3::from_array(radii)),
            // NumPy's matrices are by rows, glam's by columns.
            Err(_) => Mat3::from_cols_array_2d(&matrix::<3>("axes", axes)?).transpose(),
        };
        self.changed().add_ellipsoid(Ellipsoid::new(center.0, axes, MaterialId(material))).map_err(raised)
    }

    /// Adds an infinite plane through a position relative to ``origin``, as an object. A scene may have 8 planes.
    ///
    /// ``normal`` has any length but 0; it points up by default. A texture fills squares with a side of ``tile`` world
    /// units, 1e-6 to 1e8. On a ground its right is the world's +x. On a wall, seen from the normal's side, its top is
    /// up. A glass plane bounds a half-space of glass on the side opposite to its normal. Raises ``ValueError`` for
    /// values out of range, for an unknown material, and for a ninth plane.
    #[pyo3(signature = (point, normal = Point(Vec3::Y), material = 0, *, tile = 1.0))]
    fn add_plane(&mut self, point: Point, normal: Point, material: u32, tile: f32) -> PyResult<()> {
        let plane = Plane::new(point.0, normal.0, MaterialId(material)).tile(tile);
        self.changed().add_plane(plane).map_err(raised)
    }

    /// Adds a material and returns its id. Rendering checks its values.
    fn add_material(&mut self, material: Material) -> u32 {
        self.changed().add_material(material.0).0
    }

    /// Replaces the material ``id``. Raises ``ValueError`` for an unknown id.
    fn set_material(&mut self, id: u32, material: Material) -> PyResult<()> {
        self.check_material(id)?;
        self.changed().set_material(MaterialId(id), material.0).map_err(raised)
    }

    /// Materials: a list of ``Material``, indexed by id. The list is a copy; ``set_material`` changes a material.
    #[getter]
    fn materials(&self) -> Vec<Material> {
        self.inner.materials().iter().cloned().map(Material).collect()
    }

    /// Adds a texture and returns its id, for ``texture`` and ``cutout`` of materials.
    ///
    /// ``picture`` is an array, or the path of a PNG, JPEG, BMP, GIF, TGA, TIFF or WebP file. An array is uint8, top
    /// row first, ``(height, width, 3)``, or with alpha ``(height, width, 4)``. Colours are sRGB. Sides are 1 to 8192
    /// pixels. ``wrap`` is for texture coordinates outside 0 to 1: ``"repeat"`` repeats the texture, ``"mirror"``
    /// mirrors every second repetition, and ``"clamp"`` extends its edge. On spheres and ellipsoids the texture's
    /// middle is at +z, its right half at +x, its top at +y. ``data`` says that the picture holds linear numbers, such
    /// as roughness or normals, and not sRGB colours. Raises ``OSError`` if the file can't be read, and ``ValueError``
    /// for an invalid picture or sides out of range.
    #[pyo3(signature = (picture, wrap = "repeat", *, data = false))]
    fn add_texture(&mut self, picture: &Bound<'_, PyAny>, wrap: &str, data: bool) -> PyResult<u32> {
        let wrap = match wrap {
            "repeat" => Wrap::Repeat,
            "mirror" => Wrap::Mirror,
            "clamp" => Wrap::Clamp,
            other => return Err(refused(format!("wrap: unknown '{other}'; use repeat, mirror or clamp"))),
        };
        let texture = match picture.extract::<PathBuf>() {
            Ok(path) => Texture::open(path),
            Err(_) => {
                let (width, height, pixels) = values::pixels("texture", picture)?;
                Texture::image(width, height, pixels)
            }
        };
        let TextureId(id) = self.changed().add_texture(texture.map_err(raised)?.wrap(wrap).data(data));
        Ok(id)
    }

    /// Adds a checkerboard texture of ``squares`` by ``squares``, 1 to 8192, over texture coordinates 0 to 1. Returns
    /// its id. ``first`` is the colour of the square at (0, 0); both colours are linear RGB. Raises ``ValueError`` for
    /// a colour that is negative or not finite, and for a number out of range.
    fn add_checkerboard(&mut self, first: Color, second: Color, squares: u32) -> PyResult<u32> {
        let texture = Texture::checkerboard(first.0, second.0, squares).map_err(raised)?;
        Ok(self.changed().add_texture(texture).0)
    }

    /// Adds a texture of ``count`` white dots at random places on black, for ``Light.with_projector``. Returns its id.
    /// Sides are in pixels, 5 to 8192. Dots are 3 pixels wide, and their centres at least half the root of ``width *
    /// height / count`` apart. Equal numbers give equal dots. Raises ``ValueError`` for sides out of range, and for
    /// less than 64 pixels per dot.
    #[pyo3(signature = (width, height, count, seed = 0))]
    fn add_dots(&mut self, width: u32, height: u32, count: u32, seed: u32) -> PyResult<u32> {
        let texture = Texture::dots(width, height, count, seed).map_err(raised)?;
        Ok(self.changed().add_texture(texture).0)
    }

    /// Lights: a list of ``Light``. The list is a copy: assign a list to change the lights, or call ``add_light``. A
    /// scene may have 2**20 lights, at most 16 of which are not points. Rendering checks that.
    #[getter]
    fn lights(&self) -> Vec<Light> {
        self.inner.lights.iter().copied().map(Light).collect()
    }

    #[setter]
    fn set_lights(&mut self, lights: Vec<Light>) {
        self.changed().lights = lights.into_iter().map(|light| light.0).collect();
    }

    /// Appends a light. Rendering checks its values.
    fn add_light(&mut self, light: Light) {
        self.changed().lights.push(light.0);
    }

    /// Replaces the lights by ``count`` point lights beside and above the camera's eyes. If the eyes are within the
    /// scene's bounds, the lights are too.
    ///
    /// Intensities add up to 0.85. ``ambient`` becomes 0.15 unless it was assigned. Raises ``ValueError`` for more than
    /// 2**20 lights.
    fn place_lights(&mut self, count: usize, camera: Camera) -> PyResult<()> {
        self.changed().place_lights(count, &camera.0).map_err(raised)
    }

    /// Returns the lights that ``place_lights`` would place, as a list. The scene stays unchanged. Raises
    /// ``ValueError`` as ``place_lights`` does.
    fn lights_around(&self, count: usize, camera: Camera) -> PyResult<Vec<Light>> {
        let lights = self.inner.lights_around(count, &camera.0).map_err(raised)?;
        Ok(lights.into_iter().map(Light).collect())
    }

    /// Whether lights cast shadows. Assignable; ``True`` in a new scene.
    #[getter]
    fn shadows(&self) -> bool {
        self.inner.shadows
    }

    #[setter]
    fn set_shadows(&mut self, shadows: bool) {
        self.changed().shadows = shadows;
    }

    /// Ambient light, linear RGB: a tuple of three.
    ///
    /// It is assignable. ``None`` restores the default: 1 without lights, 0.15 with lights. Frames lit by the sky (the
    /// option ``sky_rays``) have no ambient light.
    #[getter]
    fn ambient(&self) -> (f32, f32, f32) {
        tuple(self.inner.rendered_ambient())
    }

    #[setter]
    fn set_ambient(&mut self, ambient: Option<Color>) {
        self.changed().ambient = ambient.map(|color| color.0);
    }

    /// Sets the sky: one colour, or with ``zenith`` a blend along the world's y axis, from ``color`` straight down to
    /// ``zenith`` straight up. Colours are linear RGB, 0 or more. The sky lights surfaces only with the option
    /// ``sky_rays``.
    #[pyo3(signature = (color, zenith = None))]
    fn set_sky(&mut self, color: Color, zenith: Option<Color>) {
        self.changed().sky = match zenith {
            None => Sky::Constant(color.0),
            Some(zenith) => Sky::Gradient { nadir: color.0, zenith: zenith.0 },
        };
    }

    /// Sets the sky to an equirectangular picture (HDRI, environment map). The top row is straight up, the middle
    /// column towards -z, and columns go round to the right.
    ///
    /// ``picture`` is one of these:
    ///
    /// - a file's path: PNG and JPEG are sRGB, Radiance HDR and ``OpenEXR`` are linear;
    /// - an array of floats, ``(height, width, 3)``, linear RGB;
    /// - ``"procedural"``: a sun and clouds over a plain, 1024 x 512 pixels.
    ///
    /// ``turn`` turns the sky to the right, in degrees about the world's y axis, by whole columns. ``gain`` multiplies
    /// its light.
    ///
    /// The width must be even. Raises ``OSError`` if the file can't be read. Raises ``ValueError`` for an invalid or
    /// too large picture, and for colours that are negative or not finite.
    #[pyo3(signature = (picture, *, turn = 0.0, gain = 1.0))]
    fn set_sky_map(&mut self, picture: &Bound<'_, PyAny>, turn: f64, gain: f32) -> PyResult<()> {
        let map = match picture.extract::<PathBuf>() {
            // The string is the procedural sky. A file of that name is Path("procedural").
            Ok(_) if picture.eq("procedural")? => SkyMap::procedural(1024),
            Ok(path) => SkyMap::open(path),
            Err(_) => {
                let (width, height, pixels) = values::linear_pixels("sky", picture)?;
                SkyMap::new(width, height, pixels)
            }
        };
        let map = map.and_then(|map| map.turned(turn)?.scaled(gain)).map_err(raised)?;
        self.changed().sky = Sky::Map(map);
        Ok(())
    }

    /// Transforms an object from its current place: moves, rotates, scales or shears it.
    ///
    /// ``transform`` is a matrix ``(4, 4)`` for column vectors ``(x, y, z, 1)``, with the last row 0, 0, 0, 1. Spheres
    /// can be scaled uniformly only. Rounding errors of repeated transforms add up. Raises ``ValueError`` for an
    /// unknown object, and for a coordinate that becomes infinite or larger than 1e8. Also raises it if the result is
    /// no sphere, ellipsoid or plane. The scene then stays unchanged.
    fn transform_object(&mut self, object: u32, transform: &Bound<'_, PyAny>) -> PyResult<()> {
        let rows = matrix::<4>("transform", transform)?;
        if rows[3] != [0.0, 0.0, 0.0, 1.0] {
            return Err(refused(format!("transform: its last row must be 0, 0, 0, 1, not {:?}", rows[3])));
        }
        let transform = Affine3A::from_mat4(Mat4::from_cols_array_2d(&rows).transpose());
        self.changed().transform_object(object, &transform).map_err(raised)
    }

    /// Axis-aligned bounding box of all primitives but planes, in world coordinates: a list of the low and the high
    /// corner, tuples of three. ``None`` for an empty scene.
    #[getter]
    fn bounds(&self) -> Option<[(f64, f64, f64); 2]> {
        self.inner.bounds().map(|(low, high)| [low.into(), high.into()])
    }

    /// World position that positions of meshes, spheres, ellipsoids and planes are relative to: a tuple of three.
    /// Assignable: primitives then move with the origin, and lights keep their world positions.
    #[getter]
    fn origin(&self) -> (f64, f64, f64) {
        self.inner.origin().into()
    }

    /// Sets the origin. Primitives move with it, and lights keep their world positions.
    #[setter]
    fn set_origin(&mut self, origin: Position) -> PyResult<()> {
        self.changed().set_origin(origin.0).map_err(raised)
    }

    /// Number of triangles, including those without area.
    #[getter]
    fn triangle_count(&self) -> usize {
        self.inner.triangles().len()
    }

    /// Number of primitives: triangles, spheres, ellipsoids and planes.
    #[getter]
    fn primitive_count(&self) -> usize {
        self.inner.primitive_count()
    }

    /// Number of objects: meshes, spheres, ellipsoids and planes.
    #[getter]
    fn object_count(&self) -> usize {
        self.inner.object_count()
    }

    /// Approximate memory of the scene in bytes: primitives, and pixels of textures and sky. On a device it takes about
    /// the same again.
    #[getter]
    fn memory(&self) -> usize {
        self.inner.memory()
    }

    /// Returns the id of the object that a primitive belongs to, or ``MISS`` for an id out of range.
    fn object_of(&self, primitive: u32) -> u32 {
        self.inner.object_of(primitive)
    }

    /// Returns the name of a mesh by its object id. It is empty for spheres, ellipsoids, planes and ids out of range.
    fn object_name(&self, object: u32) -> &str {
        self.inner.object_name(object)
    }

    /// Returns a SHA-256, as 64 hexadecimal digits, of everything that pictures of the scene depend on. Equal scenes
    /// from different files have equal hashes. Versions of the library may differ.
    fn sha256(&self, py: Python<'_>) -> String {
        py.detach(|| self.inner.sha256())
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

/// ``"auto"``, ``"none"`` or a position.
struct OriginArgument(Origin);

impl<'a, 'py> FromPyObject<'a, 'py> for OriginArgument {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match (value.extract::<&str>(), value.extract::<Position>()) {
            (Ok("auto"), _) => Ok(Self(Origin::Auto)),
            (Ok("none"), _) => Ok(Self(Origin::World)),
            (_, Ok(Position(origin))) => Ok(Self(Origin::At(origin))),
            _ => Err(refused(format!("origin: {} is not 'auto', 'none' or three numbers", shown(&value)))),
        }
    }
}

/// Reads a square matrix, by rows.
fn matrix<const N: usize>(what: &str, value: &Bound<'_, PyAny>) -> PyResult<[[f32; N]; N]> {
    let rows = values::rows::<N>(what, value)?;
    rows.try_into().map_err(|rows: Vec<_>| refused(format!("{what}: {} rows of {N}; there must be {N}", rows.len())))
}
