/// <reference lib="esnext.disposable" />
export {
    Pair, Passes, Renderer, Scene, Views, anaglyphs, builtins, channels, methods, options, packings, render, version,
} from "./stereotrace_web.js";
export type {
    AnaglyphName, Camera, ChannelName, Difference, Eye, Light, Material, Mesh, MethodName, PackingName, Rays, RenderOptions, SceneInfo, Statistics, Surface, Vector,
} from "./stereotrace_web.js";
