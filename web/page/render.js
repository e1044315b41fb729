// Decides what is rendered next: the newest wish alone. Drafts are shown while something moves.
// @ts-check
import { Engine } from "./client.js";
import { told } from "./embed.js";
import { compared, figures, tell as tellCost } from "./figures.js";
import { remember } from "./link.js";
import { failed, givenUp, opening, reopened } from "./models.js";
import { put, shownAround } from "./picture.js";
import { PATHS, label, light, marks, renderedSize, seen, settings, size } from "./settings.js";
import { element, engine, notice, say, state, succeeded } from "./state.js";

/** Maximum time of a frame while something is dragged, in milliseconds. */
const DRAFT_MS = 80;
/** Drafts of at least so many pixels recall the draft before, within so many MiB. Smaller ones take as long without. */
const RECALLED = { pixels: 2 ** 18, history: 512 };
/** Time until an engine that does not stop is replaced. It can't stop while the driver compiles kernels. */
const STOP_MS = 2000;

let wish = /** @type {"draft" | "whole" | "show" | null} */ (null);
let running = /** @type {"draft" | "whole" | "refine" | "other" | null} */ (null);
/** Whether the last picture is refined while nothing else is asked for. */
let refining = false;
/** Whether a task waits for the engine, or uses it. */
let paused = false;
/** Number of scenes that the engine opens, or that wait for it. */
let reading = 0;
/** What is open in which engine. */
let held = {
    engine: /** @type {Engine | null} */ (null),
    source: /** @type {any} */ (null),
};
let settle = 0;
/** Milliseconds per pixel of the last frame. */
let pixelMs = 0;
/** Devices that the engine has lost. */
let lost = 0;
/** Whether the engine has a pair that it can show. */
let drawn = false;
/** Size of the last picture, before it was scaled for a draft. */
let rendered = "";

/** Says what is being rendered. What is said about a scene that is being opened stays there. @param {string} text */
function tell(text) {
    if (!opening()) say(text);
}

/** Asks for a draft soon, and for a whole picture once nothing moves. */
export function moved() {
    label();
    clearTimeout(settle);
    settle = setTimeout(() => ask("whole"), 160);
    ask("draft");
}

/** @param {"draft" | "whole" | "show"} what */
export function ask(what) {
    if (!state.camera) return;
    if (!drawn && what === "show") what = "whole";
    // Rendering also shows the last pair in the chosen view, so it replaces a wish to show.
    if (wish === null || what !== "show") wish = what;
    if (running === "refine" || (running === "whole" && what !== "show")) engine().stop();
    if (what !== "show") refining = false;
    remember();
    if (running === null) void work();
}

/** Whether a picture would have another size than the last one. */
export const resized = () => String(renderedSize()) !== rendered;

/** Asks for a picture if there is none of the open scene, and returns whether there is none. */
export function again() {
    if (!drawn) ask("whole");
    return !drawn;
}

/** Goes on with what was asked for while a scene was being opened. */
export function proceed() {
    if (running === null) void work();
}

async function work() {
    while (!paused && !reading && (wish || refining)) {
        const what = wish ?? "refine";
        wish = null;
        running = what === "show" ? "other" : what;
        try {
            if (what === "show") await show();
            else if (what === "refine") await refine();
            else await render(what === "draft");
        } catch (error) {
            if (error.name !== "AbortError") refining = false;
            // It may open another scene, which waits until nothing is running.
            void failed(error);
        }
        running = null;
    }
}

/**
 * Waits until nothing is rendered.
 * @param {number} most milliseconds @returns {Promise<boolean>} whether it came to that
 */
async function idle(most) {
    const end = performance.now() + most;
    while (running && performance.now() < end) await new Promise((done) => setTimeout(done, 20));
    return !running;
}

/**
 * Ends the current work, and returns whether the engine had to be replaced. Its scene is then to be opened again.
 * @param {AbortSignal} [signal] of who waits
 */
async function ended(signal) {
    wish = null;
    refining = false;
    clearTimeout(settle);
    if (!running) return false;
    engine().stop();
    if ((await idle(STOP_MS)) || signal?.aborted) return false;
    replaced();
    await idle(Infinity);
    return true;
}

/** Whether the engine has a scene. @param {any} source */
export const holds = (source) => held.engine === state.engine && held.source === source;

/**
 * Opens a scene in the engine, once nothing else is done there.
 * @param {any} source @param {AbortSignal} signal
 */
