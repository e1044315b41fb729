//! The renderer: a device, and the scenes uploaded to it.

use std::{
    cell::{Cell, RefCell},
    ops::AsyncFnMut,
    rc::Rc,
    time::Duration,
};

use futures_util::lock::Mutex;
use stereotrace::{BvhBuild, Error, Gpu, Report, ReportPlan, Rig, Update, UploadedScene};
use wasm_bindgen::prelude::*;

use crate::{
    camera,
    errors::{raised, refused},
    options::Request,
    pair::Pair,
    passes::Passes,
    scene::{Changes, Scene, Shared},
    views::Views,
};

thread_local! {
    /// Number of devices opened so far, which identifies them.
    static DEVICES: Cell<u64> = const { Cell::new(0) };
    static COMMON: RefCell<Option<Renderer>> = const { RefCell::new(None) };
}

/// Renders pairs and views. It keeps the device, kernels and uploaded scenes from picture to picture. Concurrent
/// requests are rendered one after the other.
#[wasm_bindgen]
#[derive(Clone)]
pub struct Renderer {
    device: Rc<Mutex<Option<Device>>>,
    lost: Rc<Cell<u32>>,
}

/// An open device.
struct Device {
    renderer: stereotrace::Renderer,
    id: u64,
}

/// A scene on a device.
pub(crate) struct Uploaded {
    scene: UploadedScene,
    device: u64,
    changes: Changes,
}

#[wasm_bindgen]
impl Renderer {
    /// Makes a renderer on the adapter that the browser offers. The device is opened when it is first needed.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self { device: Rc::default(), lost: Rc::default() }
    }

    /// Renders a pair. The default camera is the scene's own, at 640x480.
    ///
    /// Rejects with an error. Its `name` is:
    ///
    /// - `NoAdapterError` if the browser has no WebGPU or no adapter;
    /// - `LimitError` if the picture or scene exceeds the adapter's limits;
    /// - `DeviceLostError` if the device was lost twice;
    /// - `TypeError` for a wrong field. The message names the value.
    ///
    /// If `options.signal` was aborted, it rejects with the signal's reason, by default an `AbortError`.
    #[wasm_bindgen(unchecked_return_type = "Pair")]
    pub async fn render(
        &self,
        scene: &Scene,
        #[wasm_bindgen(unchecked_optional_param_type = "Camera")] camera: JsValue,
        #[wasm_bindgen(unchecked_optional_param_type = "RenderOptions")] options: JsValue,
    ) -> Result<Pair, JsValue> {
        let camera =
            if camera.is_undefined() || camera.is_null() { scene.own_camera(640, 480)? } else { camera::read(camera)? };
        let request = Request::read(options)?;
        let frame = async |renderer: &mut stereotrace::Renderer, uploaded: &UploadedScene| {
            renderer
                .pair(uploaded, &camera)
                .options(&request.options)
                .progress(&mut |now| request.goes_on(now))
                .read()
                .await
        };
        Ok(Pair(self.with_scene(&request, &scene.shared, frame).await?))
    }

    /// Renders one more pass of a pair, and returns the mean of all passes. They must have the same scene, camera and
    /// options, except `exposure`, `tone` and the number of paths, which is the pass's weight; otherwise it rejects
    /// with a `TypeError`. A pass that is aborted while it is traced leaves the earlier ones as they are. Rejects as
    /// `render` does.
    #[wasm_bindgen(js_name = addTo, unchecked_return_type = "Pair")]
    pub async fn add_to(
        &self,
        passes: &Passes,
        scene: &Scene,
        #[wasm_bindgen(unchecked_param_type = "Camera")] camera: JsValue,
        #[wasm_bindgen(unchecked_optional_param_type = "RenderOptions")] options: JsValue,
    ) -> Result<Pair, JsValue> {
        let (camera, request) = (camera::read(camera)?, Request::read(options)?);
        let mut all = passes.all.lock().await;
        let frame = async |renderer: &mut stereotrace::Renderer, uploaded: &UploadedScene| {
            renderer
                .pair(uploaded, &camera)
                .options(&request.options)
                .progress(&mut |now| request.goes_on(now))
                .add_to(&mut all)
                .await
        };
        let pair = self.with_scene(&request, &scene.shared, frame).await;
        passes.tell(&all);
        Ok(Pair(pair?))
    }

    /// Returns an exposure in stops, for the option `exposure`, by which a scene's picture is neither dark nor burnt.
    /// It is 0 if no change is needed. Rejects as `render` does.
    #[wasm_bindgen(js_name = suggestExposure)]
    pub async fn suggest_exposure(
        &self,
        scene: &Scene,
        #[wasm_bindgen(unchecked_param_type = "Camera")] camera: JsValue,
        #[wasm_bindgen(unchecked_optional_param_type = "RenderOptions")] options: JsValue,
    ) -> Result<f32, JsValue> {
        let (camera, request) = (camera::read(camera)?, Request::read(options)?);
        let stops = async |renderer: &mut stereotrace::Renderer, uploaded: &UploadedScene| {
            renderer.suggest_exposure(uploaded, &camera, &request.options).await
        };
        self.with_scene(&request, &scene.shared, stops).await
    }

    /// Renders a row of `count` eyes from left to right. Neighbours are one interaxial apart, and the camera is in
    /// their middle. Few views are traced, and the others are made from them. Rejects as `render` does.
    #[wasm_bindgen(unchecked_return_type = "Views")]
    pub async fn views(
        &self,
        scene: &Scene,
        #[wasm_bindgen(unchecked_param_type = "Camera")] camera: JsValue,
        count: u32,
        #[wasm_bindgen(unchecked_optional_param_type = "RenderOptions")] options: JsValue,
    ) -> Result<Views, JsValue> {
        let rig = Rig::row(camera::read(camera)?, count as usize);
        let request = Request::read(options)?;
        let frame = async |renderer: &mut stereotrace::Renderer, uploaded: &UploadedScene| {
            renderer
                .views(uploaded, &rig)
                .options(&request.options)
                .progress(&mut |now| request.goes_on(now))
                .read()
                .await
        };
        Ok(Views(self.with_scene(&request, &scene.shared, frame).await?))
    }

    /// Measures the device with built-in scenes and all methods. Larger sizes are left out if the report would take
    /// more than so many seconds, 60 by default. Returns it as an HTML page, which contains the figures as JSON in the
    /// element `report`. Of the options, `signal` and `onProgress` apply. Rejects as `render` does.
    pub async fn report(
        &self,
        seconds: Option<f64>,
        #[wasm_bindgen(unchecked_optional_param_type = "RenderOptions")] options: JsValue,
    ) -> Result<String, JsValue> {
        let request = Request::read(options)?;
        let mut plan = ReportPlan::default();
        if let Some(seconds) = seconds {
            plan.most = Duration::try_from_secs_f64(seconds).map_err(|error| refused(&format!("seconds: {error}")))?;
        }
        let mut slot = self.device.lock().await;
        let device = opened(&mut slot).await.map_err(raised)?;
        let report = Report::measure(device.renderer.gpu(), &plan, &mut |now| request.goes_on(now)).await;
        Ok(report.map_err(|error| request.raised(error))?.to_html())
    }

    /// Builds a scene's tree and uploads it. `render` does so by itself if needed.
    pub async fn upload(&self, scene: &Scene) -> Result<(), JsValue> {
        let nothing = async |_: &mut stereotrace::Renderer, _: &UploadedScene| Ok(());
        self.with_scene(&Request::default(), &scene.shared, nothing).await
    }

    /// Forgets the samples of earlier frames, which the option `history` keeps. The next frame depends on no other.
    pub async fn forget(&self) {
        if let Some(device) = self.device.lock().await.as_mut() {
            device.renderer.forget();
        }
    }

    /// Number of times that the device was lost.
    #[wasm_bindgen(getter, js_name = devicesLost)]
    pub fn devices_lost(&self) -> u32 {
        self.lost.get()
    }
}

