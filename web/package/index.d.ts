export {
    Pair, Renderer, Scene, Views, anaglyphs, builtins, methods, packings, render, version,
} from "./stereotrace_web.js";
export type {
    AnaglyphName, Camera, Difference, Eye, Light, Material, Mesh, MethodName, PackingName, Rays, RenderOptions, SceneInfo, Statistics, Vector,
} from "./stereotrace_web.js";
