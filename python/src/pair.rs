//! What comes back from rendering: views whose arrays are made when they are first asked for, one copy each.

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
    EyeTruth, GroundTruth, PixelSource,
    dataset::Layout,
    output::{Anaglyph, Batch, ExrColor, Packing, Picture, quilt},
};

use crate::{
    camera::Camera,
    errors::{raised, refused},
    options::{Output, Request},
    picture::{array, encoded, rgb, shaped},
    statistics,
    values::named,
};

/// A pair as it was rendered, and what was asked for.
pub(crate) struct Frame {
    pub(crate) pair: stereotrace::StereoPair,
    pub(crate) truth: Option<GroundTruth>,
    pub(crate) camera: Camera,
    pub(crate) request: Request,
}

/// The views of a rig, and what was asked for.
pub(crate) struct RigFrame {
    pub(crate) views: stereotrace::Views,
    pub(crate) camera: Camera,
    pub(crate) request: Request,
}

/// Whose pixels a view shows.
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

    fn truth(&self) -> Option<&EyeTruth> {
        match self {
            Self::Left(frame) => frame.truth.as_ref().map(|truth| &truth.left),
            Self::Right(frame) => frame.truth.as_ref().map(|truth| &truth.right),
            Self::Rig(..) => None,
        }
    }

    /// Where each pixel came from; of a pair's right view.
    fn pixel_source(&self) -> &[PixelSource] {
        match self {
            Self::Left(_) => &[],
            Self::Right(frame) => &frame.pair.source,
            Self::Rig(frame, index) => &frame.views.views[*index].source,
        }
    }
}

/// What one eye sees. Its arrays are attributes, each of which is there if it was named in ``outputs``.
///
/// Arrays are row-major, top row first; each is made when it is first asked for, and kept. Depths, ids and ground truth
/// are of the first surface that the ray through a pixel's centre meets, whatever mirrors or glass show there. The
/// world is right-handed with y up.
///
/// - ``color``: uint8, ``(height, width, 3)``. The picture, as sRGB bytes.
/// - ``linear``: float32, ``(height, width, 3)``. Light as it comes, linear RGB, before the options ``exposure`` and
///   ``tone``; it may be above 1.
/// - ``depth``: float32, ``(height, width)``. Depth along the view direction in world units; infinite where nothing is.
/// - ``distance``: float32, ``(height, width)``. Distance from the eye along the pixel's ray in world units; infinite
///   where nothing is.
/// - ``disparity``: float32, ``(height, width)``. ``x_left - x_right`` in pixels: above 0 before the screen, 0 on it
///   and below 0 behind it; of parallel cameras 0 at infinity and above 0 before it. Where nothing is it is that of
///   infinite depth. What the left view's pixel in column i shows stands at ``i + 0.5 - disparity`` in the right view,
///   and what the right view's shows at ``i + 0.5 + disparity`` in the left one. Of pairs whose eyes are not toed in.
/// - ``occlusion``: uint8, ``(height, width)``. Whether the other eye sees the point: 0 visible, 1 hidden by something
///   nearer, 2 out of the other picture's frame, seen or not. Of pairs.
/// - ``normal``: float32, ``(height, width, 3)``. The normal that the surface is lit by, interpolated where a mesh has
///   normals: in the world's frame, of unit length, on the side of the geometric one; zero where nothing is. Of pairs.
/// - ``geometric_normal``: float32, ``(height, width, 3)``. The normal of the surface itself, towards the eye: in the
///   world's frame, of unit length; zero where nothing is. Of pairs.
/// - ``primitive``: uint32, ``(height, width)``. The id of the primitive; ``MISS``, which is 2**32 - 1, where nothing
///   is.
/// - ``object``: uint32, ``(height, width)``. The id of its object; ``MISS`` where nothing is.
/// - ``material``: uint32, ``(height, width)``. The id of its material; ``MISS`` where nothing is. Of pairs.
/// - ``source``: uint8, ``(height, width)``. Where each pixel of a pair's right view, or of a rig's views, came from: 0
///   reused, taken over from another view; 1 bad, traced since what landed there was not what is seen; 2 missed, traced
///   since nothing landed there; 3 traced without looking at another view.
/// - ``shadow_source``: uint8, ``(height, width)``. How it is known which lights each pixel of the same views sees: 0
///   taken over from another view, or there was nothing to ask; 1 traced, by one shadow ray at least. Of views made by
///   a bracket only.
/// - ``cost``: uint32, ``(height, width)``. BVH nodes visited and primitives tested for the pixel, by all its rays.
///
/// ``distance`` and what is said to be of pairs, but for ``disparity``, are ground truth, by the methods ``auto``,
/// ``naive`` and the brackets. Of the other methods, depths, disparities and ids of the right view are those of points
/// up to half a pixel aside.
///
/// Raises ``AttributeError`` for an array that was not asked for or that the view can't have. Notebooks show the
/// picture.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct View {
    source: Source,
    /// The arrays that were asked for so far.
    made: Mutex<HashMap<&'static str, Py<PyAny>>>,
}

