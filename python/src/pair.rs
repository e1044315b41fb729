//! Results of rendering: pairs and views. An array is copied when it is first accessed, and then kept.

use std::{
    collections::HashMap,
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

use numpy::{Element, IntoPyArray, ndarray::Array2};
use pyo3::{
    exceptions::PyAttributeError,
    prelude::*,
    types::{PyBytes, PyDict},
};
use stereotrace::{
    Channel, Channels, Error, GroundTruth, Values,
    dataset::{Layout, LayoutMotion},
    output::{Anaglyph, Batch, ExrColor, Packing, Picture, quilt},
};

use crate::{
    camera::Camera,
    correspondence::Correspondence,
    errors::{raised, refused},
    flow::{Motion, MotionTuple},
    layers::Layers,
    options::Request,
    picture::{array, encoded, rgb, shaped},
    statistics,
    values::named,
};

/// A rendered pair and its request.
pub(crate) struct Frame {
    pub(crate) pair: stereotrace::StereoPair,
    pub(crate) truth: Option<GroundTruth>,
    pub(crate) camera: Camera,
    pub(crate) request: Request,
}

/// Rendered views of a rig and their request.
pub(crate) struct RigFrame {
    pub(crate) views: stereotrace::Views,
    pub(crate) camera: Camera,
    pub(crate) request: Request,
}

/// Frame and eye of a view.
#[derive(Clone)]
enum Source {
    Left(Arc<Frame>),
    Right(Arc<Frame>),
    Rig(Arc<RigFrame>, usize),
}

impl Source {
    fn view(&self) -> &stereotrace::View {
        match self {
            Self::Left(frame) => &frame.pair.left,
            Self::Right(frame) => &frame.pair.right,
            Self::Rig(frame, index) => &frame.views.views[*index].view,
        }
    }

    fn request(&self) -> &Request {
        match self {
            Self::Left(frame) | Self::Right(frame) => &frame.request,
            Self::Rig(frame, _) => &frame.request,
        }
    }

    fn channels(&self) -> Channels<'_> {
        match self {
            Self::Left(frame) => frame.pair.left_channels(frame.truth.as_ref()),
            Self::Right(frame) => frame.pair.right_channels(frame.truth.as_ref()),
            Self::Rig(frame, index) => frame.views.views[*index].channels(),
        }
    }
}

