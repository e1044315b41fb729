//! The renderer: a device, and the scenes uploaded to it.

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
    Adapter, BvhBuild, Calibration, Channel, Error, Gpu, GroundTruth, Layering, Maker, Moment, Progress, Ray, Rig,
    Update, UploadedScene, blocking::Wait, dataset::FreePoses,
};

use crate::{
    camera::Camera,
    correspondence::Correspondence,
    errors::{raised, refused},
    flow::Flow,
    layers::Layers,
    options::Request,
    pair::{Frame, RigFrame, StereoPair, Views},
    passes::Passes,
    scene::{Scene, State},
    values,
};

/// Default number of scenes that stay on the device.
const KEPT_SCENES: usize = 4;

/// Arrays of t and of the primitive id, for each ray.
type Hits<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<u32>>);

/// A graphics device that renders, and the scenes uploaded to it.
///
/// ``Renderer()`` opens the adapter that the environment variable ``STEREOTRACE_ADAPTER`` names, or else the fastest.
/// ``adapter`` selects another: ``"fastest"``, ``"software"`` for one that runs on the CPU, or a part of an adapter's
/// name. ``kept_scenes`` is the number of most recently used scenes that stay on the device. Default 4. With
/// ``ray_queries``, rays are traced by the adapter's ray queries, in hardware where it has some. They are experimental.
///
/// Several threads may use one renderer. It renders one frame after the other, without Python's lock. Raises
/// ``AdapterError`` if no such adapter is found, or if it has no ray queries.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct Renderer {
    stage: Mutex<Stage>,
    /// Thread that uses the renderer now.
    at_work: Mutex<Option<ThreadId>>,
    adapter: String,
    driver: String,
    is_software: bool,
}

/// Locks a mutex. The values stay whole if another thread panics, so poisoning is ignored.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Id of the process that opened the first device; 0 before that.
static OPENED_BY: AtomicU32 = AtomicU32::new(0);

/// Refuses to run in a child forked from a process that had opened a device. Drivers don't survive a fork: any use of a
/// device, even of a new one, would wait for ever.
fn check_process() -> PyResult<()> {
    match OPENED_BY.load(Ordering::Relaxed) {
        opened_by if opened_by == 0 || opened_by == process::id() => Ok(()),
        _ => Err(PyRuntimeError::new_err(
            "this process was forked from one that had opened a graphics device, which drivers do not support: start \
             processes by spawn, as multiprocessing.get_context('spawn') does, or do not render before the fork",
        )),
    }
}

/// Marks a thread's use of a renderer until it is dropped.
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

/// State that one thread uses at a time.
struct Stage {
    renderer: stereotrace::Renderer,
    /// Scenes on the device, with the most recently used at the end.
    scenes: Vec<(State, UploadedScene)>,
    kept: usize,
}

impl Stage {
    /// Drops the least recently used scene if the list is full.
    fn make_room(&mut self) {
        if self.scenes.len() >= self.kept {
            self.scenes.remove(0);
        }
    }

    /// Uploads or updates a scene, and moves it to the end of the list.
    fn bring(&mut self, scene: &stereotrace::Scene, state: State) -> Result<(), Error> {
        let place = self.scenes.iter().position(|(known, _)| known.is_of_scene(state));
        let Some(place) = place else {
            self.make_room();
            let uploaded = self.renderer.upload(scene).wait()?;
            self.scenes.push((state, uploaded));
            return Ok(());
        };
        let (known, mut uploaded) = self.scenes.remove(place);
        if known != state {
            // Moved objects keep their tree if possible. Changes of lights and materials alone keep it too.
            if self.renderer.update(&mut uploaded, scene, Update::Refit).wait().is_err() {
                uploaded = self.renderer.upload(scene).wait()?;
            }
        }
        self.scenes.push((state, uploaded));
        Ok(())
    }
}

