// A worker that does all rendering, so that the page answers even during a long frame. It receives messages { id, task,
// ... } and answers each with { id, result } or { id, error }, and reports progress with { id, done }.
// @ts-check
import { Passes, Renderer, Scene, anaglyphs, builtins, init, methods, version } from "./pkg/index.js";
import { corners } from "./stl.js";

await init();

/** @typedef {import("./pkg/index.js").Camera} Camera */
/** @typedef {import("./pkg/index.js").RenderOptions} RenderOptions */
/** @typedef {import("./pkg/index.js").Pair} Pair */

const renderer = new Renderer();
/** The open scene, its source, its size, and the number of lights placed in it (0: its own lights). */
let open = {
    scene: /** @type {Scene | null} */ (null),
    source: /** @type {any} */ (null),
    size: [640, 480],
    lights: 0,
};
/** The last rendered pair, its camera and options, and the same pair by naive if it was requested. */
let last =
    /** @type {{ pair: Pair, camera: Camera, options: RenderOptions, truth?: Pair, truthMs?: number } | null} */ (null);
/** Passes of the last pair, if its light is by paths. */
let passes = /** @type {Passes | null} */ (null);
/** Exposures that suit the open scene, by its lights and options. */
let exposures = /** @type {Map<string, number>} */ (new Map());
/** Ends the current rendering. */
let stopping = new AbortController();

/** The sky behind a file without one, and the number of lights beside the eyes if the file has none. */
const BACKDROP = /** @type {const} */ ({ nadir: [0.26, 0.27, 0.29], zenith: [0.52, 0.56, 0.62], lights: 3 });
/** Measured methods. A sweep on the host shows nothing about a GPU. */
const MEASURED = methods().filter((name) => name !== "adelson-hodges" && name !== "auto");

async function adapter() {
    const found = await navigator.gpu?.requestAdapter({ powerPreference: "high-performance" });
    if (!found) return null;
    // Chrome has it from version 121.
    const info = found.info ?? {};
    const { vendor, architecture, device, description } = info;
    const software = Boolean(info.isFallbackAdapter ?? /** @type {any} */ (found).isFallbackAdapter);
    return { vendor, architecture, device, description, software, timestamps: found.features.has("timestamp-query") };
}

/** @param {any} source */
async function sceneOf(source) {
    if (source.builtin) return Scene.builtin(source.builtin);
    /** @type {Record<string, Uint8Array>} */
    const files = {};
    for (const { path, file } of source.files) files[path] = new Uint8Array(await file.arrayBuffer());
    const scene = /\.stl$/i.test(source.main)
        ? stl(files[source.main], source.main)
        : await Scene.fromFiles(files, source.main);
    scene.setSky(BACKDROP.nadir, BACKDROP.zenith);
    return scene;
}

/** @param {Uint8Array} bytes @param {string} name */
function stl(bytes, name) {
    const scene = new Scene();
    scene.addMesh({ positions: corners(bytes, name), name });
    return scene;
}

/** Lights a new scene, by its own camera. @param {Scene} scene @param {any} source @param {number} lights */
function light(scene, source, lights, size = open.size) {
    const { lights: own, emits, physicallyBased } = scene.info;
    const isDark = !source.builtin && own === 0 && !(emits && physicallyBased);
    const count = lights || (isDark ? BACKDROP.lights : 0);
    if (count) scene.placeLights(count, scene.camera(size[0], size[1]));
}

/** @param {ImageData} image */
async function png(image) {
    const canvas = new OffscreenCanvas(image.width, image.height);
    /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext("2d")).putImageData(image, 0, 0);
    return canvas.convertToBlob({ type: "image/png" });
}

/**
 * Returns the pictures of a view: one, or both eyes.
 * @param {import("./settings.js").View | "top-bottom"} view @param {any} glasses @returns {ImageData[]}
 */
function pictures(view, glasses) {
    const { pair, truth } = shown();
    switch (view) {
        case "anaglyph":
            return [pair.anaglyph(glasses)];
        case "side-by-side":
        case "cross-eyed":
        case "top-bottom":
            return [pair.packed(view)];
        case "slider":
        case "wiggle":
            return [pair.view("left"), pair.view("right")];
        case "left":
        case "right":
            return [pair.view(view)];
        case "retrace":
            return [pair.retraceMap()];
        case "shadows":
            return [pair.shadowMap() ?? pair.retraceMap()];
        case "difference":
            return [truth ? pair.differenceMap(truth) : pair.view("right")];
    }
}

/** Colour of marked pixels: orange, with its bytes from the last to the first. */
const MARK = 0xff1a7aff;

/** Returns a picture of the right pixels that were traced again; null if nothing was reused. */
function marked() {
    const { pair } = shown();
    if (pair.statistics.retracedShare === 1) return null;
    const sources = pair.channel("right", "source");
    const pixels = new Uint32Array(sources.length);
    sources.forEach((/** @type {number} */ source, /** @type {number} */ index) => {
        if (source) pixels[index] = MARK;
    });
    return new ImageData(new Uint8ClampedArray(pixels.buffer), pair.width, pair.height);
}

