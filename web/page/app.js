// The page: it reads settings and gestures, and shows pictures and figures. engine.js renders in a worker.
// @ts-check
import { plot, tabulate } from "./chart.js";
import { dropped, source as sourceOf } from "./files.js";
import { Head } from "./head.js";
import { nearer, orbited, panned } from "./orbit.js";

/** @typedef {import("./pkg/index.js").Camera} Camera */

/** @param {string} id @returns {any} */
const element = (id) => document.getElementById(id);
const canvas = /** @type {HTMLCanvasElement} */ (element("picture"));
const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
const query = new URLSearchParams(location.search);

/** Maximum time of a frame while something is dragged, in milliseconds. */
const DRAFT_MS = 80;
const WIGGLE_MS = 180;
/** Largest side of an automatically sized picture, on software adapters and on others. */
const MOST_SIDE = { software: 512, hardware: 1600 };
/** Light by paths: paths of drafts, of the first picture and of the last, and bounces. */
const PATHS = { draft: 2, first: 4, last: 256, bounces: 3 };
/** Drafts of at least so many pixels recall the draft before, within so many MiB. Smaller ones take as long without. */
const RECALLED = { pixels: 2 ** 18, history: 512 };
/** Height of an automatically sized equirectangular view, on software adapters and on others. */
const AROUND_HEIGHT = { software: 384, hardware: 2048 };
const QUILT = { columns: 8, rows: 6, size: [420, 560], interaxialPixels: 3 };
const ROUNDS = 3;
const VIEWS = [...element("view").options].map((option) => option.value);
const LEGENDS = {
    retrace: "The map shows the source of each right pixel. Green pixels were reused from the left view, or found "
        + "within the left view's depth bound. Red and yellow pixels were traced because reuse failed. Grey pixels were "
        + "traced without reuse.",
    shadows: "The map shows the source of the right view's shadows with bracket. Green pixels reused visibility bits of "
        + "the left view. Red pixels traced shadow rays.",
    difference: "The right view is compared with naive. Equal pixels are dark, and different pixels are yellow to red.",
};
/** Passes of the left eye alone, and passes that both eyes share. All others belong to the right eye. */
const LEFT_PASSES = ["trace_left"];
const SHARED_PASSES = [
    "trace_hits", "trace_soft", "shade_hits", "list_mirrors", "trace_mirrored", "pack", "begin_paths", "trace_paths", "add_brought",
    "smooth_variances", "smooth_light_once",
];

/** The engine: it is asked by messages and answers each of them. */
class Engine {
    /** @param {string} url */
    constructor(url) {
        this.waiting = new Map();
        this.last = 0;
        this.worker = new Worker(url, { type: "module" });
        this.ready = new Promise((done, failed) => {
            let ready = false;
            this.worker.onerror = (event) => {
                const reason = event.message ?? "see the browser's console";
                failed(new Error(`the engine could not be loaded: ${reason}`));
                // An error between two messages, such as a panic while waiting for the device, answers none of them.
                const error = Object.assign(new Error(reason), { name: ready ? "RuntimeError" : "Error" });
                for (const { failed } of this.waiting.values()) failed(error);
                this.waiting.clear();
            };
            this.worker.onmessage = ({ data }) => {
                if (data.ready) {
                    ready = true;
                    return done(undefined);
                }
                const asked = this.waiting.get(data.id);
                if (!asked) return;
                if ("done" in data) return asked.tell?.(data.done);
                this.waiting.delete(data.id);
                if (data.error) asked.failed(Object.assign(new Error(data.error.message), { name: data.error.name }));
                else asked.done(data.result);
            };
        });
    }

    /** @param {string} task @param {object} request @param {((done: number) => void) | undefined} [tell] @returns {Promise<any>} */
    async ask(task, request = {}, tell) {
        await this.ready;
        const id = ++this.last;
        return new Promise((done, failed) => {
            this.waiting.set(id, { done, failed, tell });
            this.worker.postMessage({ id, task, ...request });
        });
    }

    /** Ends the current rendering with an AbortError. */
    stop() {
        this.worker.postMessage({ task: "stop" });
    }
}