/// The view of one eye. Arrays are attributes; a view has those that ``outputs`` named.
///
/// Arrays are row-major, top row first. Each is made on first access and kept. Depths, ids and ground truth belong to
/// the first surface that the ray through the pixel's centre hits. That surface may be a mirror or glass. The world is
/// right-handed with y up. Sky means that the ray hits nothing.
///
/// - ``color``: uint8, ``(height, width, 3)``. The picture in sRGB.
/// - ``linear``: float32, ``(height, width, 3)``. Linear RGB before the options ``exposure`` and ``tone``; may exceed
///   1.
/// - ``albedo``: float32, ``(height, width, 3)``. Share of light that surfaces reflect, linear RGB, averaged over the
///   pixel's samples: diffuse reflection and highlights; 1 for glass, 0 for sky. Only with light by paths.
/// - ``depth``: float32, ``(height, width)``. Depth along the view direction in world units; infinite for sky.
/// - ``distance``: float32, ``(height, width)``. Distance from the eye along the pixel's ray in world units; infinite
///   for sky. Pairs only.
/// - ``disparity``: float32, ``(height, width)``. ``x_left - x_right`` in pixels: positive before the screen, 0 on it,
///   negative behind it. For parallel cameras it is 0 at infinity and positive before it. Sky has the disparity of
///   infinite depth. A point in column i of the left view is at ``i + 0.5 - disparity`` in the right view. A point in
///   column i of the right view is at ``i + 0.5 + disparity`` in the left view. Pairs only, without
///   toe-in and lenses.
/// - ``occlusion``: uint8, ``(height, width)``. Visibility from the other eye: 0 visible, 1 hidden by an occluder, 2
///   outside the other picture. Pairs only.
/// - ``normal``: float32, ``(height, width, 3)``. Shading normal, interpolated if a mesh has normals: unit length,
///   world frame, on the side of the geometric normal; zero for sky. Pairs only.
/// - ``geometric_normal``: float32, ``(height, width, 3)``. Normal of the surface itself, towards the eye: unit length,
///   world frame; zero for sky. Pairs only.
/// - ``primitive``: uint32, ``(height, width)``. Id of the primitive; ``MISS``, which is 2**32 - 1, for sky.
/// - ``object``: uint32, ``(height, width)``. Id of the object; ``MISS`` for sky.
/// - ``material``: uint32, ``(height, width)``. Id of the material; ``MISS`` for sky. Pairs only.
/// - ``source``: uint8, ``(height, width)``. Source of a pixel, in a pair's right view or in a rig's view. 0: reused
///   from another view. 1, bad: traced, since the sample that landed there was rejected. 2, missed: traced, since no
///   sample landed there. 3: traced without reuse.
/// - ``shadow_source``: uint8, ``(height, width)``. Source of the visibility of lights in the same views. 0: without
///   shadow rays, by reuse or since no light had to be queried. 1: by at least one shadow ray. Bracket methods only.
/// - ``cost``: uint32, ``(height, width)``. Number of BVH nodes visited and primitives tested by all rays of the pixel.
///
/// ``distance``, ``occlusion``, ``normal``, ``geometric_normal`` and ``material`` are ground truth. They need the
/// methods ``auto``, ``naive`` or a bracket method. With other methods, depths, disparities and ids of the right view
/// belong to points up to half a pixel from the pixel's centre.
///
/// Raises ``AttributeError`` for an array that was not requested or that the view can't have. Notebooks show the
/// picture.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct View {
    source: Source,
    /// Arrays that were accessed so far.
    made: Mutex<HashMap<&'static str, Py<PyAny>>>,
}

impl View {
    fn of(source: Source) -> Self {
        Self { source, made: Mutex::default() }
    }

    /// Returns an array: the kept one, or a new one on first access.
    fn get(&self, py: Python<'_>, output: Channel) -> PyResult<Py<PyAny>> {
        if !self.source.request().has(output) {
            let name = output.name();
            let advice = format!("'{name}' was not requested: name it in outputs, as outputs=['{name}']");
            return Err(PyAttributeError::new_err(advice));
        }
        if let Some(made) = self.made.lock().unwrap_or_else(PoisonError::into_inner).get(output.name()) {
            return Ok(made.clone_ref(py));
        }
        let array = self.make(py, output)?;
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(made.entry(output.name()).or_insert(array).clone_ref(py))
    }

    fn make(&self, py: Python<'_>, output: Channel) -> PyResult<Py<PyAny>> {
        let view = self.source.view();
        let size = [view.width, view.height];
        let values = self.source.channels().get(output).map_err(|error| match error {
            Error::Options { option, reason, .. } => PyAttributeError::new_err(format!("'{option}': {reason}")),
            other => raised(other),
        })?;
        Ok(match values {
            Values::Color(colors) => rgb(py, size, colors).into_any().unbind(),
            Values::Linear(colors) => {
                let rgb: Vec<[f32; 3]> = colors.iter().map(|&[red, green, blue, _]| [red, green, blue]).collect();
                shaped(py, size, rgb).into_any().unbind()
            }
            Values::Floats(values) => plane(py, size, values.into_owned()),
            Values::Vectors(vectors) => shaped(py, size, vectors.to_vec()).into_any().unbind(),
            Values::Ids(values) | Values::Counts(values) => plane(py, size, values.to_vec()),
            Values::Codes(values) => plane(py, size, values),
            _ => return Err(refused(format!("'{output}' has no array"))),
        })
    }
}