export async function read(source, signal) {
    reading += 1;
    try {
        await ended(signal);
        signal.throwIfAborted();
        return await handed(source);
    } finally {
        reading -= 1;
    }
}

/** Hands a scene to the engine. An engine that stops over it is replaced. @param {any} source */
async function handed(source) {
    const before = held;
    const now = { engine: state.engine, source: null };
    [running, drawn, held] = ["other", false, now];
    try {
        const found = await engine().ask("open", { source, size: size() });
        now.source = source;
        return found;
    } catch (error) {
        // The scene before is still open.
        held = before;
        if (error.name === "RuntimeError") replaced();
        throw error;
    } finally {
        running = null;
    }
}

/** Replaces the engine by a new one, which has no scene. */
export function replaced() {
    engine().end();
    state.engine = new Engine();
    [wish, refining, drawn, lost] = [null, false, false, 0];
}

/** Stops whatever is being done, even a compilation. */
export async function stop() {
    if (opening()) {
        await givenUp();
        if (opening()) return;
        return notice(`Opening was stopped.${state.camera ? "" : " Choose another scene."}`, { lasts: true });
    }
    if (await ended()) void reopened();
    notice("Rendering was stopped. Change something to render again.");
}

/** Adds a pass to the last picture. */
async function refine() {
    const { view, glasses } = settings();
    const done = await engine().ask("refine", { view, glasses, marks: marks(), first: PATHS.first });
    put(done, view, shownAround());
    figures(
        { ...done, deviceMs: undefined, statistics: { ...done.statistics, passes: undefined } },
        seen().size ?? [],
        1,
    );
    refining &&= done.paths < PATHS.last;
}

/** @param {boolean} draft */
async function render(draft) {
    const { view, glasses, lights, options } = settings();
    const [width, height] = renderedSize();
    rendered = String([width, height]);
    const scale = draft ? draftScale(width * height * options.samples) : 1;
    const text = !pixelMs ? "preparing the first picture" : "rendering";
    const busy = setTimeout(() => tell(`${text}…`), 400);
    const byPaths = element("light").value === "paths";
    const history = draft && width * height * scale ** 2 >= RECALLED.pixels ? RECALLED.history : null;
    const request = {
        camera: seen(scale),
        lights,
        glasses,
        view,
        marks: marks(),
        options: { ...options, history, ...(draft && scale < 1 ? { samples: 1, ...light(PATHS.draft) } : {}) },
        paths: byPaths && !draft,
        compare: view === "difference" && !draft,
    };
    const size = request.camera.size ?? [1, 1];
    try {
        const done = await engine().ask("render", request, (share) => tell(`${text}… ${Math.round(100 * share)}%`));
        put(done, view, request.camera.projection ?? null);
        drawn = true;
        pixelMs = done.ms / (size[0] * size[1] * request.options.samples);
        figures(done, size, scale);
        compared(done.difference ? done : null);
        refining = request.paths && view !== "difference" && (wish === null || wish === "show");
        succeeded();
        if (done.lost > lost) notice("The graphics device was lost, and was opened again.");
        lost = done.lost;
        if (!draft) tellCost(done);
        // A picture that is already outdated is not the one that was asked for.
        if (!opening() && (wish === null || wish === "show")) {
            document.documentElement.dataset.state = draft ? "draft" : "whole";
            if (!draft) told(done);
        }
    } finally {
        clearTimeout(busy);
        tell("");
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
export async function show() {
    const { view, glasses } = settings();
    if (view === "difference") {
        refining = false;
        compared(await engine().ask("compare"));
    }
    put(await engine().ask("show", { view, glasses, marks: marks() }), view, shownAround());
}

/**
 * Runs a task of the engine while no picture is rendered.
 * @param {string} text @param {(tell: (done: number) => void) => Promise<void>} task
 */
export async function alone(text, task) {
    paused = true;
    if (running) engine().stop();
    await idle(Infinity);
    running = "other";
    tell(`${text}…`);
    const buttons = ["compare", "measure", "report", "save", "save-eyes", "quilt"].map(element);
    for (const button of buttons) button.disabled = true;
    try {
        await task((share) => tell(`${text}… ${Math.round(100 * share)}%`));
    } catch (error) {
        void failed(error);
    } finally {
        running = null;
        paused = false;
        for (const button of buttons) button.disabled = false;
        tell("");
        proceed();
    }
}