/** @type {Engine} */
let engine;
let adapter = { software: false };
/** The open scene. Its camera has the values that the sliders multiply. */
let open = { name: "", source: /** @type {any} */ (null), camera: /** @type {Camera | null} */ (null) };
/** The current camera, before the sliders. */
let camera = /** @type {Camera | null} */ (null);
/** @type {ImageBitmap[]} */
let images = [];
/** How the images show their views: their projection, and how many are side by side. */
let shownAs = { around: /** @type {360 | 180 | null} */ (null), views: 1 };
const head = new Head();
/** Milliseconds per pixel of the last frame. */
let pixelMs = 0;
let lost = 0;

// --- What is asked for ---

const settings = () => ({
    view: element("view").value,
    glasses: element("glasses").value,
    lights: Number(element("lights").value),
    options: { method: element("method").value, samples: Number(element("samples").value) ** 2, ...light(PATHS.first) },
});

/** Returns the options of the chosen light. @param {number} paths */
const light = (paths) => (element("light").value === "paths" ? { lighting: `paths=${paths}:${PATHS.bounces}`, denoise: true } : {});

/** Width and height of a whole picture. */
function size() {
    const chosen = element("size").value;
    if (chosen !== "auto") return chosen.split("x").map(Number);
    const { clientWidth: width } = element("stage");
    const height = Math.max(200, Math.min(0.75 * width, 0.72 * innerHeight));
    const most = adapter.software ? MOST_SIDE.software : MOST_SIDE.hardware;
    const scale = Math.min(devicePixelRatio, most / Math.max(width, height));
    return [width, height].map((side) => Math.max(16, Math.round(side * scale)));
}

/** The chosen equirectangular projection: 360 or 180 degrees, or null for planar pictures. @returns {360 | 180 | null} */
const around = () => (element("projection").value === "planar" ? null : /** @type {360 | 180} */ (Number(element("projection").value)));

/** Width and height of a whole view as it is rendered. */
function renderedSize() {
    const span = around();
    if (!span) return size();
    const automatic = adapter.software ? AROUND_HEIGHT.software : AROUND_HEIGHT.hardware;
    const height = element("size").value === "auto" ? automatic : size()[1];
    return [height * span / 180, height];
}

/** Returns the camera with the sliders' values. @param {number} scale @returns {Camera} */
function seen(scale = 1) {
    if (!camera) throw new Error("no scene is open");
    const [e, d] = [Number(element("e").value), 2 ** Number(element("d").value)];
    const [width, height] = renderedSize().map((side) => Math.max(16, Math.round(side * scale)));
    const span = around();
    const interaxial = (camera.interaxial ?? 0) * e;
    if (span) return { eye: camera.eye, target: camera.target, up: camera.up, size: [width, height], interaxial, projection: span };
    return { ...camera, size: [width, height], interaxial, screenDistance: (camera.screenDistance ?? 1) * d };
}

/** Updates the numbers beside the sliders. */
function label() {
    if (!camera) return;
    const { interaxial = 0, screenDistance = 1, size: [width, height] = [1, 1], fov = 45 } = seen();
    const across = 2 * screenDistance * Math.tan(fov * Math.PI / 360) * width / height;
    element("e-value").value = around() ? short(interaxial) : `${short(interaxial)}, ${short(interaxial * width / across)} px`;
    element("d-row").hidden = Boolean(around());
    element("around-hint").hidden = !around();
    element("d-value").value = short(screenDistance);
    element("samples-value").value = String(settings().options.samples);
    element("lights-value").value = settings().lights || "from the scene";
    element("light-hint").hidden = element("light").value !== "paths";
    element("glasses-row").hidden = settings().view !== "anaglyph";
    const legend = LEGENDS[settings().view];
    element("legend").hidden = !legend;
    element("legend").textContent = legend ?? "";
}

/** @param {number} value */
const short = (value) => Number(value.toPrecision(3)).toString();

// --- What is rendered: the newest wish alone ---

/** @type {"draft" | "whole" | "show" | "refine" | null} */
let wish = null;
/** @type {"draft" | "whole" | "refine" | "other" | null} */
let running = null;
/** Whether the last picture is refined while nothing else is asked for. */
let refining = false;
/** Whether a task waits for the engine, or uses it. */
let paused = false;
let settle = 0;

