//! The renderer: a device, and the scenes that stand on it.

use std::{
    ops::ControlFlow,
    process,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU32, Ordering},
    },
    thread::{self, ThreadId},
};

use numpy::PyArray1;
use pyo3::{exceptions::PyRuntimeError, prelude::*, types::PyDict};
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

/// A graphics device that renders, and the scenes that stand on it.
///
/// ``Renderer()`` takes the adapter that the environment variable ``STEREOTRACE_ADAPTER`` names, or else the fastest
/// one. ``adapter`` names another: ``"fastest"``, ``"software"`` for one that runs on the CPU, or a part of an
/// adapter's name. ``kept_scenes`` is how many scenes stay on the device, the ones that were used last; 4 where nothing
/// is said.
///
/// A renderer may be used from several threads: it does one frame after the other, without Python's lock. Raises
/// ``AdapterError`` where no such adapter is found.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct Renderer {
    stage: Mutex<Stage>,
    /// Who uses it now.
    at_work: Mutex<Option<ThreadId>>,
    adapter: String,
    driver: String,
    is_software: bool,
}

/// A lock that another thread's panic poisoned still guards whole values here.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Which process opened the first device; 0 before.
static OPENED_BY: AtomicU32 = AtomicU32::new(0);

/// Drivers don't survive a fork: in a child of a process that has opened a device all that uses one, a new one too,
/// waits for ever.
fn check_process() -> PyResult<()> {
    match OPENED_BY.load(Ordering::Relaxed) {
        opened_by if opened_by == 0 || opened_by == process::id() => Ok(()),
        _ => Err(PyRuntimeError::new_err(
            "this process was forked from one that had opened a graphics device, which drivers don't survive: start processes by spawn, \
             as multiprocessing.get_context('spawn') does, or render in none before",
        )),
    }
}

/// A thread's use of a renderer, until it is dropped.
struct AtWork<'a>(&'a Mutex<Option<ThreadId>>);

impl<'a> AtWork<'a> {
    fn begin(who: &'a Mutex<Option<ThreadId>>, this: ThreadId) -> Self {
        *lock(who) = Some(this);
        Self(who)
    }
}

impl Drop for AtWork<'_> {
    fn drop(&mut self) {
        *lock(self.0) = None;
    }
}

/// What one thread at a time works with.
struct Stage {
    renderer: stereotrace::Renderer,
    /// The scenes on the device, the one that was used last at the end.
    scenes: Vec<(State, UploadedScene)>,
    kept: usize,
}

impl Stage {
    /// Lets go of the scene that was used longest ago, where there is no place for one more.
    fn make_room(&mut self) {
        if self.scenes.len() >= self.kept {
            self.scenes.remove(0);
        }
    }

    /// The scene on the device as it is now, the last of the list then.
    fn bring(&mut self, scene: &stereotrace::Scene, state: State) -> Result<(), Error> {
        let place = self.scenes.iter().position(|(known, _)| known.is_of_scene(state));
        let Some(place) = place else {
            self.make_room();
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
    /// Does what takes the device without Python's lock, once no other thread uses it. A thread that is at it already,
    /// and now runs a callback or handles a signal, would wait for itself: that is an error.
    fn with_stage<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Stage) -> Result<T, Error> + Send,
    ) -> PyResult<T> {
        check_process()?;
        let this = thread::current().id();
        if *lock(&self.at_work) == Some(this) {
            let reason = "this renderer is making a picture, whose callback asks it for another: take another renderer";
            return Err(PyRuntimeError::new_err(reason));
        }
        let done = py.detach(|| {
            let mut stage = lock(&self.stage);
            let _at_work = AtWork::begin(&self.at_work, this);
            work(&mut stage)
        });
        done.map_err(raised)
    }

