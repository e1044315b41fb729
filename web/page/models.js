// Opens scenes: built-in ones, files from this device, and a model from an address.
// @ts-check
import { fetched, source as sourceOf } from "./files.js";
import { lookAhead } from "./gestures.js";
import { apply, sized } from "./link.js";
import { ask, cleared, replaced } from "./render.js";
import { label, size } from "./settings.js";
import { element, engine, notice, say, state } from "./state.js";

/** The scene of an address that names none. */
export const FIRST_SCENE = "hall";

/** Number of scenes that were asked for, and of those that are not open yet. */
let [asked, waiting] = [0, 0];

/** Whether another scene is being opened. */
export const opening = () => waiting > 0;

/**
 * Opens a scene, with the values of a link. Only the newest of several requests is opened.
 * @param {any} source @param {URLSearchParams} [values] @returns {Promise<string>} what is wrong with them
 */
export async function openScene(source, values = new URLSearchParams()) {
    const mine = ++asked;
    waiting += 1;
    const before = state.open;
    const { dataset } = document.documentElement;
    const shown = dataset.state;
    try {
        if (state.fault) throw new Error(`The scene can't be shown. ${state.fault}`);
        say("reading…");
        dataset.state = "opening";
        await cleared();
        if (mine !== asked) return "";
        sized(values.get("size"));
        const { camera, info, warnings } = await engine().ask("open", { source, size: size() });
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
    } catch (error) {
        // The previous scene is still open.
        if (mine === asked) dataset.state = shown ?? "";
        element("scene").value = before.source?.builtin ?? "";
        await failed(error);
        return error.name === "AbortError" ? "" : error.message;
    } finally {
        waiting -= 1;
        if (mine === asked) say("");
    }
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
export async function openFiles(files) {
    try {
        // Without an engine, the reason is said instead of what the files lack.
        await openScene(state.fault ? {} : await sourceOf(files));
    } catch (error) {
        await failed(error);
    }
}

/**
 * Opens the scene that a link names: a model's address, a built-in scene, or the first one.
 * @param {URLSearchParams} values @returns {Promise<string>} what is wrong with them
 */
export async function openLinked(values) {
    const model = values.get("model");
    const scenes = [...element("scene").options].map((option) => option.value);
    const scene = values.get("scene") ?? FIRST_SCENE;
    let fault = scenes.includes(scene)
        ? ""
        : `scene=${scene}: there is no such scene. The scenes are ${scenes.join(", ")}.`;
    if (model) {
        try {
            say("fetching the model…");
            const file = await fetched(model, (share) => say(`fetching the model… ${Math.round(100 * share)}%`));
            return await openScene({ ...(await sourceOf([{ path: file.name, file }])), address: model }, values);
        } catch (error) {
            fault = `model=${model}: ${error.message}`;
        } finally {
            say("");
        }
    }
    const others = await openScene({ builtin: scenes.includes(scene) ? scene : FIRST_SCENE }, values);
    const faults = [fault, others].filter(Boolean).join("\n");
    if (fault) notice(faults, { lasts: true });
    return faults;
}

/** Opens the scene again in a new engine. */
export async function reopened() {
    const { source } = state.open;
    try {
        if (source) await engine().ask("open", { source, size: size() });
    } catch (error) {
        await failed(error);
    }
}

/** @param {any} error */
export async function failed(error) {
    if (error.name === "AbortError") return;
    console.error(error);
    if (error.name !== "RuntimeError") return notice(error.message);
    // The state of the engine's memory is unknown after such an error.
    replaced();
    await openScene({ builtin: element("scene").options[0].value });
    notice(
        `The engine stopped (${error.message}): it ran out of memory or has a defect. ` +
            "It was restarted with another scene.",
        { lasts: true },
    );
}
