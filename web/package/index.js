// The package: the output of wasm-bindgen, ready to use once this module is imported. The .wasm file is fetched from
// the folder of this module.
import init from "./stereotrace_web.js";

await init();

export {
    Pair, Passes, Renderer, Scene, Views, anaglyphs, builtins, channels, methods, options, packings, render, version,
} from "./stereotrace_web.js";
