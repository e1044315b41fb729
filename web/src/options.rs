//! Render options, which are plain objects in JavaScript.

use std::ops::ControlFlow;

use js_sys::{Array, Object, Reflect};
use stereotrace::{Error, Options, Progress, Setting};
use wasm_bindgen::{JsCast, JsValue};
use web_sys::AbortSignal;

use crate::errors::{raised, refused};

/// The library's options, and the callbacks of a frame.
#[derive(Default)]
pub(crate) struct Request {
    pub(crate) options: Options,
    signal: Option<AbortSignal>,
    on_progress: Option<js_sys::Function>,
}

impl Request {
    /// Reads a plain object: `RenderOptions` of `types.d.ts`. Without one, all options have their defaults.
    pub(crate) fn read(value: JsValue) -> Result<Self, JsValue> {
        let mut request = Self::default();
        if is_nothing(&value) {
            return Ok(request);
        }
        let object: Object = value.dyn_into().map_err(|_| refused("options: they must be an object"))?;
        for entry in Object::entries(&object) {
            let entry: Array = entry.unchecked_into();
            let (key, value) = (entry.get(0).as_string().unwrap_or_default(), entry.get(1));
            match &*key {
                "signal" => request.signal = of_type(value, "options.signal: it must be an AbortSignal")?,
                "onProgress" => request.on_progress = of_type(value, "options.onProgress: it must be a function")?,
                _ if value.is_undefined() => {}
                _ => request.options = with(request.options, &key, &value)?,
            }
        }
        request.options.check().map_err(raised)?;
        Ok(request)
    }

    /// Returns an error of the frame. That of an aborted one is the signal's reason, usually a `DOMException`.
    pub(crate) fn raised(&self, error: Error) -> JsValue {
        match (&error, &self.signal) {
            (Error::Cancelled, Some(signal)) => signal.reason(),
            _ => raised(error),
        }
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

/// Sets an option of the library, whose name has underscores in place of capitals.
fn with(options: Options, key: &str, value: &JsValue) -> Result<Options, JsValue> {
    let name: String = key.chars().flat_map(spelled).collect();
    let Some(setting) = Setting::ALL.iter().find(|setting| setting.name == name) else {
        let known: Vec<String> = Setting::ALL.iter().map(|setting| key_of(setting.name)).collect();
        let known = known.join(", ");
        return Err(refused(&format!("options: unknown field '{key}'; the fields are {known}, signal, onProgress")));
    };
    let text = text(value, setting).map_err(|reason| refused(&format!("options.{key}: {reason}")))?;
    options.set(setting.name, &text).map_err(|error| match error {
        Error::Options { reason, .. } => refused(&format!("options.{key}: {reason}")),
        other => raised(other),
    })
}

fn spelled(letter: char) -> impl Iterator<Item = char> {
    letter.is_ascii_uppercase().then_some('_').into_iter().chain([letter.to_ascii_lowercase()])
}

/// Returns an option's key in JavaScript.
pub(crate) fn key_of(name: &str) -> String {
    let words = name.split('_').enumerate();
    words.map(|(index, word)| if index == 0 { word.into() } else { word[..1].to_uppercase() + &word[1..] }).collect()
}

/// Returns a value as the text that the library reads: `null` is `off`, and `{ rays, radius }` is joined by a colon.
fn text(value: &JsValue, setting: &Setting) -> Result<String, String> {
    let plain = |value: &JsValue| {
        let number = value.as_f64().map(|number| number.to_string());
        number.or_else(|| value.as_string()).or_else(|| value.as_bool().map(|flag| flag.to_string()))
    };
    if value.is_null() {
        return Ok("off".into());
    }
    if let Some(text) = plain(value) {
        return Ok(text);
    }
    let fields = match setting.name {
        "ambient_occlusion" => ["rays", "radius"],
        "adaptive" => ["tolerance", "levels"],
        "shadow_buffer" => ["rows", "rule"],
        _ => return Err(format!("it must be like {}", setting.form)),
    };
    let object: &Object = value.dyn_ref().ok_or_else(|| format!("it must have {}", fields.join(" and ")))?;
    let mut keys = Object::keys(object).into_iter().filter_map(|key| key.as_string());
    if let Some(key) = keys.find(|key| !fields.contains(&&**key)) {
        return Err(format!("unknown field '{key}'; the fields are {}", fields.join(", ")));
    }
    let field = |name: &str| {
        let value = Reflect::get(object, &name.into()).ok().and_then(|value| plain(&value));
        value.ok_or_else(|| format!("it must have {name}"))
    };
    Ok(format!("{}:{}", field(fields[0])?, field(fields[1])?))
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
