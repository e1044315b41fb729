// Opens scenes: built-in ones, files from this device, and a model from an address.
// @ts-check
import { faulted } from "./embed.js";
import { MOST_LINKED, fetched, source as sourceOf } from "./files.js";
import { apply, linked, sized } from "./link.js";
import { lookAhead } from "./picture.js";
import { again, ask, holds, proceed, read, replaced } from "./render.js";
import { label } from "./settings.js";
import { element, notice, say, state } from "./state.js";

/** The scene of an address that names none. */
export const FIRST_SCENE = "hall";
/** Number of times that the engine is restarted before a picture succeeds. */
const MOST_RESTARTS = 2;

/** The request for a scene that has not ended yet. A newer one aborts it. */
let request = /** @type {AbortController | null} */ (null);

/** Whether another scene is being opened. */
export const opening = () => request !== null;

/**
 * Carries out a request for a scene. If it fails, the scene before is shown again.
 * @param {(signal: AbortSignal) => Promise<string>} work it returns what is wrong with the request's values
 */
async function requested(work) {
    request?.abort();
    const mine = (request = new AbortController());
    try {
        return await work(mine.signal);
    } catch (error) {
        if (error.name !== "AbortError") console.error(error);
        return mine.signal.aborted ? "" : await unopened(error, mine.signal);
    } finally {
        if (request === mine) {
            request = null;
            say("");
            proceed();
        }
    }
}

/** Says why a scene was not opened, and returns it. @param {any} error @param {AbortSignal} signal */
async function unopened(error, signal) {
    let text = error.name === "AbortError" ? "" : words(error);
    let lasts = false;
    try {
        lasts = await restored(signal);
    } catch (worse) {
        if (signal.aborted) return "";
        // The engine has no scene.
        state.camera = null;
        text = words(worse);
    }
    if (text) notice(text, { lasts });
    return text;
}

/** Shows the scene before again, and returns whether it has to be rendered. @param {AbortSignal} signal */
async function restored(signal) {
    const { source } = state.open;
    if (source && !holds(source)) await read(source, signal);
    signal.throwIfAborted();
    element("scene").value = source?.builtin ?? "";
    return again();
}

/** Gives up the scene that is being opened. */
export const givenUp = () =>
    requested(async (signal) => {
        await restored(signal);
        return "";
    });

/** Opens the scene again in a new engine. Nothing is rendered until something changes. */
export const reopened = () =>
    requested(async (signal) => {
        if (state.open.source) await read(state.open.source, signal);
        return "";
    });

/**
 * Opens a scene, with the values of a link. Only the newest of several requests is opened.
 * @param {any} source @param {URLSearchParams} [values] @returns {Promise<string>} what is wrong with them
 */
export const openScene = (source, values = new URLSearchParams()) =>
    requested((signal) => opened(source, values, signal));

/** @param {any} source @param {URLSearchParams} values @param {AbortSignal} signal */
async function opened(source, values, signal) {
    if (state.fault) throw new Error(`The scene can't be shown. ${state.fault}`);
    say("reading…");
    document.documentElement.dataset.state = "opening";
    sized(values.get("size"));
    const { camera, info, warnings } = await read(source, signal);
    signal.throwIfAborted();
    // On a software adapter the first picture by paths takes a minute.
    const light = info.physicallyBased && !state.adapter.software ? "paths" : "direct";
    state.open = { name: source.builtin ?? source.name, source, camera, light };
    state.camera = camera;
    element("light").value = light;
    for (const id of ["e", "d", "lights"]) element(id).value = element(id).defaultValue;
    element("scene").value = source.builtin ?? "";
    notice("");
    lookAhead();
    const faults = apply(values).join("\n");
    if (faults) notice(faults, { lasts: true });
    describe(info, warnings);
    label();
    ask("whole");
    return faults;
}

/** @param {any} info @param {string[]} warnings */
function describe(info, warnings) {
    const { name, source } = state.open;
    const counted = (count, one, many) => (count === 1 ? `1 ${one}` : `${count.toLocaleString("en")} ${many}`);
    const others = info.primitives - info.triangles;
    const parts = [
        source.builtin ? "" : name,
        counted(info.triangles, "triangle", "triangles"),
        others ? counted(others, "other shape", "other shapes") : "",
    ];
    element("about").textContent = parts.filter(Boolean).join(", ");
    element("warnings").hidden = !warnings.length;
    const left = counted(warnings.length, "part of the file is", "parts of the file are");
    element("warnings").firstElementChild.textContent = `${left} not shown as specified`;
    element("warnings").lastElementChild.replaceChildren(
        ...warnings.map((text) => {
            const item = document.createElement("li");
            item.textContent = text;
            return item;
        }),
    );
}

/** @param {{ path: string, file: File }[]} files */
export const openFiles = (files) =>
    requested(async (signal) => {
        say("reading…");
        // Without an engine, the reason is said instead of what the files lack.
        const source = state.fault ? {} : await sourceOf(files, signal);
        return opened(source, new URLSearchParams(), signal);
    });

/**
 * Opens the scene that a link names: a model's address, a built-in scene, or the first one.
 * @param {URLSearchParams} values @returns {Promise<string>} what is wrong with them
 */
export const openLinked = (values) =>
    requested(async (signal) => {
        const model = values.get("model");
        const scenes = [...element("scene").options].map((option) => option.value);
        const scene = values.get("scene") ?? FIRST_SCENE;
        let fault = scenes.includes(scene)
            ? ""
            : `scene=${scene}: there is no such scene. The scenes are ${scenes.join(", ")}.`;
        if (model) {
            try {
                say("fetching the model…");
                const tell = (/** @type {number} */ share) => say(`fetching the model… ${Math.round(100 * share)}%`);
                const file = await fetched(model, signal, tell);
                const source = await sourceOf([{ path: file.name, file }], signal, MOST_LINKED);
                return await opened({ ...source, address: model }, values, signal);
            } catch (error) {
                signal.throwIfAborted();
                console.error(error);
                fault = `model=${model}: ${words(error)}`;
            }
        }
        const builtin = scenes.includes(scene) ? scene : FIRST_SCENE;
        // The address keeps the model, so that it can be loaded again.
        const others = await opened(model ? { builtin, address: model } : { builtin }, values, signal);
        const faults = [fault, others].filter(Boolean).join("\n");
        if (fault) notice(faults, { lasts: true });
        return faults;
    });

/** @param {any} error */
const words = (error) =>
    error.name === "RuntimeError"
        ? `The engine stopped (${error.message}): it ran out of memory or has a defect.`
        : error.message;

/** Says why something was not rendered. @param {any} error */
export async function failed(error) {
    if (error.name === "AbortError") return;
    console.error(error);
    const text = words(error);
    if (linked()) faulted(text);
    if (error.name !== "RuntimeError") return notice(text);
    // The state of the engine's memory is unknown after such an error.
    replaced();
    state.restarts += 1;
    if (state.restarts > MOST_RESTARTS) {
        state.camera = null;
        return notice(`${text} It did so again after each restart. Choose another scene to try again.`, {
            lasts: true,
        });
    }
    await openScene({ builtin: element("scene").options[0].value });
    notice(`${text} It was restarted with another scene.`, { lasts: true });
}