/** Asks for a draft soon, and for a whole picture once nothing moves. */
function moved() {
    label();
    clearTimeout(settle);
    settle = setTimeout(() => ask("whole"), 160);
    ask("draft");
}

/** @param {"draft" | "whole" | "show"} what */
function ask(what) {
    if (!camera) return;
    // Rendering also shows the last pair in the chosen view, so it replaces a wish to show.
    if (wish === null || what !== "show") wish = what;
    if (running === "refine" || (running === "whole" && what !== "show")) engine.stop();
    if (what !== "show") refining = false;
    if (running === null) void work();
}

async function work() {
    while (!paused && (wish || refining)) {
        const what = wish ?? "refine";
        wish = null;
        running = what === "show" ? "other" : what;
        try {
            if (what === "show") await show();
            else if (what === "refine") await refine();
            else await render(what === "draft");
        } catch (error) {
            if (error.name !== "AbortError") refining = false;
            await failed(error);
        }
        running = null;
    }
}

/** Adds a pass to the last picture. */
async function refine() {
    const { view, glasses } = settings();
    const done = await engine.ask("refine", { view, glasses, first: PATHS.first });
    put(done.images, view, shownAs.around);
    figures({ ...done, deviceMs: undefined, statistics: { ...done.statistics, passes: undefined } }, seen().size, 1);
    refining &&= done.paths < PATHS.last;
}

/** @param {boolean} draft */
async function render(draft) {
    const { view, glasses, lights, options } = settings();
    const [width, height] = renderedSize();
    const scale = draft ? draftScale(width * height * options.samples) : 1;
    const busy = setTimeout(() => say("rendering…"), 400);
    const byPaths = element("light").value === "paths";
    const history = draft && width * height * scale ** 2 >= RECALLED.pixels ? RECALLED.history : null;
    const request = {
        camera: seen(scale), lights, glasses, view,
        options: { ...options, history, ...(draft && scale < 1 ? { samples: 1, ...light(PATHS.draft) } : {}) },
        paths: byPaths && !draft,
        compare: view === "difference" && !draft,
    };
    try {
        const done = await engine.ask("render", request, (share) => say(`rendering… ${Math.round(100 * share)} %`));
        put(done.images, view, request.camera.projection ?? null);
        const pixels = request.camera.size[0] * request.camera.size[1] * request.options.samples;
        pixelMs = done.ms / pixels;
        figures(done, request.camera.size, scale);
        compared(done.difference ? done : null);
        refining = request.paths && view !== "difference" && (wish === null || wish === "show");
        if (done.lost > lost) notice("The graphics device was lost, and was opened again.");
        lost = done.lost;
        document.documentElement.dataset.state = draft ? "draft" : "whole";
    } finally {
        clearTimeout(busy);
        say("");
    }
}

/**
 * Returns the scale of a draft with this many samples per pixel, as a share of the picture's side.
 * @param {number} samples
 */
function draftScale(samples) {
    if (!pixelMs) return 0.5;
    return [1, 0.5, 0.25].find((scale) => pixelMs * samples * scale ** 2 < DRAFT_MS) ?? 0.25;
}

/** Shows the last pair in the chosen view. */
async function show() {
    const { view, glasses } = settings();
    if (view === "difference") {
        refining = false;
        compared(await engine.ask("compare"));
    }
    put((await engine.ask("show", { view, glasses })).images, view, shownAs.around);
}

/**
 * Runs a task of the engine while no picture is rendered.
 * @param {string} text @param {(tell: (done: number) => void) => Promise<void>} task
 */
async function alone(text, task) {
    paused = true;
    if (running) engine.stop();
    while (running) await new Promise((done) => setTimeout(done, 20));
    running = "other";
    element("stop").hidden = false;
    say(`${text}…`);
    const buttons = ["compare", "measure", "report", "save", "save-eyes", "quilt"].map(element);
    for (const button of buttons) button.disabled = true;
    try {
        await task((share) => say(`${text}… ${Math.round(100 * share)} %`));
    } catch (error) {
        await failed(error);
    } finally {
        running = null;
        paused = false;
        element("stop").hidden = true;
        for (const button of buttons) button.disabled = false;
        say("");
        if (wish || refining) void work();
    }
}

