//! Scenes.

use std::{
    collections::HashMap,
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use pyo3::{prelude::*, types::PyString};
use sha2::{Digest, Sha256};
use stereotrace::{
    Builtin, Ellipsoid, MaterialId, Mesh, MissingTextures, Origin, OutsideFiles, Plane, SceneFile, SceneOptions, Sky,
    SkyMap, Sphere, StereoCamera, Texture, TextureId, Wrap,
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

/// A scene to render: meshes, spheres, ellipsoids and planes, their materials, lights and a sky.
///
/// ``Scene()`` is empty: the sky is black, ambient light is by rule (see ``ambient``), and there is one grey material,
/// id 0. ``Scene.open`` reads a file, and ``Scene.builtin`` makes a scene that comes with the library.
///
/// World space is right-handed with y up. Coordinates are in world units, within 1e8. Colours are linear RGB, 0 to 1,
/// of lights and skies 0 or more; one number stands for three equal ones. Arrays are all that ``numpy.asarray`` takes.
///
/// Ids count from 0. Primitives are the triangles in the order in which they were added, those without area too, then
/// spheres, ellipsoids and planes. Objects are the meshes in the order in which they were added, then spheres,
/// ellipsoids and planes, one each. So a mesh that is added moves the ids of spheres, ellipsoids and planes.
///
/// A renderer brings changes to its device when the scene is rendered next. Then the values of materials, lights and
/// sky are checked too: what is out of range is a ``ValueError``. A scene can't be changed while it is rendered: that
/// is a ``RuntimeError``.
///
/// Scenes can be pickled, with all that they show and their cameras; renderers can't.
#[pyclass(module = "stereotrace")]
pub(crate) struct Scene {
    pub(crate) inner: stereotrace::Scene,
    pub(crate) state: State,
    /// A file's own cameras.
    cameras: Vec<(Arc<str>, StereoCamera)>,
    builtin: Option<Builtin>,
}

impl Scene {
    fn of(inner: stereotrace::Scene, cameras: Vec<(Arc<str>, StereoCamera)>, builtin: Option<Builtin>) -> Self {
        Self { inner, state: State::new(), cameras, builtin }
    }

    /// The scene, which changes now.
    fn changed(&mut self) -> &mut stereotrace::Scene {
        self.state.change += 1;
        &mut self.inner
    }

    /// The scene that was pickled.
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

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Self::of(stereotrace::Scene::new(), Vec::new(), None)
    }

    /// Reads a scene from a file: OBJ with its MTL files, glTF 2.0 (.gltf and .glb) or PLY. The content tells the
    /// format, and where it does not the name's ending.
    ///
    /// A glTF file brings its lights and cameras (``camera_names``); scenes of other files have no lights yet: see
    /// ``place_lights``. ``crease_angle`` in degrees, 0 to 180, gives smooth normals to objects without any: edges
    /// across which the normals of triangles are less than so many degrees apart are smooth. Without it such
    /// objects are flat. ``missing_textures`` says what becomes of a texture that can't be read: ``"error"`` is an
    /// error, with ``"warn"`` the material is without it and a warning is logged. Files outside the scene file's
    /// folder that it names, as textures in ``../textures``, are refused unless ``outside_files`` is ``"allow"``.
    ///
    /// Raises ``OSError`` if the file can't be read, and ``ValueError`` for a file of another format, for content that
    /// is wrong (the message names line or item), and for files over 1 GiB.
    ///
    /// ``origin`` is the world position that the file's coordinates are stored relative to: three numbers, ``"none"``
    /// for 0, or ``"auto"``: the middle of a file that lies farther away than 8 times its size. Cameras, lights,
    /// bounds and ground truth stay in world coordinates, in double precision.
    #[staticmethod]
    #[pyo3(signature = (path, *, crease_angle = None, missing_textures = "error", outside_files = "refuse", origin = None))]
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
        let SceneFile { scene, cameras, .. } = py.detach(|| SceneFile::open(path, &options)).map_err(raised)?;
        Ok(Self::of(scene, cameras, None))
    }

    /// A scene that comes with the library, with lights and a sky: one of ``BUILTINS``. ``camera`` gives the camera
    /// that goes with it. Raises ``ValueError`` for another name.
    #[staticmethod]
    fn builtin(py: Python<'_>, name: &str) -> PyResult<Self> {
        let builtin: Builtin = named(name)?;
        Ok(Self::of(py.detach(|| builtin.scene()), Vec::new(), Some(builtin)))
    }

    /// A copy, which changes on its own. It has the same cameras. ``copy.copy`` and ``copy.deepcopy`` make the same.
    fn copy(&self) -> Self {
        Self::of(self.inner.clone(), self.cameras.clone(), self.builtin)
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

    /// The camera that goes with the scene: that of a built-in scene, the camera of its file by its ``name`` or else
    /// the first one, or where there is none a camera that holds all of the scene, as ``Camera.fitting`` has it.
    ///
    /// ``size`` is a tuple of width and height in pixels. The eyes of a built-in scene's camera are 15 pixels apart in
    /// a picture 600 pixels wide, and so in proportion. Raises ``ValueError`` for a name that is not there, for a
    /// size that no camera can have, and where the scene has no camera and is empty or has only infinite planes.
    #[pyo3(signature = (name = None, size = Size(640, 480)))]
    fn camera(&self, name: Option<&str>, size: Size) -> PyResult<Camera> {
        let own = match name {
            None => self.cameras.first(),
            Some(name) => match self.cameras.iter().find(|(own, _)| **own == *name) {
                None => {
                    // A message has no place for more.
                    let own: Vec<&str> = self.cameras.iter().take(20).map(|(name, _)| &**name).collect();
                    let own = own.join(", ");
                    let there_are = if own.is_empty() { "none".into() } else { own };
                    return Err(refused(format!("no camera '{name}' in this scene; there are: {there_are}")));
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

    /// The names of the cameras that the scene's file has, in its order: a list of str. Only glTF files have some.
    #[getter]
    fn camera_names<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyString>> {
        // Thousands of cameras may share one long name.
        let mut known = HashMap::new();
        let mut string = |name| known.entry(Arc::as_ptr(name)).or_insert_with(|| PyString::new(py, name)).clone();
        self.cameras.iter().map(|(name, _)| string(name)).collect()
    }

    /// Adds triangles as one object and returns the object's id.
    ///
    /// - ``vertices``: positions relative to ``origin``, which is 0 unless it was set, ``(n, 3)``.
    /// - ``faces``: the corners of each triangle as indices into them, whole numbers, ``(m, 3)``.
    /// - ``name``: the object's name.
    /// - ``material``: the id of a material, or one for each triangle; the grey one, 0, where nothing is said.
    /// - ``normals``: unit normals for smooth shading, one a vertex, ``(n, 3)``, or one a corner, ``(m, 3, 3)``. A
    ///   triangle with a zero among them is flat.
    /// - ``uv``: texture coordinates, ``(n, 2)`` or ``(m, 3, 2)``; (0, 0) is the lower left corner of a texture, (1, 1)
    ///   the upper right.
    /// - ``colors``: what the albedo is multiplied by, ``(n, 3)`` or ``(m, 3, 3)``: floats are linear RGB, bytes
    ///   (uint8) sRGB. A fourth channel says nothing.
    /// - ``crease_angle``: in degrees, 0 to 180; makes normals, smooth across edges where those of the triangles are
    ///   less than so far apart. Not with ``normals``.
    ///
    /// Triangles without area are dropped, which is logged; they keep their ids. Raises ``ValueError``, naming the
    /// element, for an array of another shape, an index out of range, a coordinate that is not finite or is larger
    /// than 1e8, a normal, texture coordinate or colour that is not finite, a negative colour, and a material that
    /// is not there. The scene then stays as it was.
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
        // Meshes count first among objects.
        let scene = self.changed();
        let others = scene.spheres().len() + scene.ellipsoids().len() + scene.planes().len();
        let object = scene.object_count() - others;
        scene.add_mesh(&mesh).map_err(raised)?;
        Ok(object as u32)
    }

    /// Adds a sphere about a position relative to ``origin`` as an object of its own; the radius is in world units,
    /// above 0. Raises ``ValueError`` for a centre or radius that is not finite or too large, a radius that is not
    /// above 0, and a material that is not there.
    #[pyo3(signature = (center, radius, material = 0))]
    fn add_sphere(&mut self, center: Point, radius: f32, material: u32) -> PyResult<()> {
        self.changed().add_sphere(Sphere::new(center.0, radius, MaterialId(material))).map_err(raised)
    }

    /// Adds many spheres, each as an object of its own: ``centers`` are relative to ``origin``, ``(n, 3)``; ``radii``
    /// are in world units, one number or one each; ``materials`` are ids, one or one each, 0 where nothing is said.
    /// Raises ``ValueError`` as ``add_sphere`` does; then none is added.
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
        let spheres = centers.iter().zip(&radii).enumerate().map(|(index, (&center, &radius))| {
            Sphere::new(center, radius, MaterialId(materials[if materials.len() == 1 { 0 } else { index }]))
        });
        // All of them or none: a scene of the same materials says whether they can be added.
        let mut trial = stereotrace::Scene::new();
        for material in &self.inner.materials()[1..] {
            trial.add_material(material.clone());
        }
        spheres.clone().try_for_each(|sphere| trial.add_sphere(sphere)).map_err(raised)?;
        let scene = self.changed();
        spheres.into_iter().try_for_each(|sphere| scene.add_sphere(sphere)).map_err(raised)
    }

    /// Adds an ellipsoid as an object of its own: all points ``center + axes @ v`` of vectors ``v`` of length 1.
    ///
    /// ``axes`` are three semi-axes along the axes of the world, in world units, or a matrix, ``(3, 3)``, whose columns
    /// say where the axes of the unit sphere come to lie. Raises ``ValueError`` for values that are not finite or
    /// too large, for semi-axes below 1e-15 or of which the longest is over 10000 times the shortest, and for a
    /// material that is not there.
    #[pyo3(signature = (center, axes, material = 0))]
    fn add_ellipsoid(&mut self, center: Point, axes: &Bound<'_, PyAny>, material: u32) -> PyResult<()> {
        let axes = match axes.extract::<[f32; 3]>() {
            Ok(radii) => Mat3::from_diagonal(Vec3::from_array(radii)),
            // Rows as NumPy has them; glam's columns.
            Err(_) => Mat3::from_cols_array_2d(&matrix::<3>("axes", axes)?).transpose(),
        };
        self.changed().add_ellipsoid(Ellipsoid::new(center.0, axes, MaterialId(material))).map_err(raised)
    }

    /// Adds an infinite plane through a position relative to ``origin`` as an object of its own; at most 8 can be in a
    /// scene.
    ///
    /// ``normal`` is of any length but 0; it points up where nothing is said. A texture fills squares whose side is
    /// ``tile`` world units, 1e-6 to 1e8: on grounds its right is the world's +x, on walls, seen from where the
    /// normal points, its top is up. A plane of glass is the face of a half-space of glass, on the side that its
    /// normal points away from. Raises ``ValueError`` for values out of these ranges, for a material that is not
    /// there, and for a ninth plane.
    #[pyo3(signature = (point, normal = Point(Vec3::Y), material = 0, *, tile = 1.0))]
    fn add_plane(&mut self, point: Point, normal: Point, material: u32, tile: f32) -> PyResult<()> {
        let plane = Plane::new(point.0, normal.0, MaterialId(material)).tile(tile);
        self.changed().add_plane(plane).map_err(raised)
    }

    /// Adds a material and returns its id. Its values are checked when the scene is rendered.
    fn add_material(&mut self, material: Material) -> u32 {
        self.changed().add_material(material.0).0
    }

    /// Puts another material in the place of one. Raises ``ValueError`` for an id that is not there.
    fn set_material(&mut self, id: u32, material: Material) -> PyResult<()> {
        self.check_material(id)?;
        self.changed().set_material(MaterialId(id), material.0).map_err(raised)
    }

    /// The materials: a list of ``Material``, whose indices are their ids. The list is a copy: ``set_material`` changes
    /// one.
    #[getter]
    fn materials(&self) -> Vec<Material> {
        self.inner.materials().iter().cloned().map(Material).collect()
    }

    /// Adds a texture and returns its id, for ``texture`` and ``cutout`` of materials.
    ///
    /// ``picture`` is a PNG or JPEG file's path, or an array of uint8, ``(height, width, 3)`` or with alpha ``(height,
    /// width, 4)``, top row first; colours are sRGB. Sides are 1 to 8192 pixels. ``wrap`` says what lies beyond
    /// texture coordinates of 0 to 1: ``"repeat"`` the texture again, ``"mirror"`` the same mirrored every other
    /// time, ``"clamp"`` its edge. Spheres and ellipsoids have the texture around them: its middle at +z, its right
    /// half at +x, its top at +y. Raises ``OSError`` if the file can't be read, and ``ValueError`` for a
    /// picture that is none, has sides out of range or is too large.
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

    /// Adds a checkerboard of ``squares`` by ``squares``, 1 to 8192, over texture coordinates of 0 to 1 and returns its
    /// id as a texture. ``first`` is the colour of the square at (0, 0); both are linear RGB. Raises ``ValueError``
    /// for a colour that is negative or not finite, and for another number.
    fn add_checkerboard(&mut self, first: Color, second: Color, squares: u32) -> PyResult<u32> {
        let texture = Texture::checkerboard(first.0, second.0, squares).map_err(raised)?;
        Ok(self.changed().add_texture(texture).0)
    }

    /// The lights: a list of ``Light``. It is a copy: assign a list to change the lights, or call ``add_light``. A
    /// scene may have 2**20 lights, of which at most 16 are not points; that is checked when it is rendered.
    #[getter]
    fn lights(&self) -> Vec<Light> {
        self.inner.lights.iter().copied().map(Light).collect()
    }

    #[setter]
    fn set_lights(&mut self, lights: Vec<Light>) {
        self.changed().lights = lights.into_iter().map(|light| light.0).collect();
    }

    /// Adds a light behind those that are there. Its values are checked when the scene is rendered.
    fn add_light(&mut self, light: Light) {
        self.changed().lights.push(light.0);
    }

    /// Replaces the lights by ``count`` points of light, by one rule for every scene: beside and above the camera's
    /// eyes, within the scene's bounds where the eyes are in them.
    ///
    /// The lights add up to 0.85. ``ambient`` becomes 0.15 where it is by rule, and stays what it is where it was
    /// given. Raises ``ValueError`` for more than 2**20 lights.
    fn place_lights(&mut self, count: usize, camera: Camera) -> PyResult<()> {
        self.changed().place_lights(count, &camera.0).map_err(raised)
    }

    /// The lights that ``place_lights`` would place, as a list; the scene stays as it is. Raises ``ValueError`` as that
    /// does.
    fn lights_around(&mut self, count: usize, camera: Camera) -> PyResult<Vec<Light>> {
        let before = (std::mem::take(&mut self.inner.lights), self.inner.ambient);
        let placed = self.inner.place_lights(count, &camera.0);
        let lights = std::mem::replace(&mut self.inner.lights, before.0);
        self.inner.ambient = before.1;
        placed.map_err(raised)?;
        Ok(lights.into_iter().map(Light).collect())
    }

    /// Whether lights cast shadows. It can be assigned; ``True`` in a new scene.
    #[getter]
    fn shadows(&self) -> bool {
        self.inner.shadows
    }

    #[setter]
    fn set_shadows(&mut self, shadows: bool) {
        self.changed().shadows = shadows;
    }

    /// The light that reaches every surface from everywhere, linear RGB: a tuple of three.
    ///
    /// It can be assigned; ``None`` makes it go by rule, as in a new scene: 1 without lights, and 0.15 with them.
    /// Frames that are lit by the sky (the option ``sky_rays``) have none.
    #[getter]
    fn ambient(&self) -> (f32, f32, f32) {
        tuple(self.inner.rendered_ambient())
    }

    /// The ambient light that was assigned or that ``place_lights`` left, linear RGB: a tuple of three; ``None`` where
    /// it is by rule.
    #[getter]
    fn given_ambient(&self) -> Option<(f32, f32, f32)> {
        self.inner.ambient.map(tuple)
    }

    #[setter]
    fn set_ambient(&mut self, ambient: Option<Color>) {
        self.changed().ambient = ambient.map(|color| color.0);
    }

    /// What a ray sees that hits nothing: one colour, or with ``zenith`` a blend along the world's y axis, from
    /// ``color`` straight down to ``zenith`` straight up. Linear RGB, 0 or more. It lights surfaces where the
    /// option ``sky_rays`` asks it to.
    #[pyo3(signature = (color, zenith = None))]
    fn set_sky(&mut self, color: Color, zenith: Option<Color>) {
        self.changed().sky = match zenith {
            None => Sky::Constant(color.0),
            Some(zenith) => Sky::Gradient { nadir: color.0, zenith: zenith.0 },
        };
    }

    /// Makes a picture of everything around the sky: equirectangular, the top row straight up, the middle column
    /// towards -z, and columns go round to the right.
    ///
    /// ``picture`` is a file's path (PNG and JPEG are taken as sRGB, Radiance HDR as linear), an array of floats,
    /// ``(height, width, 3)``, linear RGB, or ``"procedural"``: a sun and streaks of cloud over a plain, 1024 x 512
    /// pixels. The width must be even. Raises ``OSError`` if the file can't be read, and ``ValueError`` for a
    /// picture that is none or too large, and for colours that are negative or not finite.
    fn set_sky_map(&mut self, picture: &Bound<'_, PyAny>) -> PyResult<()> {
        let map = match picture.extract::<PathBuf>() {
            // A text, not a path: a file of that name is Path("procedural").
            Ok(_) if picture.eq("procedural")? => SkyMap::procedural(1024),
            Ok(path) => SkyMap::open(path),
            Err(_) => {
                let (width, height, pixels) = values::linear_pixels("sky", picture)?;
                SkyMap::new(width, height, pixels)
            }
        };
        self.changed().sky = Sky::Map(map.map_err(raised)?);
        Ok(())
    }

    /// Moves, turns, scales or shears an object from where it is now.
    ///
    /// ``transform`` is a matrix, ``(4, 4)``, that takes a point as a column ``(x, y, z, 1)``; its last row is 0, 0, 0,
    /// 1. Spheres stay spheres: they can be moved, turned and scaled alike in all directions. Many transforms of
    /// one object add up their rounding. Raises ``ValueError`` for an object that is not there, a coordinate that
    /// becomes infinite or larger than 1e8, and for what would be no sphere, ellipsoid or plane. The scene then
    /// stays as it was.
    fn transform_object(&mut self, object: u32, transform: &Bound<'_, PyAny>) -> PyResult<()> {
        let rows = matrix::<4>("transform", transform)?;
        if rows[3] != [0.0, 0.0, 0.0, 1.0] {
            return Err(refused(format!("transform: its last row must be 0, 0, 0, 1, not {:?}", rows[3])));
        }
        let transform = Affine3A::from_mat4(Mat4::from_cols_array_2d(&rows).transpose());
        self.changed().transform_object(object, &transform).map_err(raised)
    }

    /// The axis-aligned box around all that can be hit but planes, in world coordinates: a list of its low and its high
    /// corner, tuples of three. ``None`` where there is nothing.
    #[getter]
    fn bounds(&self) -> Option<[(f64, f64, f64); 2]> {
        self.inner.bounds().map(|(low, high)| [low.into(), high.into()])
    }

    /// The world position that the positions of meshes, spheres, ellipsoids and planes are relative to: a tuple of
    /// three.
    #[getter]
    fn origin(&self) -> (f64, f64, f64) {
        self.inner.origin().into()
    }

    /// Sets the origin: what was added moves along, and lights stay where they are in the world.
    #[setter]
    fn set_origin(&mut self, origin: Position) -> PyResult<()> {
        self.changed().set_origin(origin.0).map_err(raised)
    }

    /// The number of triangles, those without area too.
    #[getter]
    fn triangle_count(&self) -> usize {
        self.inner.triangles().len()
    }

    /// The number of primitives: triangles, spheres, ellipsoids and planes.
    #[getter]
    fn primitive_count(&self) -> usize {
        self.inner.primitive_count()
    }

    /// The number of objects: meshes, spheres, ellipsoids and planes.
    #[getter]
    fn object_count(&self) -> usize {
        self.inner.object_count()
    }

    /// The memory that the scene takes, in bytes, about: its primitives, and the pixels of its textures and sky. On a
    /// device it takes about as much again.
    #[getter]
    fn memory(&self) -> usize {
        self.inner.memory()
    }

    /// The id of the object that a primitive belongs to; ``MISS`` for a number out of range.
    fn object_of(&self, primitive: u32) -> u32 {
        self.inner.object_of(primitive)
    }

    /// The name of an object: its mesh's. Empty for spheres, ellipsoids, planes and for numbers out of range.
    fn object_name(&self, object: u32) -> &str {
        self.inner.object_name(object)
    }

    /// A SHA-256, as 64 hexadecimal digits, of all that pictures of the scene depend on. Equal scenes have equal ones,
    /// whatever files they came from. Another version of the library may make others.
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

/// A square matrix, row by row.
fn matrix<const N: usize>(what: &str, value: &Bound<'_, PyAny>) -> PyResult<[[f32; N]; N]> {
    let rows = values::rows::<N>(what, value)?;
    rows.try_into().map_err(|rows: Vec<_>| refused(format!("{what}: {} rows of {N}; there must be {N}", rows.len())))
}