/// Returns one value per pixel as an array, `(height, width)`.
pub(crate) fn plane<T: Element>(py: Python<'_>, [width, height]: [u32; 2], values: Vec<T>) -> Py<PyAny> {
    match Array2::from_shape_vec((height as usize, width as usize), values) {
        Ok(array) => array.into_pyarray(py).into_any().unbind(),
        Err(_) => unreachable!("a view has as many pixels as its size says"),
    }
}

#[pymethods]
impl View {
    fn __getattr__(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        match name.parse::<Channel>() {
            Ok(output) => self.get(py, output),
            Err(_) => Err(PyAttributeError::new_err(format!("a view has no '{name}'"))),
        }
    }

    /// Size of the picture in pixels: a tuple of width and height. Arrays are ``(height, width)``.
    #[getter]
    fn size(&self) -> (u32, u32) {
        let view = self.source.view();
        (view.width, view.height)
    }

    /// Returns all requested arrays that the view has: a dict by name, in the order of the request.
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for &output in &self.source.request().outputs {
            match self.get(py, output) {
                Ok(array) => dict.set_item(output.name(), array)?,
                Err(error) if error.is_instance_of::<PyAttributeError>(py) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(dict)
    }

    fn __dir__(&self) -> Vec<&'static str> {
        let outputs = self.source.request().outputs.iter().map(|output| output.name());
        outputs.chain(["size", "arrays"]).collect()
    }

    /// Returns the picture as the bytes of a PNG file, for notebooks.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let view = self.source.view();
        png(py, &Picture::new(view.width, view.height, view.rgba8.clone()))
    }

    fn __repr__(&self) -> String {
        let view = self.source.view();
        let outputs: Vec<_> = self.source.request().outputs.iter().map(|output| output.name()).collect();
        format!("View({}x{}: {})", view.width, view.height, outputs.join(", "))
    }
}

/// Encodes a picture as a PNG file.
fn png<'py>(py: Python<'py>, picture: &Picture) -> PyResult<Bound<'py, PyBytes>> {
    let size = [picture.width as usize, picture.height as usize];
    let rgb: Vec<u8> = picture.rgba8.iter().flat_map(|&[red, green, blue, _]| [red, green, blue]).collect();
    let file = py.detach(|| encoded(size, png::ColorType::Rgb, png::BitDepth::Eight, &rgb)).map_err(refused)?;
    Ok(PyBytes::new(py, &file))
}

/// A stereo pair from ``Renderer.render`` or ``stereotrace.render``: two views and their cost. Notebooks show it as an
/// anaglyph.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct StereoPair {
    pub(crate) frame: Arc<Frame>,
    /// Left view: a ``View``.
    #[pyo3(get)]
    left: Py<View>,
    /// Right view: a ``View``.
    #[pyo3(get)]
    right: Py<View>,
    /// Motion to the next pair of a data set's item.
    pub(crate) motion: Option<Motion>,
    /// All surfaces along the lines of sight of a data set's item.
    pub(crate) layers: Option<Py<Layers>>,
    pub(crate) matches: Option<Py<Correspondence>>,
    /// Pairs of an array of cameras, by the numbers of their cameras.
    pub(crate) array: Vec<((usize, usize), Py<Self>)>,
}

impl StereoPair {
    pub(crate) fn of(py: Python<'_>, frame: Frame) -> PyResult<Self> {
        let frame = Arc::new(frame);
        let left = Py::new(py, View::of(Source::Left(frame.clone())))?;
        Ok(Self {
            left,
            right: Py::new(py, View::of(Source::Right(frame.clone())))?,
            frame,
            motion: None,
            layers: None,
            matches: None,
            array: Vec::new(),
        })
    }
}

#[pymethods]
impl StereoPair {
    /// Motion of an item of a data set, or ``None``. It is a tuple of the item's next ``StereoPair`` and two ``Flow``.
    /// The first flow leads from this pair's points to the next pair, the second one back.
    #[getter]
    fn motion(&self, py: Python<'_>) -> Option<MotionTuple> {
        self.motion.as_ref().map(|motion| motion.tuple(py))
    }