// --- What is shown ---

/** @param {ImageBitmap[]} next @param {string} view @param {360 | 180 | null} span */
function put(next, view, span) {
    for (const image of images) image.close();
    images = next;
    shownAs = { around: span, views: ["side-by-side", "cross-eyed"].includes(view) ? 2 : 1 };
    draw(0);
}

/** @param {number} index */
function draw(index) {
    const picture = images[index % images.length];
    if (!picture) return;
    const { around: span, views } = shownAs;
    // Without WebGL the whole picture is shown.
    const image = (span && head.see(picture, views, span, size())) || picture;
    if (canvas.width !== image.width || canvas.height !== image.height) [canvas.width, canvas.height] = [image.width, image.height];
    context.drawImage(image, 0, 0);
}

let swing = 0;
setInterval(() => {
    if (images.length > 1 && !document.hidden) draw(++swing);
}, WIGGLE_MS);

/** @param {any} done @param {readonly number[]} pictureSize @param {number} scale */
function figures({ ms, statistics, deviceMs, paths }, pictureSize, scale) {
    const { method, choice, retracedShare, passes, left, right } = statistics;
    const rays = (eye) => eye.primary + eye.verification + eye.shadow + eye.secondary;
    const compiled = ms > 4 * (deviceMs ?? ms) + 300 ? ", mostly compilation" : "";
    const rows = [
        ["time, both eyes", `${ms.toFixed(ms < 100 ? 1 : 0)} ms${compiled}`],
        ["right pixels re-traced", `${(100 * retracedShare).toFixed(1)} %`],
        ["rays, right relative to left", `${(100 * rays(right) / Math.max(1, rays(left))).toFixed(0)} %`],
    ];
    const shared = passes?.some(({ name, ms }) => ms > 0 && name !== "pack" && SHARED_PASSES.includes(name));
    if (passes && !shared) {
        const sum = (of) => passes.filter(of).reduce((total, pass) => total + pass.ms, 0);
        const [first, second] = [sum(({ name }) => LEFT_PASSES.includes(name)), sum(({ name }) => ![...LEFT_PASSES, ...SHARED_PASSES].includes(name))];
        rows.push(["device time, left + right", `${first.toFixed(1)} + ${second.toFixed(1)} ms`]);
        if (first > 0) rows.push(["device time, right relative to left", `${(100 * second / first).toFixed(0)} %`]);
    } else if (deviceMs !== undefined) {
        rows.push(["device time", `${deviceMs.toFixed(1)} ms`]);
    }
    if (paths) rows.push(["paths per pixel", paths]);
    rows.push(["method", method], ["picture", `${pictureSize.join("x")}${scale < 1 ? ", draft" : ""}`]);
    element("figures").replaceChildren(...rows.map(([name, value]) => {
        const group = document.createElement("div");
        group.append(Object.assign(document.createElement("dt"), { textContent: name }), Object.assign(document.createElement("dd"), { textContent: value }));
        return group;
    }));
    element("figures").title = choice ?? "";
}

/** @param {any} found */
function compared(found) {
    const text = element("compared");
    if (!found) {
        text.textContent = "";
        return;
    }
    const { difference: { identicalPercent, wrongSurfacePercent, psnr, largestParallaxError }, naiveMs } = found;
    text.textContent = `${identicalPercent.toFixed(3)} % of the right pixels are identical to naive; `
        + `${wrongSurfacePercent.toFixed(3)} % show another surface.\n`
        + `The PSNR is ${Number.isFinite(psnr) ? `${psnr.toFixed(1)} dB` : "∞, since nothing differs"}. `
        + `The largest parallax error is ${short(largestParallaxError)} px.\n`
        + `naive took ${naiveMs.toFixed(0)} ms for both eyes.`;
}

/** @param {string} text */
function say(text) {
    element("busy").hidden = !text;
    element("busy").textContent = text;
}

/** @param {string} text */
function notice(text) {
    element("message").hidden = !text;
    element("message").firstElementChild.textContent = text;
}

