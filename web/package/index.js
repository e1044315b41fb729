// The package: the output of wasm-bindgen, ready to use once this module is imported. The .wasm file is fetched from
// the folder of this module.
import init, { Pair, Passes, Renderer, Scene, Views } from "./stereotrace_web.js";

// Deno has both.
if (globalThis.process?.versions?.node && !globalThis.navigator?.gpu) {
    throw new Error(
        "stereotrace needs WebGPU, and Node has none. Import it in a browser, or use the command or the Python package.",
    );
}

await init();

for (const [name, { prototype }] of Object.entries({ Pair, Passes, Renderer, Scene, Views })) {
    const { free } = prototype;
    // A second call does nothing, as that of a browser's own objects.
    prototype.free = function () {
        if (Object.getOwnPropertyDescriptor(this, "__wbg_ptr")?.get) return;
        free.call(this);
        const get = () => {
            throw new TypeError(`This ${name} was freed.`);
        };
        Object.defineProperty(this, "__wbg_ptr", { get });
    };
    if (Symbol.dispose) prototype[Symbol.dispose] = prototype.free;
}

export {
    Pair,
    Passes,
    Renderer,
    Scene,
    Views,
    anaglyphs,
    builtins,
    channels,
    methods,
    options,
    packings,
    render,
    version,
} from "./stereotrace_web.js";
