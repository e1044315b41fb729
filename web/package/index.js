// The package: what wasm-bindgen made, ready to use once this module is imported. The .wasm file is fetched from beside it.
import init from "./stereotrace_web.js";

await init();

export {
    Pair, Renderer, Scene, Views, anaglyphs, builtins, methods, packings, render, version,
} from "./stereotrace_web.js";