    /// ``Correspondence`` of an item of a data set whose spec names ``match``, or ``None``. ``Renderer.correspondence``
    /// makes it for any pair.
    #[getter]
    fn matches(&self, py: Python<'_>) -> Option<Py<Correspondence>> {
        self.matches.as_ref().map(|matches| matches.clone_ref(py))
    }

    /// ``Layers`` of an item of a data set whose spec names them, or ``None``. ``Renderer.layers`` makes them for any
    /// pair.
    #[getter]
    fn layers(&self, py: Python<'_>) -> Option<Py<Layers>> {
        self.layers.as_ref().map(|layers| layers.clone_ref(py))
    }

    /// All pairs of an item of a data set with an array of cameras: a dict of ``StereoPair`` by the numbers of two
    /// cameras, from 0 at the top left. It is empty otherwise. Pairs of an upper and a lower camera are turned
    /// counterclockwise, so that their rows are columns of the cameras' pictures.
    #[getter]
    fn array(&self, py: Python<'_>) -> HashMap<(usize, usize), Py<Self>> {
        self.array.iter().map(|(cameras, pair)| (*cameras, pair.clone_ref(py))).collect()
    }

    /// Camera of the pair: a ``Camera``.
    #[getter]
    fn camera(&self) -> Camera {
        self.frame.camera
    }