impl View {
    fn of(source: Source) -> Self {
        Self { source, made: Mutex::default() }
    }

    /// An array: that which was made before, or a new one.
    fn get(&self, py: Python<'_>, output: Output) -> PyResult<Py<PyAny>> {
        if !self.source.request().has(output) {
            let name = output.name();
            let advice = format!("'{name}' was not asked for: name it in outputs, as outputs=['{name}']");
            return Err(PyAttributeError::new_err(advice));
        }
        if let Some(made) = self.made.lock().unwrap_or_else(PoisonError::into_inner).get(output.name()) {
            return Ok(made.clone_ref(py));
        }
        let array = self.make(py, output)?;
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(made.entry(output.name()).or_insert(array).clone_ref(py))
    }

    fn make(&self, py: Python<'_>, output: Output) -> PyResult<Py<PyAny>> {
        let view = self.source.view();
        let size = [view.width, view.height];
        let none = |why: &str| Err(PyAttributeError::new_err(format!("'{}': {why}", output.name())));
        let truth = || {
            self.source.truth().ok_or_else(|| {
                PyAttributeError::new_err(format!("'{}' is ground truth, which pairs have, not rigs", output.name()))
            })
        };
        Ok(match output {
            Output::Color => rgb(py, size, &view.rgba8).into_any().unbind(),
            Output::Linear => {
                let rgb: Vec<[f32; 3]> = view.linear.iter().map(|&[red, green, blue, _]| [red, green, blue]).collect();
                shaped(py, size, rgb).into_any().unbind()
            }
            Output::Depth => plane(py, size, view.depth.clone()),
            Output::Primitive => plane(py, size, view.primitive.clone()),
            Output::Object => plane(py, size, view.object.clone()),
            Output::Cost => plane(py, size, view.cost.clone()),
            Output::Disparity => {
                let disparity = match &self.source {
                    Source::Left(frame) => frame.pair.disparity(),
                    Source::Right(frame) => frame.pair.right_disparity(),
                    Source::Rig(..) => return none("disparities are of pairs; Camera.disparity gives that of a depth"),
                };
                if disparity.is_empty() {
                    return none("eyes that are toed in have none: points don't stay in their rows");
                }
                plane(py, size, disparity)
            }
            Output::Source => {
                let source = self.source.pixel_source();
                if source.is_empty() {
                    return none("the left view is traced; the right view has it");
                }
                plane(py, size, source.iter().map(|source| *source as u8).collect())
            }
            Output::ShadowSource => {
                let source = match &self.source {
                    Source::Left(_) => return none("the left view is traced; the right view has it"),
                    Source::Right(frame) => &frame.pair.shadow_source,
                    Source::Rig(frame, index) => &frame.views.views[*index].shadow_source,
                };
                if source.is_empty() {
                    return none("only brackets know it");
                }
                plane(py, size, source.iter().map(|source| *source as u8).collect())
            }
            Output::Distance => plane(py, size, truth()?.distance.clone()),
            Output::Occlusion => plane(py, size, truth()?.occlusion.iter().map(|found| *found as u8).collect()),
            Output::Material => plane(py, size, truth()?.material.clone()),
            Output::Normal => shaped(py, size, truth()?.shading_normal.clone()).into_any().unbind(),
            Output::GeometricNormal => shaped(py, size, truth()?.geometric_normal.clone()).into_any().unbind(),
        })
    }
}

/// One value a pixel, `(height, width)`.
fn plane<T: Element>(py: Python<'_>, [width, height]: [u32; 2], values: Vec<T>) -> Py<PyAny> {
    match Array2::from_shape_vec((height as usize, width as usize), values) {
        Ok(array) => array.into_pyarray(py).into_any().unbind(),
        Err(_) => unreachable!("a view has as many pixels as its size says"),
    }
}

#[pymethods]
impl View {
    fn __getattr__(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        match name.parse() {
            Ok(output) => self.get(py, output),
            Err(_) => Err(PyAttributeError::new_err(format!("a view has no '{name}'"))),
        }
    }

    /// The picture's size in pixels: a tuple of width and height. Arrays are ``(height, width)``.
    #[getter]
    fn size(&self) -> (u32, u32) {
        let view = self.source.view();
        (view.width, view.height)
    }

