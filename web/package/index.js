// The package: the output of wasm-bindgen, whose .wasm file is loaded by the first call that returns a promise.
import start, * as module from "./stereotrace_web.js";

/** Settles once the .wasm file is loaded or has failed to load. */
let loading;
let loaded = false;

async function load(source) {
    // Deno has both.
    if (globalThis.process?.versions?.node && !globalThis.navigator?.gpu) {
        throw new Error(
            "stereotrace needs WebGPU, and Node has none. Use it in a browser, or use the command or Python.",
        );
    }
    try {
        const file = await (source ?? new URL("stereotrace_web_bg.wasm", import.meta.url));
        await start({ module_or_path: file });
    } catch (cause) {
        const remedy = "pass its address or its bytes to init()";
        throw new Error(`stereotrace_web_bg.wasm could not be loaded; ${remedy}: ${cause.message}`, { cause });
    }
    loaded = true;
}

export function init(source) {
    // A failed load can be tried again.
    loading ??= load(source).catch((error) => {
        loading = undefined;
        throw error;
    });
    return loading;
}

/** Returns a function that loads the .wasm file before its first call. */
const lazy =
    (call) =>
    async (...given) => {
        await init();
        return call(...given);
    };

/** Returns a function or class that says so if it is called before the .wasm file is loaded. */
function checked(name) {
    const check = () => {
        if (!loaded) throw new Error(`${name}: stereotrace is not loaded; await init() first`);
    };
    return new Proxy(module[name], {
        apply(call, self, given) {
            check();
            return Reflect.apply(call, self, given);
        },
        construct(type, given, derived) {
            check();
            return Reflect.construct(type, given, derived);
        },
    });
}

module.Scene.builtin = lazy(module.Scene.builtin);
module.Scene.fromFiles = lazy(module.Scene.fromFiles);
export const Passes = checked("Passes");
export const Renderer = checked("Renderer");
export const Scene = checked("Scene");
export { Pair, Views } from "./stereotrace_web.js";

for (const name of ["Pair", "Passes", "Renderer", "Scene", "Views"]) {
    const { prototype } = module[name];
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

export const render = lazy(module.render);
export const anaglyphs = checked("anaglyphs");
export const builtins = checked("builtins");
export const channels = checked("channels");
export const methods = checked("methods");
export const options = checked("options");
export const packings = checked("packings");
export const version = checked("version");