    /// Cost of the pair: a dict.
    ///
    /// - ``method``: name of the method that made the pair, such as the one that ``auto`` chose.
    /// - ``choice``: reasons of ``auto``, a dict; ``None`` for other methods. ``method`` made most of the right view.
    ///   ``by_bracket`` is the share of the right view made by bracket. ``gaps`` is the share of right pixels that no
    ///   left sample saw. ``shadow_rays`` and ``secondary_rays`` are numbers of rays per pixel of the left view.
    ///   ``bracket`` and ``naive`` are the predicted cost of the right view by each, in primary rays per pixel.
    /// - ``in_steps``: whether the frame was rendered again in steps, since the adapter ended long loops early.
    /// - ``left`` and ``right``: work of each view, a dict. ``primary_rays``, ``verification_rays``, ``shadow_rays``
    ///   and ``secondary_rays`` are numbers of rays. ``nodes`` is the number of BVH nodes visited, ``primitive_tests``
    ///   of primitives tested, and ``cost`` is ``2 * nodes + primitive_tests``. These three are 0 without the option
    ///   ``count`` or the output ``cost``.
    /// - ``reused``: number of right pixels that were reused. ``bad``: number of right pixels whose left sample was
    ///   rejected. ``missed``: number of right pixels in which no left sample landed.
    /// - ``retraced_share``: share of right pixels that were traced, 0 to 1.
    /// - ``second_eye``: cost of the right view relative to the left view; ``None`` if it was not counted.
    /// - ``lost_candidates`` and ``buffer_depth``: for ``buffer`` methods, the number of lost candidates, and the
    ///   number of slots per right pixel.
    /// - ``times``: list of name and seconds of each pass on the device, in order; ``None`` if the adapter has no
    ///   timestamps. Drivers may compile a kernel when it first runs.
    /// - ``intermediate_bytes``: device memory of the buffers between the passes.
    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        statistics::dict(py, &self.frame.pair.statistics)
    }

    /// Returns the anaglyph for coloured glasses: uint8, ``(height, width, 3)``, sRGB. ``kind`` is one of
    /// ``ANAGLYPHS``. Raises ``ValueError`` for another name.
    #[pyo3(signature = (kind = "dubois"))]
    fn anaglyph<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyAny>> {
        let kind: Anaglyph = named(kind)?;
        let mixed = py.detach(|| self.frame.pair.anaglyph(kind));
        Ok(array(py, &mixed).into_any())
    }

    /// Returns both views packed into one picture: side by side, one above the other, or interlaced. The array is
    /// uint8, sRGB, ``(height, width, 3)``, with twice the width or height for some packings. ``packing`` is one of
    /// ``PACKINGS``. Raises ``ValueError`` for another name.
    #[pyo3(signature = (packing = "side-by-side"))]
    fn packed<'py>(&self, py: Python<'py>, packing: &str) -> PyResult<Bound<'py, PyAny>> {
        let packing: Packing = named(packing)?;
        let packed = py.detach(|| self.frame.pair.packed(packing));
        Ok(array(py, &packed).into_any())
    }

    /// Returns a picture of the sources of the right view's pixels: uint8, ``(height, width, 3)``, sRGB. Green pixels
    /// were reused, red ones bad, yellow ones missed, and grey ones traced without reuse. See ``source`` of ``View``.
    fn retrace_map<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        array(py, &self.frame.pair.retrace_picture()).into_any()
    }

    /// Writes the pair with its ground truth as number ``index`` of a data set in ``folder``. ``layout`` is one of
    /// ``LAYOUTS``. Makes missing folders, and returns the paths of the files.
    ///
    /// Raises ``ValueError`` if no output of ground truth was requested, such as ``occlusion``. Also raises it if
    /// ``kitti`` or ``sceneflow`` get cameras that are not parallel. ``kitti`` can't hold disparities of 0 or less, or
    /// of 256 pixels or more, and raises it for these. ``panorama`` holds equirectangular pictures, and the others
    /// planar ones. Pairs with ``motion`` are written with their next pair by ``kitti`` and ``sceneflow``, and the
    /// other layouts raise it. Raises ``OSError`` if a file can't be written.
    #[pyo3(signature = (folder, layout = "middlebury", index = 0))]
    fn write(&self, py: Python<'_>, folder: PathBuf, layout: &str, index: u32) -> PyResult<Vec<PathBuf>> {
        let layout: Layout = named(layout)?;
        let Some(truth) = &self.frame.truth else {
            let reason = "files of a data set need ground truth, which was not requested: name 'occlusion' in outputs, \
                          as outputs=['color', 'occlusion']";
            return Err(refused(reason));
        };
        let next = self.motion.as_ref().map(|motion| (motion, motion.next().frame.clone()));
        let motion = next.as_ref().and_then(|(motion, next)| {
            let (forward, backward) = (&*motion.forward, &*motion.backward);
            Some(LayoutMotion { pair: &next.pair, truth: next.truth.as_ref()?, forward, backward })
        });
        py.detach(|| {
            let mut batch = Batch::new();
            layout.add_moving(&mut batch, &folder, index, (&self.frame.pair, truth), motion)?;
            batch.commit()
        })
        .map_err(raised)
    }

    /// Writes the pair into one file. Its ending selects the format: the anaglyph as ``.png`` or ``.jpg``, or both
    /// views as ``.jps`` (side by side), ``.mpo`` or ``.exr``.
    ///
    /// An ``OpenEXR`` file holds linear light, depths and ids, so the outputs must include ``linear``, and
    /// ``primitive`` or ``object``. It also holds the ground truth if that was requested. Raises ``ValueError`` for
    /// another ending and for missing outputs, and ``OSError`` if the file can't be written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let frame = &self.frame;
        if ending == "exr" && (frame.pair.left.linear.is_empty() || frame.pair.left.primitive.is_empty()) {
            let shown = path.display();
            return Err(refused(format!(
                "{shown}: it needs linear light and ids: name 'linear' and 'primitive' in outputs"
            )));
        }
        py.detach(|| {
            let mut batch = Batch::new();
            match &*ending {
                "exr" => batch.add_exr(&path, &frame.pair, frame.truth.as_ref(), ExrColor::Half)?,
                "jps" => batch.add_jps(&path, &frame.pair, 92)?,
                "mpo" => batch.add_mpo(&path, &frame.pair, 92)?,
                "png" => batch.add_png(&path, &frame.pair.anaglyph(Anaglyph::default()))?,
                "jpg" | "jpeg" => batch.add_jpeg(&path, &frame.pair.anaglyph(Anaglyph::default()), 92)?,
                _ => return Ok(false),
            }
            batch.commit().map(|_| true)
        })
        .map_err(raised)?
        .then_some(())
        .ok_or_else(|| refused(format!("{}: pairs can be written as .png, .jpg, .jps, .mpo or .exr", path.display())))
    }

    /// Returns the anaglyph as the bytes of a PNG file, for notebooks.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mixed = py.detach(|| self.frame.pair.anaglyph(Anaglyph::default()));
        png(py, &mixed)
    }

    fn __repr__(&self) -> String {
        let pair = &self.frame.pair;
        let outputs: Vec<_> = self.frame.request.outputs.iter().map(|output| output.name()).collect();
        let (method, size) = (pair.statistics.method, pair.pose.size);
        format!("StereoPair({}x{} by {method}: {})", size[0], size[1], outputs.join(", "))
    }
}