/** @param {any} error */
async function failed(error) {
    if (error.name === "AbortError") return;
    console.error(error);
    if (error.name !== "RuntimeError") return notice(error.message);
    // The state of the engine's memory is unknown after such an error.
    engine.worker.terminate();
    engine = new Engine("engine.js");
    lost = 0;
    await openScene({ builtin: element("scene").options[0].value });
    notice(`The engine stopped (${error.message}): it ran out of memory or has a defect. `
        + "It was restarted with another scene.");
}

/** @param {any} source */
async function openScene(source) {
    if (running === "whole" || running === "refine") engine.stop();
    refining = false;
    const before = open;
    say("reading…");
    try {
        const { camera: own, info, warnings } = await engine.ask("open", { source, size: size() });
        open = { name: source.builtin ?? source.name, source, camera: own };
        camera = own;
        for (const [id, value] of [["e", 1], ["d", 0], ["lights", 0]]) element(id).value = value;
        // On a software adapter the first picture by paths takes a minute.
        element("light").value = info.physicallyBased && !adapter.software ? "paths" : "direct";
        element("scene").value = source.builtin ?? "";
        const counted = (count, one, many) => (count === 1 ? `1 ${one}` : `${count.toLocaleString("en")} ${many}`);
        const others = info.primitives - info.triangles;
        element("about").textContent = [source.builtin ? "" : open.name, counted(info.triangles, "triangle", "triangles"), others ? counted(others, "other shape", "other shapes") : ""].filter(Boolean).join(", ");
        element("warnings").hidden = !warnings.length;
        const parts = counted(warnings.length, "part of the file is", "parts of the file are");
        element("warnings").firstElementChild.textContent = `${parts} not shown as specified`;
        element("warnings").lastElementChild.replaceChildren(...warnings.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
        notice("");
        lookAhead();
        label();
        ask("whole");
    } catch (error) {
        // The previous scene is still open.
        element("scene").value = before.source?.builtin ?? "";
        await failed(error);
    } finally {
        say("");
    }
}

/** @param {{ path: string, file: File }[]} files */
async function openFiles(files) {
    try {
        await openScene(sourceOf(files));
    } catch (error) {
        await failed(error);
    }
}

/** @param {Blob} blob @param {string} name */
function download(blob, name) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

// --- Gestures ---

/** @type {Map<number, { x: number, y: number }>} */
const pointers = new Map();

canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
});
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => pointers.delete(/** @type {PointerEvent} */ (event).pointerId));
canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before || !camera) return;
    const after = { x: event.clientX, y: event.clientY };
    const height = canvas.clientHeight;
    const [dx, dy] = [(after.x - before.x) / height, (after.y - before.y) / height];
    const span = around();
    const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
    const apart = (point) => Math.max(1, Math.hypot(point.x - other.x, point.y - other.y));
    if (span) {
        const angle = head.pixel(1) / (other ? 2 : 1);
        if (other) head.zoom(apart(before) / apart(after));
        pointers.set(event.pointerId, after);
        head.turn(-dx * angle, dy * angle, span);
        return draw(swing);
    }
    if (other) {
        // Each of two fingers moves the middle by half of its own movement.
        camera = panned(nearer(camera, apart(before) / apart(after)), dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) {
        camera = panned(camera, dx, dy);
    } else {
        camera = orbited(camera, -Math.PI * dx, Math.PI * dy);
    }
    pointers.set(event.pointerId, after);
    moved();
});
canvas.addEventListener("wheel", (event) => {
    if (!camera) return;
    event.preventDefault();
    zoom(Math.exp(Math.max(-0.3, Math.min(0.3, event.deltaY * (event.deltaMode ? 0.04 : 0.0012)))));
}, { passive: false });

/** @param {HTMLInputElement} slider @param {number} steps */
function step(slider, steps) {
    slider.valueAsNumber += steps * Number(slider.step);
    moved();
}

/** @param {HTMLSelectElement} list */
function next(list) {
    list.selectedIndex = (list.selectedIndex + 1) % list.options.length;
    list.dispatchEvent(new Event("change"));
}

const KEYS = {
    ArrowLeft: () => turn(-0.08, 0), ArrowRight: () => turn(0.08, 0), ArrowUp: () => turn(0, 0.08), ArrowDown: () => turn(0, -0.08),
    "+": () => zoom(0.9), "=": () => zoom(0.9), "-": () => zoom(1 / 0.9),
    "[": () => step(element("e"), -2), "]": () => step(element("e"), 2), ",": () => step(element("d"), -1), ".": () => step(element("d"), 1),
    v: () => next(element("view")), m: () => next(element("method")), r: () => reset(),
};

