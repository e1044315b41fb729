//! The library in browsers, by WebGPU: classes over the library's, whose arrays are JavaScript's. `package/types.d.ts`
//! has the types of plain objects (cameras, options, statistics), and docs for who calls; wasm-bindgen adds the
//! classes' own.
//!
//! ```text
//! scene.rs     Scene: built in, read from dropped files, or made in code
//! camera.rs    a camera, a plain object
//! options.rs   how pictures are rendered, a plain object
//! renderer.rs  Renderer: device, kernels and uploaded scenes, from picture to picture; a lost device is opened again
//! pair.rs      Pair: pictures for glasses and displays, depths, maps, what it cost, how far it is from another
//! views.rs     Views: quilts
//! ```
#![cfg(target_arch = "wasm32")]

mod camera;
mod difference;
mod errors;
mod messages;
mod options;
mod pair;
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

/// Renders a pair on a renderer that all calls share. Without a camera it is the scene's own, 640x480. Rejects as
/// `Renderer.render` does.
#[wasm_bindgen(unchecked_return_type = "Pair")]
pub async fn render(
    scene: &Scene,
    #[wasm_bindgen(unchecked_optional_param_type = "Camera")] camera: JsValue,
    #[wasm_bindgen(unchecked_optional_param_type = "RenderOptions")] options: JsValue,
) -> Result<Pair, JsValue> {
    Renderer::common().render(scene, camera, options).await
}

/// The library's version.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").into()
}

/// The names of all methods.
#[wasm_bindgen]
pub fn methods() -> Vec<String> {
    values::names(stereotrace::Method::ALL)
}

/// The names of all built-in scenes.
#[wasm_bindgen]
pub fn builtins() -> Vec<String> {
    values::names(stereotrace::Builtin::ALL)
}

/// The names of all kinds of anaglyph.
#[wasm_bindgen]
pub fn anaglyphs() -> Vec<String> {
    values::names(stereotrace::output::Anaglyph::ALL)
}

/// The names of all packings of two views in one picture.
#[wasm_bindgen]
pub fn packings() -> Vec<String> {
    values::names(stereotrace::output::Packing::ALL)
}