    /// All arrays that were asked for and that the view has: a dict by their names, in the order in which they were
    /// asked for.
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

    /// The picture as the bytes of a PNG file, for notebooks.
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

/// A picture as the bytes of a PNG file.
fn png<'py>(py: Python<'py>, picture: &Picture) -> PyResult<Bound<'py, PyBytes>> {
    let size = [picture.width as usize, picture.height as usize];
    let rgb: Vec<u8> = picture.rgba8.iter().flat_map(|&[red, green, blue, _]| [red, green, blue]).collect();
    let file = py.detach(|| encoded(size, png::ColorType::Rgb, png::BitDepth::Eight, &rgb)).map_err(refused)?;
    Ok(PyBytes::new(py, &file))
}

/// A stereo pair, as ``Renderer.render`` and ``stereotrace.render`` make it: two views and what they cost. Notebooks
/// show it as an anaglyph.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct StereoPair {
    frame: Arc<Frame>,
    /// What the left eye sees: a ``View``.
    #[pyo3(get)]
    left: Py<View>,
    /// What the right eye sees: a ``View``.
    #[pyo3(get)]
    right: Py<View>,
}

impl StereoPair {
    pub(crate) fn of(py: Python<'_>, frame: Frame) -> PyResult<Self> {
        let frame = Arc::new(frame);
        let left = Py::new(py, View::of(Source::Left(frame.clone())))?;
        Ok(Self { left, right: Py::new(py, View::of(Source::Right(frame.clone())))?, frame })
    }
}

#[pymethods]
impl StereoPair {
    /// The camera that the pair was rendered with: a ``Camera``.
    #[getter]
    fn camera(&self) -> Camera {
        self.frame.camera
    }