/** @param {number} right @param {number} up */
function turn(right, up) {
    const span = around();
    if (span) {
        head.turn(right, up, span);
        return draw(swing);
    }
    if (camera) camera = orbited(camera, right, up);
    moved();
}

/** @param {number} factor */
function zoom(factor) {
    if (around()) {
        head.zoom(factor);
        return draw(swing);
    }
    if (camera) camera = nearer(camera, factor);
    moved();
}

/** Turns the head to where the planar camera looks. */
function lookAhead() {
    if (!camera) return;
    const { eye, target, up = [0, 1, 0] } = camera;
    const way = target.map((value, axis) => value - eye[axis]);
    const rise = way.reduce((sum, value, axis) => sum + value * up[axis], 0) / (Math.hypot(...way) * Math.hypot(...up));
    head.reset(Math.asin(Math.max(-1, Math.min(1, rise))));
}

function reset() {
    camera = open.camera;
    for (const id of ["e", "d"]) element(id).value = element(id).defaultValue;
    lookAhead();
    moved();
}

addEventListener("keydown", (event) => {
    const target = /** @type {HTMLElement} */ (event.target);
    if (event.ctrlKey || event.metaKey || event.altKey || !camera) return;
    // Input fields handle their own keys.
    if (target.matches("input, select, textarea") || (target !== canvas && event.key.startsWith("Arrow"))) return;
    const view = VIEWS[Number(event.key) - 1];
    if (view) {
        element("view").value = view;
        element("view").dispatchEvent(new Event("change"));
    } else if (KEYS[event.key]) {
        KEYS[event.key]();
    } else {
        return;
    }
    event.preventDefault();
});

// --- Files ---

let over = 0;
addEventListener("dragenter", (event) => {
    event.preventDefault();
    over += 1;
    element("drop").hidden = false;
});
addEventListener("dragleave", () => {
    over = Math.max(0, over - 1);
    element("drop").hidden = over === 0;
});
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", async (event) => {
    event.preventDefault();
    over = 0;
    element("drop").hidden = true;
    if (event.dataTransfer) await openFiles(await dropped(event.dataTransfer));
});
element("files").addEventListener("change", async () => {
    const files = [...element("files").files].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
    element("files").value = "";
    if (files.length) await openFiles(files);
});

// --- Settings and buttons ---

element("panel").addEventListener("submit", (event) => event.preventDefault());
element("scene").addEventListener("change", () => void openScene({ builtin: element("scene").value }));
for (const id of ["e", "d"]) element(id).addEventListener("input", moved);
for (const id of ["samples", "lights"]) {
    element(id).addEventListener("input", label);
    element(id).addEventListener("change", () => ask("whole"));
}
element("projection").addEventListener("change", lookAhead);
for (const id of ["method", "size", "light", "projection"]) element(id).addEventListener("change", () => { label(); ask("whole"); });
for (const id of ["view", "glasses"]) element(id).addEventListener("change", () => { label(); ask("show"); });
element("message").lastElementChild.addEventListener("click", () => notice(""));
element("stop").addEventListener("click", () => engine.stop());