impl Renderer {
    /// Runs work on the device without Python's lock, once no other thread uses it.
    ///
    /// # Errors
    /// If this thread uses the renderer already and now runs a callback or a signal handler: it would wait for itself.
    fn with_stage<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Stage) -> Result<T, Error> + Send,
    ) -> PyResult<T> {
        check_process()?;
        let this = thread::current().id();
        if *lock(&self.at_work) == Some(this) {
            let reason = "this renderer is busy with a picture, whose callback requests another: use another renderer";
            return Err(PyRuntimeError::new_err(reason));
        }
        let done = py.detach(|| {
            let mut stage = lock(&self.stage);
            let _at_work = AtWork::begin(&self.at_work, this);
            work(&mut stage)
        });
        done.map_err(raised)
    }

    /// Renders a frame of a scene without Python's lock. Between bands of rows, Python handles signals and calls
    /// `progress`.
    fn work<T: Send>(
        &self,
        py: Python<'_>,
        scene: &Scene,
        progress: Option<Py<PyAny>>,
        work: impl Send
        + FnOnce(&mut stereotrace::Renderer, &UploadedScene, &mut stereotrace::OnProgress<'_>) -> Result<T, Error>,
    ) -> PyResult<T> {
        let (inner, state) = (&scene.inner, scene.state);
        self.watched(py, progress, |stage, progress| {
            stage.bring(inner, state)?;
            let Stage { renderer, scenes, .. } = stage;
            let Some((_, uploaded)) = scenes.last() else { unreachable!("a scene was brought") };
            work(renderer, uploaded, progress)
        })
    }

    /// Does work on the device as [`Renderer::work`] does, without a scene.
    pub(crate) fn work_alone<T: Send>(
        &self,
        py: Python<'_>,
        work: impl Send + FnOnce(&mut stereotrace::Renderer, &mut stereotrace::OnProgress<'_>) -> Result<T, Error>,
    ) -> PyResult<T> {
        self.watched(py, None, |stage, progress| work(&mut stage.renderer, progress))
    }

    fn watched<T: Send>(
        &self,
        py: Python<'_>,
        progress: Option<Py<PyAny>>,
        work: impl Send + FnOnce(&mut Stage, &mut stereotrace::OnProgress<'_>) -> Result<T, Error>,
    ) -> PyResult<T> {
        let mut stopped = None;
        let done = self.with_stage(py, |stage| {
            work(stage, &mut |now: Progress| {
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
        // An exception that stopped the frame is the error to raise.
        stopped.map_or(done, Err)
    }
}

/// Returns the numbers of a calibration.
fn numbers_of(calibration: Calibration) -> (f32, f32, f32) {
    (calibration.ray_seconds, calibration.search, calibration.shadow)
}

#[pymethods]
impl Renderer {
    #[new]
    #[pyo3(signature = (adapter = None, *, kept_scenes = KEPT_SCENES, ray_queries = false))]
    fn new(py: Python<'_>, adapter: Option<String>, kept_scenes: usize, ray_queries: bool) -> PyResult<Self> {
        if kept_scenes == 0 {
            return Err(refused("kept_scenes: it must be 1 or more"));
        }
        let adapter = match adapter.as_deref() {
            None => Adapter::FromEnv,
            Some("fastest") => Adapter::Fastest,
            Some(name) => Adapter::from(name),
        };
        check_process()?;
        let open = || match ray_queries {
            true => Gpu::open_with_ray_queries(adapter).wait(),
            false => Gpu::open(adapter).wait(),
        };
        let gpu = py.detach(open).map_err(raised)?;
        OPENED_BY.store(process::id(), Ordering::Relaxed);
        let (name, driver) = (gpu.adapter_name(), gpu.driver());
        let is_software = gpu.adapter_info().device_type == stereotrace::wgpu::DeviceType::Cpu;
        let renderer = stereotrace::Renderer::new(gpu);
        let stage = Mutex::new(Stage { renderer, scenes: Vec::new(), kept: kept_scenes });
        Ok(Self { stage, at_work: Mutex::default(), adapter: name, driver, is_software })
    }

    /// Name of the adapter.
    #[getter]
    fn adapter(&self) -> &str {
        &self.adapter
    }

    /// Name and version of the adapter's driver.
    #[getter]
    fn driver(&self) -> &str {
        &self.driver
    }

    /// Whether the adapter runs on the CPU.
    #[getter]
    fn is_software(&self) -> bool {
        self.is_software
    }

    /// Renders a stereo pair of a scene's current state.
    ///
    /// The first call with a scene builds its tree and uploads it. Later calls upload changes. ``progress`` is called
    /// with the name of a pass and the share of finished rows, 0 to 1. An exception from it, or a
    /// ``KeyboardInterrupt``, ends the frame and is raised here. ``progress`` must neither call this renderer nor
    /// change the scene. With ``passes``, the call renders one more pass, and returns the mean of all passes. The
    /// options are keywords:
    ///
    /// - ``method``: how the right view is made, one of ``METHODS``. ``"naive"`` traces both views; ``"bracket-rays"``
    ///   makes the same picture for less, and ``"bracket"`` reuses visibility bits too. Default ``"auto"``.
    /// - ``outputs``: arrays to return, a list of names of ``OUTPUTS`` or one name. ``View`` describes them. Default
    ///   ``["color", "depth", "disparity"]``.
    /// - ``samples``: samples per pixel, for antialiasing: 1, 4, 9, 16, 25, 36, 49 or 64. Depths, ids and ground truth
    ///   still belong to one ray through the pixel's centre. Default 1.
    /// - ``filter``: weights of samples: ``"box"``, ``"tent"`` or ``"gauss"``. Default ``"box"``.
    /// - ``jitter``: whether to jitter the sample grid. Default ``True``.
    /// - ``adaptive``: adaptive antialiasing: a tuple of levels, 2 to 5, and a tolerance in 8-bit values, 0 to 255,
    ///   such as ``(4, 8.0)``. Only with one sample, the box filter, and the methods ``auto``, ``naive``, ``ideal`` and
    ///   the bracket methods. Default ``None``.
    /// - ``lighting``: light that reaches surfaces by other surfaces: ``"direct"``, none but in mirrors and glass; or
    ///   ``"paths"``, ``"paths=SAMPLES"`` or ``"paths=SAMPLES:BOUNCES"``, global illumination by path tracing with 1 to
    ///   4096 paths per pixel (default 64) and 0 to 32 bounces (default 8). Default ``"direct"``.
    /// - ``denoise``: whether to remove noise from light by paths, for pictures to look at. Not with ``adaptive``.
    ///   Default ``False``.
    /// - ``bounces``: maximum number of reflections and refractions along a ray, 0 to 8. Default 5.
    /// - ``shadow_rays``: rays to each light that is not a point, 1 to 32. Default 16.
    /// - ``ambient_occlusion``: a tuple of rays, 1 to 32, and the radius for occluders in world units, above 0, such as
    ///   ``(16, 0.5)``. Default ``None``.
    /// - ``sky_rays``: number of rays, 1 to 32, by which the sky lights surfaces, in place of ambient light. Not with
    ///   ``ambient_occlusion``. Default ``None``: the sky lights nothing.
    /// - ``penumbra``: which results of soft shadow rays a view reuses: ``"exact"``, only of points that are fully lit
    ///   or fully shadowed; ``"shared"``, of penumbrae too. Default ``"shared"``.
    /// - ``seed``: seed of all random numbers. The same seed makes the same picture. Default 0.
    /// - ``exposure``: exposure in stops, -64 to 64. Default 0.
    /// - ``tone``: tone mapping: ``"clamp"`` clamps values above 1, ``"filmic"`` maps all values by a filmic curve.
    ///   Default ``"clamp"``.
    /// - ``noise_by_view``: whether each view has its own random numbers. Default ``False``.
    /// - ``visibility``: how traced views find their closest hits: ``"rays"`` or ``"t-buffer"``, with the same result.
    ///   Default ``"rays"``.
    /// - ``shadow_buffer``: shadow buffers in place of shadow rays to point lights: a tuple, such as
    ///   ``(400, "hybrid")``. It has the number of rows of a table, and a rule: ``"object"``, ``"depth"`` or
    ///   ``"hybrid"``. Default ``None``.
    /// - ``history``: memory for samples of earlier frames in MiB. The next frame of the same scene and size finds the
    ///   same first hits by them, and recalls the visibility of lights and the light of paths. Default ``None``.
    /// - ``count``: whether to count BVH nodes and primitive tests, which is slower. Default ``False``.
    ///
    /// Raises ``ValueError`` for invalid options, cameras and scenes. Raises ``LimitError`` if the picture or scene
    /// exceeds the adapter's limits or memory. Raises ``DeviceLostError`` if the device was lost, and ``AdapterError``
    /// for other errors of its driver.
    #[pyo3(signature = (scene, camera, *, passes = None, progress = None, **options))]
    fn render(
        &self,
        py: Python<'_>,
        scene: &Scene,
        camera: Camera,
        passes: Option<&Passes>,
        progress: Option<Py<PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<StereoPair> {
        let request = Request::of(options)?;
        let wants_truth = request.needs_ground_truth();
        let (pair, truth) = Passes::lent(passes, |passes| {
            self.work(py, scene, progress, |renderer, uploaded, progress| {
                let frame = renderer.pair(uploaded, &camera.0).options(&request.options).progress(progress);
                let pair = match passes {
                    None => frame.read().wait(),
                    Some(passes) => frame.add_to(passes).wait(),
                }?;
                let truth = wants_truth.then(|| renderer.ground_truth(uploaded, &scene.inner, &pair).wait());
                Ok::<(_, Option<GroundTruth>), Error>((pair, truth.transpose()?))
            })
        })?;
        StereoPair::of(py, Frame { pair, truth, camera, request })
    }

    /// Returns an exposure in stops, for the option ``exposure``, by which the picture is neither dark nor burnt.
    ///
    /// It is 0 if no change is needed. Small pictures of both eyes are rendered under the light of the options, which
    /// are those of ``render``. Exposed, their geometric mean is from 0.12 to 0.5, and at most a tenth of them is
    /// brighter than white. Raises as ``render`` does.
    #[pyo3(signature = (scene, camera, **options))]
    fn suggest_exposure(
        &self,
        py: Python<'_>,
        scene: &Scene,
        camera: Camera,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<f32> {
        let request = Request::of(options)?;
        self.work(py, scene, None, |renderer, uploaded, _| {
            renderer.suggest_exposure(uploaded, &camera.0, &request.options).wait()
        })
    }

    /// Renders the views of several eyes on one line behind one screen.
    ///
    /// ``eyes`` is either their number, 1 to 1024, or a list of offsets. With a number, neighbours are one interaxial
    /// apart and the camera's midpoint is in their middle. Offsets count from that midpoint to the right, in
    /// interaxials. The views with the indices ``traced`` are traced; by default the library chooses them. Each other
    /// view is made from the nearest traced one. ``passes``, ``progress`` and the options are those of ``render``.
    /// Ground truth (``distance``, ``occlusion``, ``normal``, ``geometric_normal`` and ``material``) and disparities
    /// are only available for pairs.
    ///
    /// Raises as ``render`` does. Also raises ``ValueError`` for ground truth among the outputs, for no eyes or over
    /// 1024, and for two eyes in one place. Several toed-in eyes and indices out of range raise it too.
    #[pyo3(signature = (scene, camera, eyes, *, traced = None, passes = None, progress = None, **options))]
    #[expect(clippy::too_many_arguments, reason = "Python's keywords")]
    fn render_views(
        &self,
        py: Python<'_>,
        scene: &Scene,
        camera: Camera,
        eyes: &Bound<'_, PyAny>,
        traced: Option<Vec<usize>>,
        passes: Option<&Passes>,
        progress: Option<Py<PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Views> {
        let request = Request::of_rig(options)?;
        let rig = match (eyes.extract::<usize>(), eyes.extract::<Vec<f32>>()) {
            (Ok(count), _) => Rig::row(camera.0, count),
            (_, Ok(offsets)) => Rig::at(camera.0, offsets),
            _ => {
                return Err(refused(format!(
                    "eyes: {} must be a number of eyes, or their offsets in interaxials",
                    values::shown(eyes)
                )));
            }
        };
        let rig = match traced {
            Some(views) => rig.traced(views),
            None => rig,
        };
        let views = Passes::lent(passes, |passes| {
            self.work(py, scene, progress, |renderer, uploaded, progress| {
                let frame = renderer.views(uploaded, &rig).options(&request.options).progress(progress);
                match passes {
                    None => frame.read().wait(),
                    Some(passes) => frame.add_to(passes).wait(),
                }
            })
        })?;
        Views::of(py, RigFrame { views, camera, request })
    }

    /// Finds a random camera in the free space of a scene, with the properties of ``camera``. Returns a tuple of the
    /// camera and the number of tries. The result depends only on the scene, the camera, ``seed`` and ``item``.
    ///
    /// If ``camera`` is within the scene's bounds, the result is anywhere in them and looks in any direction, at most
    /// 23 degrees up or down. If it is outside, the result keeps its distance from their middle and looks at the scene.
    /// Cameras are rejected if they are inside an object, if their eyes don't see each other, and
    ///
    /// - if a surface is nearer than ``clearance`` to the midpoint between the eyes, in world units. Default twice the
    ///   interaxial;
    /// - if a disparity, before or behind the screen, is ``max_disparity`` pixels or more. Default no limit;
    /// - if surfaces cover less than the share ``min_surfaces`` of the left picture, 0 to 1. Default 0.5 within the
    ///   scene's bounds, 0.1 outside.
    ///
    /// Raises ``ValueError`` with the reasons if 2000 cameras were all rejected, and for a scene that is empty or has
    /// only infinite planes. Else raises as ``render`` does.
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
            poses.find(renderer, uploaded, item).wait()
        })?;
        Ok((Camera(found.camera), found.tries))
    }

    /// Computes where the points of a pair are at another time, and returns a ``Flow``.
    ///
    /// ``pair`` is a picture of ``scene``, with ``"primitive"`` among its outputs. ``then`` is the same scene at the
    /// other time: a copy whose objects have moved, or ``scene`` itself if only the camera moves. ``Scene.pose``,
    /// ``Scene.transform_object`` and ``Scene.set_mesh`` move objects. ``camera`` is the camera at the other time; by
    /// default it stays. A point keeps its place on its primitive. All values are computed in double precision.
    ///
    /// Raises ``ValueError`` if the scenes differ in more than positions, and for toed-in eyes. Also raises it for a
    /// pair without ids, or by a method that copies pixels. Else raises as ``render`` does.
    #[pyo3(signature = (pair, scene, then, camera = None))]
    fn flow(
        &self,
        py: Python<'_>,
        pair: &StereoPair,
        scene: &Scene,
        then: &Scene,
        camera: Option<Camera>,
    ) -> PyResult<Flow> {
        let frame = pair.frame.clone();
        if frame.pair.left.primitive.is_empty() {
            return Err(refused("flow needs ids: name 'primitive' in outputs when the pair is rendered"));
        }
        let camera = camera.map_or(frame.camera.0, |camera| camera.0);
        let now = &scene.inner;
        let flow = self.work(py, then, None, |renderer, uploaded, _| {
            let then = Moment { scene: &then.inner, uploaded, camera: &camera };
            renderer.flow(&frame.pair, now, then).wait()
        })?;
        Ok(Flow::of(flow))
    }

    /// Computes where the other eye's picture shows the point of each pixel of a pair, and whether that eye sees the
    /// point. Returns a ``Correspondence``.
    ///
    /// ``pair`` is a picture of ``scene``, with ``"depth"`` among its outputs. Places have two dimensions, since lenses
    /// with distortion and toed-in eyes move points out of their rows. Other pairs have correspondences too. All places
    /// are computed in double precision. Raises ``ValueError`` for a pair without depths. Else raises as ``render``
    /// does.
    #[pyo3(signature = (pair, scene))]
    fn correspondence(&self, py: Python<'_>, pair: &StereoPair, scene: &Scene) -> PyResult<Correspondence> {
        let frame = pair.frame.clone();
        if frame.pair.left.depth.is_empty() {
            return Err(refused("correspondence needs depths: name 'depth' in outputs when the pair is rendered"));
        }
        let found =
            self.work(py, scene, None, |renderer, uploaded, _| renderer.correspondence(uploaded, &frame.pair).wait())?;
        Ok(Correspondence::of(found))
    }

    /// Returns two of the ``Views`` of ``render_views`` as a ``StereoPair`` with ground truth. ``left`` and ``right``
    /// are their indices. ``scene`` is the scene that they show. ``"primitive"`` must be among the views' outputs.
    ///
    /// With ``below``, ``left`` is the index of an upper view, and ``right`` of a view of ``below``. These are views of
    /// the same rig, lowered by ``Camera.raised``. All pictures and arrays are then turned counterclockwise by 90
    /// degrees, so that rows are epipolar lines: pixel ``[row, column]`` of a turned picture is pixel
    /// ``[column, width - 1 - row]`` of the view.
    ///
    /// Raises ``ValueError`` for views that are not there, not side by side, or not one above the other. Else raises as
    /// ``render`` does.
    #[pyo3(signature = (views, scene, left, right, *, below = None))]
    fn pair_of(
        &self,
        py: Python<'_>,
        views: &Views,
        scene: &Scene,
        left: usize,
        right: usize,
        below: Option<&Views>,
    ) -> PyResult<StereoPair> {
        let frame = &views.frame;
        let pair = match below {
            None => frame.views.pair(left, right),
            Some(below) => frame.views.pair_below(left, (&below.frame.views, right)),
        };
        let pair = pair.map_err(raised)?;
        if pair.left.primitive.is_empty() || pair.right.primitive.is_empty() {
            return Err(refused("ground truth needs ids: name 'primitive' in outputs when the views are rendered"));
        }
        let (pair, truth) = self.work(py, scene, None, |renderer, uploaded, _| {
            let truth = renderer.ground_truth(uploaded, &scene.inner, &pair).wait()?;
            Ok((pair, truth))
        })?;
        let camera = Camera(pair.pose.camera().map_err(raised)?);
        let outputs = Channel::ALL.iter().copied().filter(|&channel| {
            frame.request.has(channel) || channel.maker() == Maker::GroundTruth || channel == Channel::Disparity
        });
        let request = Request { options: frame.request.options.clone(), outputs: outputs.collect() };
        StereoPair::of(py, Frame { pair, truth: Some(truth), camera, request })
    }

    /// Returns the ``Layers`` of a pair: all surfaces along the lines of sight through the pixels' centres, and whether
    /// the other eye sees them.
    ///
    /// ``pair`` is a picture of ``scene``, with ``"primitive"`` among its outputs. Lines pass glass, opacities below 1
    /// and holes of cut-outs. They end at the first opaque surface, or after ``surfaces`` surfaces, 1 to 32. With
    /// ``refracted`` glass bends them as it bends light, else they stay straight. With ``mirrored`` mirrors reflect
    /// them, else they end there.
    ///
    /// Raises ``ValueError`` for a number of surfaces out of range, and for toed-in eyes and lenses. Also raises it
    /// for a pair without ids, of another scene, or by a method that copies pixels. Else raises as ``render`` does.
    #[pyo3(signature = (pair, scene, surfaces = 4, *, refracted = false, mirrored = false))]
    fn layers(
        &self,
        py: Python<'_>,
        pair: &StereoPair,
        scene: &Scene,
        surfaces: u32,
        refracted: bool,
        mirrored: bool,
    ) -> PyResult<Layers> {
        let frame = pair.frame.clone();
        if frame.pair.left.primitive.is_empty() {
            return Err(refused("layers need ids: name 'primitive' in outputs when the pair is rendered"));
        }
        let layering = Layering::new(surfaces).refracted(refracted).mirrored(mirrored);
        let layers = self.work(py, scene, None, |renderer, uploaded, _| {
            renderer.layers(uploaded, &scene.inner, &frame.pair, &layering).wait()
        })?;
        Ok(Layers::of(layers))
    }

    /// Traces n rays to their closest hits. Returns a tuple of two arrays of shape ``(n,)``.
    ///
    /// ``origins`` are world positions, ``(n, 3)``, or one for all rays, ``(1, 3)``. ``directions`` are ``(n, 3)``, of
    /// any length but 0. The first array, float32, is t, where the hit is at ``origin + t * direction``; it is infinite
    /// for a miss. The second array, uint32, is the primitive's id, or ``MISS``. Neighbouring rays of the list are
    /// traced together, which is faster if they are similar. Raises ``ValueError`` for a direction of 0 and for arrays
    /// of different lengths. Else raises as ``render`` does.
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
                "origins: {} for {} directions; give one, or one per direction",
                origins.len(),
                directions.len()
            )));
        }
        let rays = directions
            .iter()
            .enumerate()
            .map(|(index, &direction)| Ray::new(origins[if origins.len() == 1 { 0 } else { index }], direction));
        let rays: Vec<Ray> = rays.collect();
        let hits =
            self.work(py, scene, None, |renderer, uploaded, _| renderer.closest_hits(uploaded, &rays).wait())?.hits;
        let (t, ids): (Vec<f32>, Vec<u32>) = hits.iter().map(|hit| (hit.t, hit.primitive)).unzip();
        Ok((PyArray1::from_vec(py, t), PyArray1::from_vec(py, ids)))
    }

    /// Builds a scene's tree and uploads it. ``render`` does so by itself if needed.
    ///
    /// ``build`` is the effort for the tree: ``"fast"``, ``"balanced"``, which ``render`` uses, or ``"best"``, for many
    /// pictures of one scene. If objects move later, the tree is refitted. If that is not possible, it is rebuilt as
    /// ``"balanced"``. Raises ``ValueError`` for another name and for an invalid scene. Else raises as ``render`` does.
    #[pyo3(signature = (scene, *, build = "balanced"))]
    fn upload(&self, py: Python<'_>, scene: &Scene, build: &str) -> PyResult<()> {
        let build = match build {
            "fast" => BvhBuild::Fast,
            "balanced" => BvhBuild::Balanced,
            "best" => BvhBuild::Best,
            other => return Err(refused(format!("build: unknown '{other}'; use fast, balanced or best"))),
        };
        let (inner, state) = (&scene.inner, scene.state);
        self.with_stage(py, |stage| {
            let uploaded = stage.renderer.upload_with(inner, build).wait()?;
            stage.scenes.retain(|(known, _)| !known.is_of_scene(state));
            stage.make_room();
            stage.scenes.push((state, uploaded));
            Ok(())
        })
    }

    /// Frees a scene's memory on the device, if it is uploaded. Rendering the scene uploads it again.
    fn release(&self, py: Python<'_>, scene: &Scene) -> PyResult<()> {
        let state = scene.state;
        self.with_stage(py, |stage| {
            stage.scenes.retain(|(known, _)| !known.is_of_scene(state));
            Ok(())
        })
    }

    /// Forgets the samples of earlier frames, which the option ``history`` keeps. The next frame depends on no other.
    fn forget(&self, py: Python<'_>) -> PyResult<()> {
        self.with_stage(py, |stage| {
            stage.renderer.forget();
            Ok(())
        })
    }

    /// Measures the adapter for the method ``auto``, which chooses by the result from now on. Returns it:
    /// (``ray_seconds``, ``search``, ``shadow``): the time of a primary ray, the cost per pixel of finding the right
    /// view's surfaces by ``bracket``, and that of a shadow ray that it saves, in primary rays.
    fn calibrate(&self, py: Python<'_>) -> PyResult<(f32, f32, f32)> {
        self.with_stage(py, |stage| stage.renderer.calibrate().wait().map(numbers_of))
    }

    /// What the method ``auto`` chooses by: (``ray_seconds``, ``search``, ``shadow``), see :meth:`calibrate`. The time
    /// is 0 if it is not measured. The result of an earlier calibration of the same adapter and driver can be set.
    #[getter]
    fn calibration(&self, py: Python<'_>) -> PyResult<(f32, f32, f32)> {
        self.with_stage(py, |stage| Ok(numbers_of(stage.renderer.calibration())))
    }

    #[setter]
    fn set_calibration(&self, py: Python<'_>, numbers: (f32, f32, f32)) -> PyResult<()> {
        let (ray_seconds, search, shadow) = numbers;
        if !(ray_seconds.is_finite() && ray_seconds >= 0.0 && search.is_finite() && shadow.is_finite() && shadow > 0.0)
        {
            return Err(refused(
                "calibration: all numbers must be finite, the time of a ray at least 0 and the last cost above 0",
            ));
        }
        self.with_stage(py, |stage| {
            stage.renderer.set_calibration(Calibration { ray_seconds, search, shadow });
            Ok(())
        })
    }

    fn __repr__(&self) -> String {
        format!("Renderer({}, {})", self.adapter, self.driver)
    }
}
