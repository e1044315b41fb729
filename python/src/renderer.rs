//! The renderer: a device, and the scenes that stand on it.

use std::{
    ops::ControlFlow,
    sync::{Mutex, MutexGuard, PoisonError},
};

use numpy::PyArray1;
use pyo3::{prelude::*, types::PyDict};
use stereotrace::{
    Adapter, BvhBuild, Error, Gpu, GroundTruth, Progress, Ray, Rig, Update, UploadedScene, dataset::FreePoses,
};

use crate::{
    camera::Camera,
    errors::{raised, refused},
    options::Request,
    pair::{Frame, RigFrame, StereoPair, Views},
    scene::{Scene, State},
    values,
};

/// Scenes that stay on the device where nothing is said.
const KEPT_SCENES: usize = 4;

/// t and primitive of each ray.
type Hits<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<u32>>);

#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct Renderer {
    stage: Mutex<Stage>,
    adapter: String,
    driver: String,
    is_software: bool,
}

/// What one thread at a time works with.
struct Stage {
    renderer: stereotrace::Renderer,
    /// The scenes on the device, the one that was used last at the end.
    scenes: Vec<(State, UploadedScene)>,
    kept: usize,
}

impl Stage {
    /// The scene on the device as it is now, the last of the list then.
    fn bring(&mut self, scene: &stereotrace::Scene, state: State) -> Result<(), Error> {
        let place = self.scenes.iter().position(|(known, _)| known.is_of_scene(state));
        let Some(place) = place else {
            if self.scenes.len() >= self.kept {
                self.scenes.remove(0);
            }
            let uploaded = self.renderer.upload(scene)?;
            self.scenes.push((state, uploaded));
            return Ok(());
        };
        let (known, mut uploaded) = self.scenes.remove(place);
        if known != state {
            // What moved keeps its tree where that is possible, and light and materials alone take no tree.
            if self.renderer.update(&mut uploaded, scene, Update::Refit).is_err() {
                uploaded = self.renderer.upload(scene)?;
            }
        }
        self.scenes.push((state, uploaded));
        Ok(())
    }
}

impl Renderer {
    fn stage(&self) -> MutexGuard<'_, Stage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does a frame's work without Python's lock. Between bands of rows Python may handle signals, and `progress` is called.
    fn work<T: Send>(
        &self,
        py: Python<'_>,
        scene: &Scene,
        progress: Option<Py<PyAny>>,
        work: impl FnOnce(
            &mut stereotrace::Renderer,
            &UploadedScene,
            &mut stereotrace::renderer::OnProgress<'_>,
        ) -> Result<T, Error>
        + Send,
    ) -> PyResult<T> {
        let mut stopped = None;
        let (inner, state) = (&scene.inner, scene.state);
        let done = py.detach(|| {
            let mut stage = self.stage();
            stage.bring(inner, state)?;
            let Stage { renderer, scenes, .. } = &mut *stage;
            let Some((_, uploaded)) = scenes.last() else { unreachable!("a scene was brought") };
            work(renderer, uploaded, &mut |now: Progress| {
                let told = Python::attach(|py| {
                    py.check_signals()?;
                    progress.as_ref().map_or(Ok(()), |progress| progress.call1(py, (now.pass, now.done)).map(drop))
                });
                match told {
                    Ok(()) => ControlFlow::Continue(()),
                    Err(error) => {
                        stopped = Some(error);
                        ControlFlow::Break(())
                    }
                }
            })
        });
        match (done, stopped) {
            (Err(Error::Cancelled), Some(error)) => Err(error),
            (done, _) => done.map_err(raised),
        }
    }
}

#[pymethods]
impl Renderer {
    #[new]
    #[pyo3(signature = (adapter = None, *, kept_scenes = KEPT_SCENES))]
    fn new(py: Python<'_>, adapter: Option<String>, kept_scenes: usize) -> PyResult<Self> {
        if kept_scenes == 0 {
            return Err(refused("kept_scenes: it must be 1 or more"));
        }
        let adapter = match adapter.as_deref() {
            None => Adapter::FromEnv,
            Some("fastest") => Adapter::Fastest,
            Some(name) => Adapter::from(name),
        };
        let gpu = py.detach(|| Gpu::open(adapter)).map_err(raised)?;
        let (name, driver) = (gpu.adapter_name(), gpu.driver());
        let is_software = gpu.adapter_info().device_type == stereotrace::wgpu::DeviceType::Cpu;
        let renderer = stereotrace::Renderer::new(gpu);
        let stage = Stage { renderer, scenes: Vec::new(), kept: kept_scenes };
        Ok(Self { stage: Mutex::new(stage), adapter: name, driver, is_software })
    }

    #[getter]
    fn adapter(&self) -> &str {
        &self.adapter
    }

    #[getter]
    fn driver(&self) -> &str {
        &self.driver
    }

    #[getter]
    fn is_software(&self) -> bool {
        self.is_software
    }

