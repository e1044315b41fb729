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
    values::{named, tuple},
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
            let advice = format!("'{name}' was not asked for: name it in outputs, as outputs=['color', '{name}']");
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

    #[getter]
    fn size(&self) -> (u32, u32) {
        let view = self.source.view();
        (view.width, view.height)
    }

    /// All arrays that were asked for and that there are, by name.
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

#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct StereoPair {
    frame: Arc<Frame>,
    #[pyo3(get)]
    left: Py<View>,
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
    #[getter]
    fn camera(&self) -> Camera {
        self.frame.camera
    }

    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        statistics::dict(py, &self.frame.pair.statistics)
    }

    #[pyo3(signature = (kind = "dubois"))]
    fn anaglyph<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyAny>> {
        let kind: Anaglyph = named(kind)?;
        let mixed = py.detach(|| self.frame.pair.anaglyph(kind));
        Ok(array(py, &mixed).into_any())
    }

    #[pyo3(signature = (packing = "side-by-side"))]
    fn packed<'py>(&self, py: Python<'py>, packing: &str) -> PyResult<Bound<'py, PyAny>> {
        let packing: Packing = named(packing)?;
        let packed = py.detach(|| self.frame.pair.packed(packing));
        Ok(array(py, &packed).into_any())
    }

    fn retrace_map<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        array(py, &self.frame.pair.retrace_picture()).into_any()
    }

    /// Writes the pair's files as a data set of that layout has them; returns their names.
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

    /// Writes both views into one file: `.exr`, `.jps` or `.mpo`; or the anaglyph as `.png` or `.jpg`.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let frame = &self.frame;
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

#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct Views {
    frame: Arc<RigFrame>,
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
    #[getter]
    fn camera(&self) -> Camera {
        self.frame.camera
    }

    #[getter]
    fn offsets(&self) -> Vec<f32> {
        self.frame.views.views.iter().map(|view| view.offset).collect()
    }

    #[getter]
    fn made_from(&self) -> Vec<usize> {
        self.frame.views.views.iter().map(|view| view.made_from).collect()
    }

    #[getter]
    fn eyes(&self) -> Vec<(f32, f32, f32)> {
        self.frame.views.views.iter().map(|view| tuple(self.frame.views.pose.eye_position(2.0 * view.offset))).collect()
    }

    #[getter]
    fn work<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.frame.views.views.iter().map(|view| statistics::work(py, &view.work)).collect()
    }

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
