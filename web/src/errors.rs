//! The library's errors as JavaScript's `Error`. The message is the library's; `name` says what a program may do.

use js_sys::Error as JsError;
use stereotrace::Error;
use wasm_bindgen::JsValue;

/// Converts an error of the library to a JavaScript error.
pub(crate) fn raised(error: Error) -> JsValue {
    let name = match error {
        Error::Cancelled => "AbortError",
        Error::NoAdapter { .. } => "NoAdapterError",
        Error::DeviceLost(_) => "DeviceLostError",
        Error::Limit { .. } | Error::TooLarge { .. } | Error::OutOfMemory(_) => "LimitError",
        Error::Gpu(_) => "GpuError",
        _ => "Error",
    };
    named(name, &error.to_string())
}

/// Returns the error for input that this package itself refuses.
pub(crate) fn refused(text: &str) -> JsValue {
    named("TypeError", text)
}

fn named(name: &str, text: &str) -> JsValue {
    let error = JsError::new(text);
    error.set_name(name);
    error.into()
}