/** Returns the last pair's pictures and figures. @param {any} request @param {object} more */
async function pictured(request, more) {
    const [bitmaps, transfer] = await bitmapsOf(request);
    const { statistics } = shown().pair;
    return [
        {
            ...bitmaps,
            statistics,
            deviceMs: deviceMs(statistics),
            lost: renderer.devicesLost,
            paths: passes?.paths ?? 0,
            ...more,
        },
        transfer,
    ];
}

function shown() {
    if (!last) throw new Error("nothing has been rendered yet");
    return last;
}

/**
 * Returns the last pair's pictures, and marks of pixels that were traced again if they are asked for.
 * @param {any} request @returns {Promise<[{ images: ImageBitmap[], traced: ImageBitmap | null }, ImageBitmap[]]>}
 */
async function bitmapsOf({ view, glasses, marks }) {
    const images = await Promise.all(pictures(view, glasses).map((image) => createImageBitmap(image)));
    const marking = marks ? marked() : null;
    const traced = marking && (await createImageBitmap(marking));
    return [{ images, traced }, traced ? [...images, traced] : images];
}

/** @param {number[]} values */
const median = (values) => values.toSorted((a, b) => a - b)[Math.floor(values.length / 2)];
/** @param {import("./pkg/index.js").Statistics} statistics */
const deviceMs = (statistics) => statistics.passes?.reduce((sum, pass) => sum + pass.ms, 0);

/** @param {Camera} camera @param {RenderOptions} options @param {Passes | null} [refined] */
async function timed(camera, options, refined) {
    if (!open.scene) throw new Error("no scene is open");
    const begin = performance.now();
    const pair = await (refined
        ? renderer.addTo(refined, open.scene, camera, options)
        : renderer.render(open.scene, camera, options));
    return { pair, ms: performance.now() - begin };
}

/** Returns the number of bounces of light by paths. @param {RenderOptions} options */
const bounces = (options) => Number(options.lighting?.split(":")[1]);

/**
 * Returns the exposure of a file's pictures, which its first picture decides.
 * @param {Camera} camera @param {RenderOptions} options
 */
async function exposure(camera, options) {
    if (!open.scene?.info.physicallyBased) return 0;
    const key = `${open.lights} ${Boolean(options.lighting)}`;
    const known = exposures.get(key) ?? (await renderer.suggestExposure(open.scene, camera, options));
    exposures.set(key, known);
    return known;
}

async function compared() {
    const frame = shown();
    if (!frame.truth) {
        const options = { ...frame.options, method: "naive", signal: stopping.signal };
        if (passes) options.lighting = `paths=${passes.paths}:${bounces(frame.options)}`;
        const { pair, ms } = await timed(frame.camera, options);
        [frame.truth, frame.truthMs] = [pair, ms];
    }
    return { difference: frame.pair.difference(frame.truth), naiveMs: frame.truthMs };
}

