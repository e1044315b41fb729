//! Render options, which are plain objects in JavaScript.

use std::ops::ControlFlow;

use serde::Deserialize;
use stereotrace::{AmbientOcclusion, Filter, Method, Options, Progress, Tone};
use wasm_bindgen::{JsCast, JsValue};
use web_sys::AbortSignal;

use crate::{
    errors::{raised, refused},
    values,
};

/// `RenderOptions` of `types.d.ts`.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Given {
    method: Option<String>,
    samples: Option<u32>,
    filter: Option<String>,
    count: Option<bool>,
    bounces: Option<u32>,
    shadow_rays: Option<u32>,
    sky_rays: Option<u32>,
    #[serde(with = "serde_wasm_bindgen::preserve")]
    ambient_occlusion: JsValue,
    exposure: Option<f32>,
    tone: Option<String>,
    seed: Option<u32>,
    #[serde(with = "serde_wasm_bindgen::preserve")]
    signal: JsValue,
    #[serde(with = "serde_wasm_bindgen::preserve")]
    on_progress: JsValue,
}

#[derive(Deserialize)]
struct Occlusion {
    rays: u32,
    radius: f32,
}

/// The library's options, and the callbacks of a frame.
pub(crate) struct Request {
    pub(crate) options: Options,
    signal: Option<AbortSignal>,
    on_progress: Option<js_sys::Function>,
}

impl Request {
    /// Reads a plain object. Without one, all options have their defaults.
    pub(crate) fn read(value: JsValue) -> Result<Self, JsValue> {
        let given: Given = if is_nothing(&value) { Given::default() } else { values::read("options", value)? };
        let mut options = Options::default();
        if let Some(name) = given.method {
            options = options.method(values::named::<Method>(&name)?);
        }
        if let Some(name) = given.filter {
            options = options.filter(values::named::<Filter>(&name)?);
        }
        options = options.count(given.count.unwrap_or(false)).sky_rays(given.sky_rays);
        if !is_nothing(&given.ambient_occlusion) {
            let Occlusion { rays, radius } = values::read("options.ambientOcclusion", given.ambient_occlusion)?;
            options = options.occlusion(AmbientOcclusion::new(rays, radius));
        }
        options.samples = given.samples.unwrap_or(options.samples);
        options.bounces = given.bounces.unwrap_or(options.bounces);
        options.shadow_rays = given.shadow_rays.unwrap_or(options.shadow_rays);
        options.exposure = given.exposure.unwrap_or(options.exposure);
        options.seed = given.seed.unwrap_or(options.seed);
        options.tone = match given.tone.as_deref() {
            None | Some("clamp") => Tone::Clamp,
            Some("filmic") => Tone::Filmic,
            Some(_) => return Err(refused("options.tone: it must be clamp or filmic")),
        };
        options.check().map_err(raised)?;
        let (signal, on_progress) = (given.signal, given.on_progress);
        Ok(Self {
            options,
            signal: of_type(signal, "options.signal: it must be an AbortSignal")?,
            on_progress: of_type(on_progress, "options.onProgress: it must be a function")?,
        })
    }

    /// Reports progress after each band of rows, and breaks if the signal was aborted.
    pub(crate) fn goes_on(&self, progress: Progress) -> ControlFlow<()> {
        if let Some(callback) = &self.on_progress {
            // Exceptions of the callback are ignored.
            let _ = callback.call1(&JsValue::NULL, &JsValue::from(progress.done));
        }
        match self.signal.as_ref().is_some_and(AbortSignal::aborted) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

fn of_type<T: JsCast>(value: JsValue, fault: &str) -> Result<Option<T>, JsValue> {
    match is_nothing(&value) {
        true => Ok(None),
        false => value.dyn_into().map(Some).map_err(|_| refused(fault)),
    }
}

fn is_nothing(value: &JsValue) -> bool {
    value.is_undefined() || value.is_null()
}