    /// Does a frame's work without Python's lock. Between bands of rows Python may handle signals, and `progress` is
    /// called.
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
        let done = self.with_stage(py, |stage| {
            stage.bring(inner, state)?;
            let Stage { renderer, scenes, .. } = stage;
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
        // What stopped it is the error to tell.
        stopped.map_or(done, Err)
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
        check_process()?;
        let gpu = py.detach(|| Gpu::open(adapter)).map_err(raised)?;
        OPENED_BY.store(process::id(), Ordering::Relaxed);
        let (name, driver) = (gpu.adapter_name(), gpu.driver());
        let is_software = gpu.adapter_info().device_type == stereotrace::wgpu::DeviceType::Cpu;
        let renderer = stereotrace::Renderer::new(gpu);
        let stage = Mutex::new(Stage { renderer, scenes: Vec::new(), kept: kept_scenes });
        Ok(Self { stage, at_work: Mutex::default(), adapter: name, driver, is_software })
    }

    /// The name of the adapter.
    #[getter]
    fn adapter(&self) -> &str {
        &self.adapter
    }

    /// The name and version of the adapter's driver.
    #[getter]
    fn driver(&self) -> &str {
        &self.driver
    }

    /// Whether the adapter runs on the CPU.
    #[getter]
    fn is_software(&self) -> bool {
        self.is_software
    }

    /// Renders a stereo pair of a scene as it is now.
    ///
    /// The first call with a scene builds its tree and brings it to the device; later ones bring what has changed.
    /// ``progress`` is called with the name of a pass and the share of the frame's rows that are done, 0 to 1, as
    /// rows get done; what it raises ends the frame and is raised here, as is a ``KeyboardInterrupt``. It must not
    /// call this renderer, which is at work until the frame is done, nor change the scene. The options are
    /// keywords:
    ///
    /// - ``method``: how the right view is made, one of ``METHODS``; ``"auto"`` where nothing is said. ``"naive"``
    ///   traces both views; ``"bracket-rays"`` shows the same for less, and ``"bracket"`` takes over shadows too.
    /// - ``outputs``: the arrays that come back, a list of names of ``OUTPUTS`` or one name; ``["color", "depth",
    ///   "disparity"]`` where nothing is said. ``View`` says what each is.
    /// - ``samples``: samples a pixel: 1, 4, 9, 16, 25, 36, 49 or 64; 1 where nothing is said. Depths, ids and ground
    ///   truth stay those of one ray through the pixel's centre.
    /// - ``filter``: how samples are weighed: ``"box"``, ``"tent"`` or ``"gauss"``; the first where nothing is said.
    /// - ``jitter``: whether samples stand aside of the middles of their cells; ``True`` where nothing is said.
    /// - ``adaptive``: more samples only where a pixel's differ: a tuple of levels, 2 to 5, and of the tolerance in
    ///   values of a channel of the picture, 0 to 255, as ``(4, 8.0)``. ``None`` where nothing is said. With one
    ///   sample, the box filter, and the methods ``auto``, ``naive``, ``ideal`` and the brackets only.
    /// - ``bounces``: surfaces, one behind the other, that a ray may come from, 0 to 8; 5 where nothing is said.
    /// - ``shadow_rays``: rays to each light that is not a point, 1 to 32; 16 where nothing is said.
    /// - ``ambient_occlusion``: whether what stands near keeps ambient light off: a tuple of rays, 1 to 32, and of a
    ///   radius in world units, above 0, as ``(16, 0.5)``. ``None`` where nothing is said.
    /// - ``sky_rays``: by how many rays, 1 to 32, the sky lights surfaces, in place of ambient light; ``None``, by
    ///   none, where nothing is said. Not with ``ambient_occlusion``.
    /// - ``penumbra``: what a view takes over of the answers of these rays: ``"exact"``, of places that are fully lit
    ///   or not at all; ``"shared"``, penumbrae too. The latter where nothing is said.
    /// - ``seed``: of all random numbers, 0 where nothing is said. The same seed makes the same picture.
    /// - ``exposure``: by how many stops pictures are brighter than the light that scenes give, -64 to 64; 0 where
    ///   nothing is said.
    /// - ``tone``: what becomes of what is too bright: ``"clamp"`` cuts it off, ``"filmic"`` bends all towards white
    ///   along a film's curve. The first where nothing is said.
    /// - ``noise_by_view``: whether each view has random numbers of its own; ``False`` where nothing is said.
    /// - ``visibility``: how the first hits of traced views are found: ``"rays"`` or ``"t-buffer"``; the same hits by
    ///   both. The first where nothing is said.
    /// - ``shadow_buffer``: whether points ask shadow-buffers which point lights they see: a tuple of the rows of a
    ///   table and of a rule, ``"object"``, ``"depth"`` or ``"hybrid"``, as ``(400, "hybrid")``. ``None`` where nothing
    ///   is said.
    /// - ``count``: whether BVH nodes and primitive tests are counted, which is slower; ``False`` where nothing is
    ///   said.
    ///
    /// Raises ``ValueError`` for options, cameras and scenes that can't be rendered, ``LimitError`` for what is larger
    /// than the adapter allows or has memory for, ``DeviceLostError`` where the device went away, and
    /// ``AdapterError`` where its driver refused something.
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

    /// Renders the views of several eyes on one line, which look through the same screen.
    ///
    /// ``eyes`` is their number, 1 to 1024, an interaxial between neighbours and the camera's midpoint in their middle;
    /// or their offsets from that midpoint in interaxials, to the right. Some views are traced, and each other one
    /// is made from the nearest of these: ``traced`` are their indices; where nothing is said the library chooses.
    /// ``progress`` and the options are those of ``render``; ground truth (``distance``, ``occlusion``, ``normal``,
    /// ``geometric_normal`` and ``material``) and disparities are of pairs alone.
    ///
    /// Raises what ``render`` raises, and ``ValueError`` for ground truth among the outputs, for no eyes or too many,
    /// two in one place, several that are toed in, and indices that are no eyes.
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
        let request = Request::of_rig(options)?;
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

    /// A random camera in the free space of a scene, like ``camera`` but elsewhere: a tuple of the camera and of how
    /// many were tried for it. It follows from the scene, the camera, the ``seed`` and the number ``item`` alone.
    ///
    /// A camera within the scene's bounds becomes one anywhere in them, looking anywhere, at most 23 degrees up or
    /// down; one outside of them stays as far from their middle, and looks at what is there. Rejected are cameras
    /// inside of something, those whose eyes don't see each other, and:
    ///
    /// - with a surface nearer than ``clearance`` to the midpoint between the eyes, in world units; twice the
    ///   interaxial where nothing is said;
    /// - with disparities, before or behind the screen, of ``max_disparity`` pixels or more; none are too large where
    ///   nothing is said;
    /// - whose left picture shows surfaces on less than ``min_surfaces`` of it, 0 to 1; where nothing is said a half
    ///   within a scene, and a tenth of what is seen from outside.
    ///
    /// Raises ``ValueError`` where 2000 cameras were all rejected, with the reasons, and for a scene that is empty or
    /// has only infinite planes; else what ``render`` raises.
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

    /// The nearest hit of each of n rays: a tuple of two arrays of shape ``(n,)``.
    ///
    /// ``origins`` are world positions, ``(n, 3)`` or one for all, ``(1, 3)``; ``directions`` are ``(n, 3)``, of any
    /// length but 0. The first array, float32, is t: the point is ``origin + t * direction``; infinite where
    /// nothing is hit. The second one, uint32, is the id of the primitive, or ``MISS``. Rays that are neighbours in
    /// the list are traced together: the more alike they are, the faster. Raises ``ValueError`` for a ray without
    /// direction and for numbers of rays that don't fit; else what ``render`` raises.
    fn closest_hits<'py>(
        &self,
        py: Python<'py>,
        scene: &Scene,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
    ) -> PyResult<Hits<'py>> {
        let (origins, directions) =
            (values::world_points("origins", origins)?, values::points("directions", directions)?);
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