    /// What the pair cost: a dict.
    ///
    /// - ``method``: the name of the method that made the pair, such as the one that ``auto`` chose.
    /// - ``choice``: why ``auto`` chose it, ``None`` by other methods: a dict of ``method``; ``by_bracket``, the share
    ///   of the right view that was made by bracket; ``gaps``, the share of right pixels that no left sample saw;
    ///   ``shadow_rays`` and ``secondary_rays`` a pixel of the left view; ``bracket`` and ``naive``, what the right
    ///   view was predicted to cost by either, in primary rays a pixel.
    /// - ``in_steps``: whether the frame was rendered again, in steps, since the adapter ended the loops of threads
    ///   before they were done.
    /// - ``left`` and ``right``: each view's work, a dict of ``primary_rays``, ``verification_rays``, ``shadow_rays``,
    ///   ``secondary_rays``, ``nodes`` (BVH nodes visited), ``primitive_tests``, and ``cost``, which is ``2 * nodes +
    ///   primitive_tests``. The last three are 0 unless the option ``count`` or the output ``cost`` was asked for.
    /// - ``reused``, ``bad``, ``missed``: right pixels that were taken over, whose left sample was rejected, and that
    ///   no left sample landed in.
    /// - ``retraced_share``: the share of the right pixels that were traced, 0 to 1.
    /// - ``second_eye``: the right view's cost relative to the left view's; ``None`` where it was not counted.
    /// - ``lost_candidates`` and ``buffer_depth``: of ``buffer`` methods, candidates that were lost and slots a right
    ///   pixel.
    /// - ``times``: a list of the name and the seconds of each pass on the device, in order; ``None`` where the adapter
    ///   has no timestamps. Drivers may compile a kernel when it first runs.
    /// - ``intermediate_bytes``: device memory of the buffers between the passes.
    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        statistics::dict(py, &self.frame.pair.statistics)
    }

    /// Both views in one picture for coloured glasses: uint8, ``(height, width, 3)``, sRGB. ``kind`` is one of
    /// ``ANAGLYPHS``. Raises ``ValueError`` for another name.
    #[pyo3(signature = (kind = "dubois"))]
    fn anaglyph<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyAny>> {
        let kind: Anaglyph = named(kind)?;
        let mixed = py.detach(|| self.frame.pair.anaglyph(kind));
        Ok(array(py, &mixed).into_any())
    }

    /// Both views beside, below or between each other in one picture: uint8, sRGB, ``(height, width, 3)`` with twice
    /// the width or height where the packing says so. ``packing`` is one of ``PACKINGS``. Raises ``ValueError`` for
    /// another name.
    #[pyo3(signature = (packing = "side-by-side"))]
    fn packed<'py>(&self, py: Python<'py>, packing: &str) -> PyResult<Bound<'py, PyAny>> {
        let packing: Packing = named(packing)?;
        let packed = py.detach(|| self.frame.pair.packed(packing));
        Ok(array(py, &packed).into_any())
    }

    /// Where the right view's pixels came from, as a picture: uint8, ``(height, width, 3)``, sRGB. Green is reused, red
    /// bad, yellow missed, grey traced without reuse.
    fn retrace_map<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        array(py, &self.frame.pair.retrace_picture()).into_any()
    }

    /// Writes the pair's files, ground truth among them, as a data set of a ``layout``, one of ``LAYOUTS``, has them,
    /// as number ``index`` of the data set in ``folder``. Makes folders where there are none, and returns the paths
    /// of the files.
    ///
    /// Raises ``ValueError`` where no ground truth was asked for (an output such as ``occlusion``), where ``kitti`` or
    /// ``sceneflow`` are to have a pair whose cameras are not parallel, and for disparities that ``kitti`` can't
    /// hold: 0 and less, or 256 pixels and more. Raises ``OSError`` if a file can't be written.
    #[pyo3(signature = (folder, layout = "middlebury", index = 0))]
    fn write(&self, py: Python<'_>, folder: PathBuf, layout: &str, index: u32) -> PyResult<Vec<PathBuf>> {
        let layout: Layout = named(layout)?;
        let Some(truth) = &self.frame.truth else {
            let reason = "files of a data set have ground truth, which was not asked for: name 'occlusion' in outputs, as outputs=['color', 'occlusion']";
            return Err(refused(reason));
        };
        py.detach(|| {
            let mut batch = Batch::new();
            layout.add(&mut batch, &folder, index, &self.frame.pair, truth)?;
            batch.commit()
        })
        .map_err(raised)
    }

    /// Writes the pair into one file, whose ending says how: the anaglyph as ``.png`` or ``.jpg``, or both views as
    /// ``.jps`` (side by side), ``.mpo`` or ``.exr``.
    ///
    /// An ``OpenEXR`` file has linear light, depths and ids, so the outputs must have ``linear``, and ``primitive`` or
    /// ``object``; with ground truth among them it has that too. Raises ``ValueError`` for another ending and for
    /// what was not asked for, and ``OSError`` if the file can't be written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let frame = &self.frame;
        if ending == "exr" && (frame.pair.left.linear.is_empty() || frame.pair.left.primitive.is_empty()) {
            let shown = path.display();
            return Err(refused(format!(
                "{shown}: it has linear light and ids: name 'linear' and 'primitive' in outputs"
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
        .ok_or_else(|| refused(format!("{}: pairs are written as .png, .jpg, .jps, .mpo or .exr", path.display())))
    }

    /// The anaglyph as the bytes of a PNG file, for notebooks.
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

/// The views of several eyes on one line, as ``Renderer.render_views`` makes them: a sequence of ``View``, in the order
/// of the eyes.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct Views {
    frame: Arc<RigFrame>,
    /// The views in the order of the eyes: a list of ``View``.
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
    /// The camera in the middle of the eyes: a ``Camera``.
    #[getter]
    fn camera(&self) -> Camera {
        self.frame.camera
    }

    /// The eyes' offsets from the camera's midpoint, in interaxials, to the right: a list of floats.
    #[getter]
    fn offsets(&self) -> Vec<f32> {
        self.frame.views.views.iter().map(|view| view.offset).collect()
    }

    /// Of each view the index of the one that it was made from, its own where it was traced: a list of ints.
    #[getter]
    fn made_from(&self) -> Vec<usize> {
        self.frame.views.views.iter().map(|view| view.made_from).collect()
    }

    /// Where the eyes stand, world positions: a list of tuples of three.
    #[getter]
    fn eyes(&self) -> Vec<(f64, f64, f64)> {
        self.frame.views.views.iter().map(|view| self.frame.views.pose.eye_position(2.0 * view.offset).into()).collect()
    }

    /// What each view cost: a list of dicts as ``left`` and ``right`` of ``StereoPair.statistics`` are.
    #[getter]
    fn work<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.frame.views.views.iter().map(|view| statistics::work(py, &view.work)).collect()
    }

    /// All views in one picture, as light-field displays take them: from left to right as the eyes come, the bottom row
    /// first. uint8, ``(rows * height, columns * width, 3)``, sRGB. Raises ``ValueError`` if ``columns * rows`` is
    /// not the number of views.
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
        view.map(|view| view.clone_ref(py))
            .ok_or_else(|| pyo3::exceptions::PyIndexError::new_err(format!("view {index} of {}", self.views.len())))
    }

    fn __repr__(&self) -> String {
        let [width, height] = self.frame.views.pose.size;
        format!("Views({} of {width}x{height})", self.views.len())
    }
}