element("compare").addEventListener("click", () => alone("comparing", async () => {
    const found = await engine.ask("compare");
    compared(found);
    element("view").value = "difference";
    label();
    put((await engine.ask("show", settings())).images, "difference", shownAs.around);
}));
element("save").addEventListener("click", () => alone("writing", async () => {
    const { around: span } = shownAs;
    // Players of equirectangular pictures know both views by such names.
    const [view, name] = span === 360 ? ["top-bottom", "360_TB"] : span ? ["side-by-side", "180x180_3dh"] : [settings().view, settings().view];
    download(await engine.ask("png", { ...settings(), view }), `${open.name}_${name}.png`);
}));
element("save-eyes").addEventListener("click", () => alone("writing", async () => {
    for (const view of ["left", "right"]) download(await engine.ask("png", { view }), `${open.name}_${view}.png`);
}));
element("quilt").addEventListener("click", () => alone("rendering a quilt", async (tell) => {
    const { columns, rows, size: quiltSize, interaxialPixels } = QUILT;
    if (around()) throw new Error("A quilt is planar: choose the planar projection.");
    const { interaxial: _, ...rest } = seen();
    const request = { camera: { ...rest, size: quiltSize, interaxialPixels }, options: settings().options, columns, rows, name: open.name };
    const { blob, name } = await engine.ask("quilt", request, tell);
    download(blob, name);
}));
element("measure").addEventListener("click", () => alone("measuring", async (tell) => {
    const { samples } = settings().options;
    const found = await engine.ask("measure", { camera: seen(), options: { samples }, rounds: ROUNDS }, tell);
    element("chart").hidden = false;
    element("plot").replaceChildren(plot(found));
    tabulate(found, element("chart").querySelector("table"));
    element("json").value = JSON.stringify(found, null, 1);
    element("chart").scrollIntoView({ behavior: "smooth" });
}));
element("report").addEventListener("click", () => alone("measuring this device", async (tell) => {
    const page = await engine.ask("report", {}, tell);
    download(new Blob([page], { type: "text/html" }), "stereotrace-report.html");
}));
element("copy").addEventListener("click", async () => {
    try {
        await navigator.clipboard.writeText(element("json").value);
        element("copied").textContent = "copied";
    } catch {
        element("json").select();
        element("copied").textContent = "copying failed; copy the selected text below";
    }
});
let resized = 0;
addEventListener("resize", () => {
    clearTimeout(resized);
    resized = setTimeout(() => { if (element("size").value === "auto") ask("whole"); }, 300);
});

// --- Begin ---

/** Returns what is missing if nothing can be rendered. */
function missing() {
    if (!isSecureContext) {
        return "This page needs WebGPU, which browsers offer only over https and on localhost. "
            + "Open the page at such an address.";
    }
    if (!("gpu" in navigator)) {
        return "This browser has no WebGPU, which this page needs. Chrome and Edge have it from version 113, "
            + "Safari from 26, and Firefox from 141 on Windows. In Firefox on other systems you may have to enable it.";
    }
    return "";
}

/** @param {HTMLSelectElement} list @param {string[]} names @param {string | null} chosen */
function fill(list, names, chosen) {
    list.replaceChildren(...names.map((name) => new Option(name)));
    if (chosen && names.includes(chosen)) list.value = chosen;
}

async function begin() {
    const fault = missing();
    if (fault) return nothing(fault);
    engine = new Engine("engine.js");
    const { adapter: found, builtins, methods, anaglyphs, version } = await engine.ask("begin");
    if (!found) {
        return nothing("This browser has WebGPU, but found no graphics adapter for it. The driver may be too old or "
            + "blocked, or hardware acceleration may be disabled in the browser's settings.");
    }
    adapter = found;
    fill(element("scene"), builtins, query.get("scene") ?? "hall");
    fill(element("method"), methods, query.get("method") ?? "auto");
    fill(element("glasses"), anaglyphs, query.get("glasses"));
    if (VIEWS.includes(query.get("view") ?? "")) element("view").value = query.get("view");
    if (["360", "180"].includes(query.get("projection") ?? "")) element("projection").value = query.get("projection");
    const asked = query.get("size");
    if (asked && /^\d{2,4}x\d{2,4}$/.test(asked)) {
        if (![...element("size").options].some((option) => option.value === asked)) element("size").add(new Option(asked));
        element("size").value = asked;
    }
    const { vendor, architecture, device, description, software, timestamps } = found;
    const name = [vendor, architecture, device, description].filter(Boolean).join(" ") || "an unnamed adapter";
    element("adapter").textContent = `stereotrace ${version} on ${name}.`
        + (software ? " It is a software adapter. Pictures take a second or more, but milliseconds on a GPU." : "")
        + (timestamps ? "" : " It has no timestamps, so times are of whole frames and include the browser's overhead.");
    await openScene({ builtin: element("scene").value });
}

/** @param {string} text */
function nothing(text) {
    notice(text);
    for (const field of element("panel").elements) field.disabled = true;
    document.documentElement.dataset.state = "nothing";
}

begin().catch((error) => nothing(error.message));