    /// Builds a scene's tree and brings it to the device, which ``render`` does by itself.
    ///
    /// ``build`` says how much time goes into the tree: ``"fast"``, ``"balanced"``, as by ``render``, or ``"best"``,
    /// for a scene that many pictures are made of. Where objects of the scene move later the tree keeps its shape;
    /// where it can't, it is built anew as ``"balanced"``. Raises ``ValueError`` for another name and for a scene
    /// that can't be rendered; else what ``render`` raises.
    #[pyo3(signature = (scene, *, build = "balanced"))]
    fn upload(&self, py: Python<'_>, scene: &Scene, build: &str) -> PyResult<()> {
        let build = match build {
            "fast" => BvhBuild::Fast,
            "balanced" => BvhBuild::Balanced,
            "best" => BvhBuild::Best,
            other => return Err(refused(format!("build: '{other}' is none; there are fast, balanced and best"))),
        };
        let (inner, state) = (&scene.inner, scene.state);
        self.with_stage(py, |stage| {
            let uploaded = stage.renderer.upload_with(inner, build)?;
            stage.scenes.retain(|(known, _)| !known.is_of_scene(state));
            stage.make_room();
            stage.scenes.push((state, uploaded));
            Ok(())
        })
    }

    /// Lets go of a scene on the device, where it stands there. The next frame that asks for it brings it again.
    fn release(&self, py: Python<'_>, scene: &Scene) -> PyResult<()> {
        let state = scene.state;
        self.with_stage(py, |stage| {
            stage.scenes.retain(|(known, _)| !known.is_of_scene(state));
            Ok(())
        })
    }

    fn __repr__(&self) -> String {
        format!("Renderer({}, {})", self.adapter, self.driver)
    }
}
