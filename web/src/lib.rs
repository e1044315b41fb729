//! The library in browsers, by WebGPU: classes over the library's classes, with JavaScript arrays. `package/types.d.ts`
//! has the documented types of plain objects (cameras, options, statistics). wasm-bindgen adds the types of the
//! classes.
//!
//! ```text
//! scene.rs     Scene: built in, read from dropped files, or made in code
//! camera.rs    cameras as plain objects
//! options.rs   render options as plain objects
//! renderer.rs  Renderer: keeps device, kernels and uploaded scenes; opens a lost device again
//! pair.rs      Pair: pictures for glasses and displays, depths, maps, cost, difference from another pair
//! views.rs     Views: rows of views, quilts
//! ```
#![cfg(target_arch = "wasm32")]

mod camera;
mod difference;
mod errors;
mod messages;
mod options;
mod pair;
mod passes;
mod renderer;
mod scene;
mod values;
mod views;

use wasm_bindgen::prelude::*;

use self::{pair::Pair, renderer::Renderer, scene::Scene};

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = include_str!("../package/types.d.ts");

/// Runs once, when the module is loaded.
#[wasm_bindgen(start)]
fn start() {
    messages::listen();
    std::panic::set_hook(Box::new(|panic| messages::complain(&panic.to_string())));
}

/// Renders a pair on a renderer that all calls share. The default camera is the scene's own, at 640x480. Rejects as
/// `Renderer.render` does.
#[wasm_bindgen(unchecked_return_type = "Pair")]
pub async fn render(
    scene: &Scene,
    #[wasm_bindgen(unchecked_optional_param_type = "Camera")] camera: JsValue,
    #[wasm_bindgen(unchecked_optional_param_type = "RenderOptions")] options: JsValue,
) -> Result<Pair, JsValue> {
    Renderer::common().render(scene, camera, options).await
}

/// Returns the library's version.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").into()
}

/// Returns the names of all methods.
#[wasm_bindgen]
pub fn methods() -> Vec<String> {
    values::names(stereotrace::Method::ALL)
}

/// Returns the names of all built-in scenes.
#[wasm_bindgen]
pub fn builtins() -> Vec<String> {
    values::names(stereotrace::Builtin::ALL)
}

/// Returns the names of all kinds of anaglyph.
#[wasm_bindgen]
pub fn anaglyphs() -> Vec<String> {
    values::names(stereotrace::output::Anaglyph::ALL)
}

/// Returns the keys of all options of rendering, except `signal` and `onProgress`.
#[wasm_bindgen]
pub fn options() -> Vec<String> {
    stereotrace::Setting::ALL.iter().map(|setting| options::key_of(setting.name)).collect()
}

/// Returns the names of all outputs of a view.
#[wasm_bindgen]
pub fn channels() -> Vec<String> {
    values::names(stereotrace::Channel::ALL)
}

/// Returns the names of all packings of two views in one picture.
#[wasm_bindgen]
pub fn packings() -> Vec<String> {
    values::names(stereotrace::output::Packing::ALL)
}
