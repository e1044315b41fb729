// What the parts of the page share: its elements and notices, the engine, and the open scene.
// @ts-check

/** @typedef {import("./pkg/index.js").Camera} Camera */

/** @param {string} id @returns {any} */
export const element = (id) => document.getElementById(id);

export const state = {
    engine: /** @type {import("./client.js").Engine | null} */ (null),
    /** Why nothing can be rendered. */
    fault: "",
    adapter: { software: false },
    /** Number of times that the engine was restarted since a picture succeeded. */
    restarts: 0,
    /** The open scene. Its camera has the values that the sliders multiply. */
    open: { name: "", source: /** @type {any} */ (null), camera: /** @type {Camera | null} */ (null), light: "direct" },
    /** The current camera, before the sliders. */
    camera: /** @type {Camera | null} */ (null),
};

/** Returns the engine. Throws an error that says why there is none. */
export function engine() {
    if (!state.engine) throw new Error(state.fault || "The engine is still being loaded.");
    return state.engine;
}

/** @param {string} text */
export function say(text) {
    element("busy").hidden = !text;
    element("busy").firstElementChild.textContent = text;
}

/** Whether a picture that succeeds leaves the notice there. */
let lasting = false;

/** Shows a notice. @param {string} text @param {{ lasts?: boolean }} [how] */
export function notice(text, { lasts = false } = {}) {
    lasting = lasts;
    element("message").hidden = !text;
    element("message").firstElementChild.textContent = text;
}

/** Removes a notice about something that has succeeded since. */
export function succeeded() {
    state.restarts = 0;
    if (!lasting) notice("");
}

/** @param {number} value */
export const short = (value) => Number(value.toPrecision(3)).toString();

/** @param {Blob} blob @param {string} name */
export function download(blob, name) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