/// Views of several eyes on one line, from ``Renderer.render_views``: a sequence of ``View`` in the order of the eyes.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct Views {
    pub(crate) frame: Arc<RigFrame>,
    /// Views in the order of the eyes: a list of ``View``.
    #[pyo3(get)]
    views: Vec<Py<View>>,
}

impl Views {
    pub(crate) fn of(py: Python<'_>, frame: RigFrame) -> PyResult<Self> {
        let frame = Arc::new(frame);
        let count = frame.views.views.len();
        let views = (0..count)
            .map(|index| Py::new(py, View::of(Source::Rig(frame.clone(), index))))
            .collect::<PyResult<_>>()?;
        Ok(Self { frame, views })
    }
}

#[pymethods]
impl Views {
    /// Camera at the midpoint that the offsets count from: a ``Camera``.
    #[getter]
    fn camera(&self) -> Camera {
        self.frame.camera
    }

    /// Offsets of the eyes from the camera's midpoint to the right, in interaxials: a list of floats.
    #[getter]
    fn offsets(&self) -> Vec<f32> {
        self.frame.views.views.iter().map(|view| view.offset).collect()
    }

    /// Index of the source view of each view, or its own index if it was traced: a list of ints.
    #[getter]
    fn made_from(&self) -> Vec<usize> {
        self.frame.views.views.iter().map(|view| view.made_from).collect()
    }

    /// World positions of the eyes: a list of tuples of three.
    #[getter]
    fn eyes(&self) -> Vec<(f64, f64, f64)> {
        self.frame.views.views.iter().map(|view| self.frame.views.pose.eye_position(2.0 * view.offset).into()).collect()
    }

    /// Cost of each view: a list of dicts like ``left`` and ``right`` of ``StereoPair.statistics``.
    #[getter]
    fn work<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.frame.views.views.iter().map(|view| statistics::work(py, &view.work)).collect()
    }

    /// Returns all views in one picture for light-field displays. They are in the order of the eyes, from left to
    /// right, with the bottom row first. The array is uint8, ``(rows * height, columns * width, 3)``, sRGB. Raises
    /// ``ValueError`` if ``columns * rows`` is not the number of views.
    fn quilt<'py>(&self, py: Python<'py>, columns: u32, rows: u32) -> PyResult<Bound<'py, PyAny>> {
        let quilt = py.detach(|| quilt(&self.frame.views, columns, rows)).map_err(raised)?;
        Ok(array(py, &quilt).into_any())
    }

    fn __len__(&self) -> usize {
        self.views.len()
    }

    fn __getitem__(&self, py: Python<'_>, index: isize) -> PyResult<Py<View>> {
        let at = if index < 0 { index + self.views.len() as isize } else { index };
        let view = usize::try_from(at).ok().and_then(|at| self.views.get(at));
        view.map(|view| view.clone_ref(py)).ok_or_else(|| {
            pyo3::exceptions::PyIndexError::new_err(format!(
                "view {index} is out of range for {} views",
                self.views.len()
            ))
        })
    }

    fn __repr__(&self) -> String {
        let [width, height] = self.frame.views.pose.size;
        format!("Views({} of {width}x{height})", self.views.len())
    }
}
