//! Data sets: the library's specs, and the maker of their pairs.

use std::path::PathBuf;

use pyo3::prelude::*;
use stereotrace::{
    Options,
    blocking::Wait,
    dataset::{self, ArrayPair, MadePair, NextPair, Spec},
};

use crate::{
    camera::Camera,
    correspondence::Correspondence,
    errors::{raised, refused},
    flow::Motion,
    layers::Layers,
    options::Request,
    pair::{Frame, StereoPair},
    renderer::Renderer,
    scene::Scene,
};

/// Layers and matches of a pair.
type Further = (Option<stereotrace::Layers>, Option<stereotrace::Correspondence>);

/// A checked spec of a data set, from JSON text. Paths of files are relative to ``folder``. ``ValueError`` names the
/// key of an invalid value. ``stereotrace.dataset.Spec`` reads specs from files.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct DataSetSpec(Spec);

#[pymethods]
impl DataSetSpec {
    #[new]
    fn new(text: &str, folder: PathBuf) -> PyResult<Self> {
        Spec::from_json(text, folder).map(Self).map_err(raised)
    }

    /// Returns the spec with its defaults as JSON text.
    fn to_json(&self) -> String {
        self.0.to_json()
    }

    /// View and output of each array, in the order of files: a list of tuples. Views are ``"left"``, ``"right"``,
    /// ``"next.left"`` and ``"next.right"``; with an array of cameras ``"camera00"`` and ``"pair00-01.left"``.
    #[getter]
    fn arrays(&self) -> Vec<(String, &'static str)> {
        self.0.files().into_iter().map(|(view, output)| (view, output.name())).collect()
    }
}

/// Makes the pairs of a spec. It reads scenes when they are needed, and keeps the most recently used ones, up to
/// ``scene_memory`` bytes in memory and on the device together. The current scene is always kept.
///
/// One thread at a time may use it; a second one gets a ``RuntimeError``.
#[pyclass(module = "stereotrace")]
pub(crate) struct PairMaker(dataset::PairMaker);

#[pymethods]
impl PairMaker {
    #[new]
    fn new(spec: &DataSetSpec, scene_memory: usize) -> Self {
        Self(dataset::PairMaker::new(spec.0.clone()).scene_memory(scene_memory))
    }

    /// Sets the hashes that scenes must have when they are read, as ``scene_sha256`` returns them. ``None`` accepts any
    /// content.
    fn expect_hashes(&mut self, hashes: Vec<Option<String>>) {
        self.0.expect_hashes(&hashes);
    }

    /// Indices of the scenes read so far, in this order: a list of int.
    #[getter]
    fn scenes_read(&self) -> Vec<usize> {
        self.0.scenes_read().to_vec()
    }

    /// Returns whether a scene is in memory.
    fn has_scene(&self, scene: usize) -> bool {
        self.0.has_scene(scene)
    }

    /// Returns the index of a pair's scene.
    fn scene_of(&self, item: u32) -> usize {
        self.0.scene_of(item)
    }

    /// Returns a copy of a scene, with the lights and materials of the last pair. Raises ``ValueError`` if it can't be
    /// read.
    fn scene(&mut self, py: Python<'_>, scene: usize) -> PyResult<Scene> {
        let found = py.detach(|| self.0.scene(scene).cloned());
        Ok(Scene::of(found.map_err(raised)?, Vec::new(), None))
    }

    /// Returns a SHA-256 of everything that pictures of a scene depend on: its content and its camera in the spec.
    /// Raises ``ValueError`` if the scene can't be read.
    fn scene_sha256(&mut self, py: Python<'_>, scene: usize) -> PyResult<String> {
        py.detach(|| self.0.scene_sha256(scene)).map_err(raised)
    }

    /// Makes a pair. Returns a tuple of the pair and its record as JSON text. Raises as ``Renderer.render`` does.
    fn pair(&mut self, py: Python<'_>, renderer: &Renderer, item: u32) -> PyResult<(StereoPair, String)> {
        let (made, outputs) = renderer.work_alone(py, |renderer, progress| {
            Ok((self.0.pair(renderer, item, progress).wait()?, self.0.channels()))
        })?;
        let MadePair { pair, truth, layers, matches, camera, record, next, array, .. } = made;
        let record = serde_json::to_string(&record).map_err(|error| refused(error.to_string()))?;
        let pair_of = |pair, truth, (layers, matches): Further, camera| {
            let request = Request { options: Options::default(), outputs: outputs.clone() };
            let mut found = StereoPair::of(py, Frame { pair, truth, camera: Camera(camera), request })?;
            found.layers = layers.map(|layers| Py::new(py, Layers::of(layers))).transpose()?;
            found.matches = matches.map(|matches| Py::new(py, Correspondence::of(matches))).transpose()?;
            Ok::<_, PyErr>(found)
        };
        let mut found = pair_of(pair, truth, (layers, matches), camera)?;
        if let Some(next) = next {
            let NextPair { pair, truth, layers, matches, camera, forward, backward, .. } = *next;
            found.motion = Some(Motion::of(py, pair_of(pair, truth, (layers, matches), camera)?, forward, backward)?);
        }
        for ArrayPair { cameras: [one, other], camera, pair, truth, layers, .. } in array {
            let pair = pair_of(pair, truth, (layers, None), camera)?;
            found.array.push(((one, other), Py::new(py, pair)?));
        }
        Ok((found, record))
    }
}