const tasks = {
    async begin() {
        return {
            adapter: await adapter(),
            builtins: builtins(),
            methods: methods(),
            anaglyphs: anaglyphs(),
            version: version(),
        };
    },

    /** @param {any} request */
    async open({ source, size }) {
        const scene = await sceneOf(source);
        const camera = scene.camera(size[0], size[1]);
        light(scene, source, 0, size);
        // The new scene is uploaded before the old one is freed. If the upload fails, the old one stays open.
        await renderer.upload(scene);
        open.scene?.free();
        open = { scene, source, size, lights: 0 };
        exposures = new Map();
        forget();
        return { camera, info: scene.info, warnings: scene.warnings };
    },

    /** @param {any} request */
    async render({ camera, options: asked, paths, lights, compare, ...shownAs }, tell) {
        const { signal } = stopping;
        if (lights !== open.lights) {
            if (!lights && open.source) {
                // The scene's own lights come back with the scene.
                const scene = await sceneOf(open.source);
                open.scene?.free();
                open.scene = scene;
            }
            if (open.scene) light(open.scene, open.source, lights);
            open.lights = lights;
        }
        const options = { ...asked, exposure: await exposure(camera, asked) };
        const begun = paths ? new Passes() : null;
        const { pair, ms } = await timed(camera, { ...options, signal, onProgress: tell }, begun);
        forget();
        last = { pair, camera, options };
        passes = begun;
        const truth = compare ? await compared() : undefined;
        return pictured(shownAs, { ms, ...truth });
    },

    /** Adds a pass to the last pair. @param {any} request */
    async refine({ first, ...shownAs }) {
        const { pair: before, truth, camera, options } = shown();
        const { signal } = stopping;
        if (!passes) throw new Error("nothing is refined");
        const lost = renderer.devicesLost;
        // Later passes are longer, so that denoising takes a small share of the time.
        const paths = Math.max(first, Math.floor(passes.paths / 4));
        /** @type {RenderOptions} */
        const longer = { ...options, lighting: `paths=${paths}:${bounces(options)}`, signal };
        const { pair, ms } = await timed(camera, longer, passes).catch((error) => {
            // The passes belong to the device that was lost; the picture begins anew.
            if (renderer.devicesLost === lost || !passes) throw error;
            passes.free();
            passes = new Passes();
            return timed(camera, { ...options, signal }, passes);
        });
        before.free();
        truth?.free();
        last = { pair, camera, options };
        return pictured(shownAs, { ms });
    },

    /** Returns the last pair in another view, and its camera. @param {any} request */
    async show(request) {
        const [bitmaps, transfer] = await bitmapsOf(request);
        return [{ ...bitmaps, camera: shown().camera }, transfer];
    },

    async compare() {
        return compared();
    },

    /** @param {any} request */
    async png({ view, glasses }) {
        const images = pictures(view, glasses);
        return images.length === 1 ? png(images[0]) : png(shown().pair.packed("side-by-side"));
    },

    /** @param {any} request */
    async quilt({ camera, options, columns, rows, name }, tell) {
        if (!open.scene) throw new Error("no scene is open");
        const { signal } = stopping;
        const exposed = { ...options, exposure: await exposure(camera, options) };
        const views = await renderer.views(open.scene, camera, columns * rows, {
            ...exposed,
            signal,
            onProgress: tell,
        });
        const result = {
            blob: await png(views.quilt(columns, rows)),
            name: views.quiltName(name, columns, rows),
            traced: views.traced,
        };
        views.free();
        return result;
    },

    /** @param {any} _request */
    async report(_request, tell) {
        return renderer.report(60, { signal: stopping.signal, onProgress: tell });
    },

    /** Measures accuracy and cost of each method, in alternation. @param {any} request */
    async measure({ camera, options, rounds }, tell) {
        if (!open.scene) throw new Error("no scene is open");
        const signal = stopping.signal;
        const steps = MEASURED.length * (rounds + 2);
        let step = 0;
        const next = () => tell(++step / steps);
        const rows = [];
        let truth;
        for (const method of MEASURED) {
            const { pair } = await timed(camera, { ...options, method, count: true, signal });
            truth ??= pair;
            const { secondEye, retracedShare } = pair.statistics;
            rows.push({ method, secondEye, retracedShare, difference: pair.difference(truth), times: [], device: [] });
            if (pair !== truth) pair.free();
            next();
        }
        truth?.free();
        for (let round = 0; round <= rounds; round += 1) {
            for (const row of rows) {
                const { pair, ms } = await timed(camera, { ...options, method: row.method, signal });
                // The first round compiles the kernels of frames without counters.
                if (round > 0) {
                    row.times.push(ms);
                    const device = deviceMs(pair.statistics);
                    if (device !== undefined) row.device.push(device);
                }
                pair.free();
                next();
            }
        }
        const naive = median(rows[0].times);
        const found = rows.map(({ method, secondEye, retracedShare, difference, times, device }) => {
            const ms = median(times);
            return {
                method,
                ms,
                msOfNaive: ms / naive,
                deviceMs: device.length ? median(device) : null,
                secondEye,
                retracedShare,
                // JSON has no infinity.
                ...difference,
                psnr: Number.isFinite(difference.psnr) ? difference.psnr : null,
            };
        });
        const { triangles, primitives, lights } = open.scene.info;
        return {
            stereotrace: version(),
            date: new Date().toISOString(),
            browser: navigator.userAgent,
            adapter: await adapter(),
            scene: open.source.builtin ?? open.source.name,
            triangles,
            primitives,
            lights,
            camera,
            samples: options.samples ?? 1,
            rounds,
            methods: found,
        };
    },
};

function forget() {
    last?.pair.free();
    last?.truth?.free();
    last = null;
    passes?.free();
    passes = null;
}

/**
 * Runs tasks one after the other, in the order of their messages, so that a scene is not freed while it is rendered.
 */
let turn = Promise.resolve();
self.onmessage = ({ data }) => {
    if (data.task === "stop") {
        stopping.abort();
        stopping = new AbortController();
    } else {
        turn = turn.then(() => answer(data));
    }
};

async function answer({ id, task, ...request }) {
    try {
        let told = 0;
        /** @param {number} done */
        const tell = (done) => {
            // Progress is reported at most 20 times per second.
            if (performance.now() - told > 50) {
                told = performance.now();
                postMessage({ id, done });
            }
        };
        const found = await /** @type {any} */ (tasks)[task](request, tell);
        const [result, transfer] = Array.isArray(found) ? found : [found, []];
        postMessage({ id, result }, transfer);
    } catch (error) {
        const { name, message } = error instanceof Error ? error : new Error(String(error));
        postMessage({ id, error: { name, message } });
    }
}

// Rejected promises that are not awaited become errors, which the page receives.
addEventListener("unhandledrejection", (event) => {
    throw event.reason;
});
postMessage({ ready: true });