impl Renderer {
    /// Returns the renderer that all calls of the function `render` share.
    pub(crate) fn common() -> Self {
        COMMON.with_borrow_mut(|common| common.get_or_insert_with(Self::new).clone())
    }

    /// Runs work with a scene on the device. If the device is lost, it is opened again once, and the work starts anew.
    async fn with_scene<T>(
        &self,
        request: &Request,
        scene: &Shared,
        mut work: impl AsyncFnMut(&mut stereotrace::Renderer, &UploadedScene) -> Result<T, Error>,
    ) -> Result<T, JsValue> {
        let mut slot = self.device.lock().await;
        let mut again = false;
        loop {
            match attempt(&mut slot, scene, &mut work).await {
                Err(Error::DeviceLost(reason)) => {
                    *slot = None;
                    self.lost.set(self.lost.get() + 1);
                    if again {
                        return Err(raised(Error::DeviceLost(reason)));
                    }
                    log::warn!("the graphics device was lost ({reason}); opening it again");
                    again = true;
                }
                done => return done.map_err(|error| request.raised(error)),
            }
        }
    }
}

impl Device {
    async fn open() -> Result<Self, Error> {
        let renderer = stereotrace::Renderer::new(Gpu::new().await?);
        Ok(Self { renderer, id: DEVICES.replace(DEVICES.get() + 1) })
    }
}

/// Returns the device, which is opened when it is first needed.
async fn opened(slot: &mut Option<Device>) -> Result<&mut Device, Error> {
    match slot {
        Some(device) => Ok(device),
        None => Ok(slot.insert(Device::open().await?)),
    }
}

async fn attempt<T>(
    slot: &mut Option<Device>,
    scene: &Shared,
    work: &mut impl AsyncFnMut(&mut stereotrace::Renderer, &UploadedScene) -> Result<T, Error>,
) -> Result<T, Error> {
    let device = opened(slot).await?;
    let uploaded = brought(device, scene).await?;
    let done = work(&mut device.renderer, &uploaded.scene).await;
    scene.uploaded.replace(Some(uploaded));
    done
}

/// Uploads the scene's current state, or updates what is on the device.
async fn brought(device: &Device, scene: &Shared) -> Result<Uploaded, Error> {
    let (now, changes) = (scene.scene(), scene.changes.get());
    let renderer = &device.renderer;
    // The upload is taken out, so that a scene is uploaded anew after an update that failed.
    match scene.uploaded.take().filter(|uploaded| uploaded.device == device.id) {
        None => {
            let uploaded = renderer.upload(&now).await?;
            Ok(Uploaded { scene: uploaded, device: device.id, changes })
        }
        Some(mut uploaded) => {
            if uploaded.changes != changes {
                let same_shapes = uploaded.changes.shapes == changes.shapes;
                let how = if same_shapes { Update::Refit } else { Update::Rebuild(BvhBuild::Balanced) };
                renderer.update(&mut uploaded.scene, &now, how).await?;
                uploaded.changes = changes;
            }
            Ok(uploaded)
        }
    }
}
