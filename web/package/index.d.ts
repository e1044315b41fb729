/// <reference lib="esnext.disposable" />
import type { InitInput } from "./stereotrace_web.js";

/**
 * Loads the package's .wasm file, once. `render`, `Scene.builtin` and `Scene.fromFiles` call it without arguments. All
 * other functions and constructors need it before their first call.
 *
 * `source` is the address of `stereotrace_web_bg.wasm`, its bytes or a compiled module. The default is the file beside
 * the package's modules. Rejects if the file cannot be loaded, and can then be called again.
 */
export function init(source?: InitInput | Promise<InitInput>): Promise<void>;

export {
    Pair, Passes, Renderer, Scene, Views, anaglyphs, builtins, channels, methods, options, packings, render, version,
} from "./stereotrace_web.js";
export type {
    AnaglyphName, Camera, ChannelName, Difference, Eye, Light, Material, Mesh, MethodName, PackingName, Rays, RenderOptions, SceneInfo, Statistics, Surface, Vector,
} from "./stereotrace_web.js";