    #[pyo3(signature = (scene, camera, *, progress = None, **options))]
    fn render(
        &self,
        py: Python<'_>,
        scene: &Scene,
        camera: Camera,
        progress: Option<Py<PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<StereoPair> {
        let request = Request::of(options)?;
        let wants_truth = request.needs_ground_truth();
        let (pair, truth) = self.work(py, scene, progress, |renderer, uploaded, progress| {
            let pair = renderer.render_with(uploaded, &camera.0, &request.options, progress)?;
            let truth = wants_truth.then(|| renderer.ground_truth(uploaded, &scene.inner, &pair)).transpose()?;
            Ok::<(_, Option<GroundTruth>), Error>((pair, truth))
        })?;
        StereoPair::of(py, Frame { pair, truth, camera, request })
    }

    #[pyo3(signature = (scene, camera, eyes, *, traced = None, progress = None, **options))]
    #[expect(clippy::too_many_arguments, reason = "Python's keywords")]
    fn render_views(
        &self,
        py: Python<'_>,
        scene: &Scene,
        camera: Camera,
        eyes: &Bound<'_, PyAny>,
        traced: Option<Vec<usize>>,
        progress: Option<Py<PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Views> {
        let request = Request::of(options)?;
        if request.needs_ground_truth() {
            return Err(refused(
                "outputs: ground truth (distance, occlusion, normals, material) is of pairs, not of rigs",
            ));
        }
        let rig = match (eyes.extract::<usize>(), eyes.extract::<Vec<f32>>()) {
            (Ok(count), _) => Rig::row(camera.0, count),
            (_, Ok(offsets)) => Rig::at(camera.0, offsets),
            _ => {
                return Err(refused(format!(
                    "eyes: {} must be a number of them, or their offsets in interaxials",
                    values::shown(eyes)
                )));
            }
        };
        let rig = match traced {
            Some(views) => rig.traced(views),
            None => rig,
        };
        let views = self.work(py, scene, progress, |renderer, uploaded, progress| {
            renderer.render_views_with(uploaded, &rig, &request.options, progress)
        })?;
        Views::of(py, RigFrame { views, camera, request })
    }

    #[pyo3(signature = (scene, camera, seed, item, *, clearance = None, max_disparity = None, min_surfaces = None))]
    #[expect(clippy::too_many_arguments, reason = "Python's keywords")]
    fn free_camera(
        &self,
        py: Python<'_>,
        scene: &Scene,
        camera: Camera,
        seed: u32,
        item: u32,
        clearance: Option<f32>,
        max_disparity: Option<f32>,
        min_surfaces: Option<f32>,
    ) -> PyResult<(Camera, u32)> {
        let found = self.work(py, scene, None, |renderer, uploaded, _| {
            let mut poses = FreePoses::new(&scene.inner, camera.0, seed)?;
            if let Some(distance) = clearance {
                poses = poses.clearance(distance);
            }
            if let Some(pixels) = max_disparity {
                poses = poses.disparity(pixels);
            }
            if let Some(share) = min_surfaces {
                poses = poses.surfaces(share);
            }
            poses.find(renderer, uploaded, item)
        })?;
        Ok((Camera(found.camera), found.tries))
    }

    /// The nearest hit of each ray: t and primitive.
    fn closest_hits<'py>(
        &self,
        py: Python<'py>,
        scene: &Scene,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
    ) -> PyResult<Hits<'py>> {
        let (origins, directions) = (values::points("origins", origins)?, values::points("directions", directions)?);
        if origins.len() != directions.len() && origins.len() != 1 {
            return Err(refused(format!(
                "origins: {} for {} directions; give one, or one each",
                origins.len(),
                directions.len()
            )));
        }
        let rays = directions
            .iter()
            .enumerate()
            .map(|(index, &direction)| Ray::new(origins[if origins.len() == 1 { 0 } else { index }], direction));
        let rays: Vec<Ray> = rays.collect();
        let hits = self.work(py, scene, None, |renderer, uploaded, _| renderer.closest_hits(uploaded, &rays))?.hits;
        let (t, ids): (Vec<f32>, Vec<u32>) = hits.iter().map(|hit| (hit.t, hit.primitive)).unzip();
        Ok((PyArray1::from_vec(py, t), PyArray1::from_vec(py, ids)))
    }

    /// Builds a scene's tree and brings it to the device, which `render` does by itself.
    #[pyo3(signature = (scene, *, build = "balanced"))]
    fn upload(&self, py: Python<'_>, scene: &Scene, build: &str) -> PyResult<()> {
        let build = match build {
            "fast" => BvhBuild::Fast,
            "balanced" => BvhBuild::Balanced,
            "best" => BvhBuild::Best,
            other => return Err(refused(format!("build: '{other}' is none; there are fast, balanced and best"))),
        };
        let (inner, state) = (&scene.inner, scene.state);
        py.detach(|| {
            let mut stage = self.stage();
            let uploaded = stage.renderer.upload_with(inner, build)?;
            stage.scenes.retain(|(known, _)| !known.is_of_scene(state));
            if stage.scenes.len() >= stage.kept {
                stage.scenes.remove(0);
            }
            stage.scenes.push((state, uploaded));
            Ok(())
        })
        .map_err(raised)
    }

    fn __repr__(&self) -> String {
        format!("Renderer({}, {})", self.adapter, self.driver)
    }
}
