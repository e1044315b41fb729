// Reads the settings from the page's fields, and updates the words beside them.
// @ts-check
import { element, short, state } from "./state.js";

/** @typedef {import("./pkg/index.js").Camera} Camera */
/** @typedef {keyof typeof VIEWS} View */

/** Ways to show a pair, the first one at first. */
export const VIEWS = /** @type {const} */ ({
    slider: "left and right, by a divider",
    wiggle: "left and right by turns",
    anaglyph: "anaglyph, for coloured glasses",
    "side-by-side": "side by side",
    "cross-eyed": "cross-eyed",
    left: "left eye",
    right: "right eye",
    retrace: "re-trace map",
    shadows: "shadow map",
    difference: "difference from naive",
});
/** @type {Partial<Record<View, string>>} */
const LEGENDS = {
    "side-by-side": "Look through the screen, with each eye at its own picture.",
    "cross-eyed": "Cross your eyes until the two pictures merge into one.",
    retrace:
        "The map shows the source of each right pixel. Green pixels were reused from the left view, or found " +
        "within the left view's depth bound. Red and yellow pixels were traced because reuse failed. Grey pixels " +
        "were traced without reuse.",
    shadows:
        "The map shows the source of the right view's shadows with bracket. Green pixels reused visibility bits of " +
        "the left view. Red pixels traced shadow rays.",
    difference: "The right view is compared with naive. Equal pixels are dark, and different pixels are yellow to red.",
};
/** Views that show right pixels as they are, so that those that were traced again can be marked. */
const MARKED = /** @type {readonly View[]} */ (["slider", "wiggle", "right"]);
/** Light by paths: paths of drafts, of the first picture and of the last, and bounces. */
export const PATHS = { draft: 2, first: 4, last: 256, bounces: 3 };
/** Largest side of an automatically sized picture, on software adapters and on others. */
const MOST_SIDE = { software: 512, hardware: 1600 };
/** Height of an automatically sized equirectangular view, on software adapters and on others. */
const AROUND_HEIGHT = { software: 384, hardware: 2048 };

export const view = () => /** @type {View} */ (element("view").value);

export const settings = () => ({
    view: view(),
    glasses: element("glasses").value,
    lights: Number(element("lights").value),
    options: { method: element("method").value, samples: Number(element("samples").value) ** 2, ...light(PATHS.first) },
});

/** Returns the options of the chosen light. @param {number} paths */
export const light = (paths) =>
    element("light").value === "paths" ? { lighting: `paths=${paths}:${PATHS.bounces}`, denoise: true } : {};

/** Returns whether pixels that were traced again are marked in the chosen view. */
export const marks = () => MARKED.includes(view()) && !around();

/** Whether a view has both eyes beside each other. @param {View} shown */
export const isPacked = (shown) => shown === "side-by-side" || shown === "cross-eyed";

/** Width and height of a whole picture. */
export function size() {
    const chosen = element("size").value;
    if (chosen !== "auto") return chosen.split("x").map(Number);
    const full = document.fullscreenElement;
    const width = element("frame").clientWidth / (full && isPacked(view()) ? 2 : 1);
    const height = full ? innerHeight : Math.max(200, Math.min(0.75 * width, 0.72 * innerHeight));
    const most = state.adapter.software ? MOST_SIDE.software : MOST_SIDE.hardware;
    const scale = Math.min(devicePixelRatio, most / Math.max(width, height));
    return [width, height].map((side) => Math.max(16, Math.round(side * scale)));
}

/**
 * The chosen equirectangular projection: 360 or 180 degrees, or null for planar pictures.
 * @returns {360 | 180 | null}
 */
export const around = () =>
    element("projection").value === "planar" ? null : /** @type {360 | 180} */ (Number(element("projection").value));

/** Width and height of a whole view as it is rendered. */
export function renderedSize() {
    const span = around();
    if (!span) return size();
    const automatic = state.adapter.software ? AROUND_HEIGHT.software : AROUND_HEIGHT.hardware;
    const height = element("size").value === "auto" ? automatic : size()[1];
    return [(height * span) / 180, height];
}

/** Returns the camera with the sliders' values. @param {number} scale @returns {Camera} */
export function seen(scale = 1) {
    const { camera } = state;
    if (!camera) throw new Error("no scene is open");
    const [e, d] = [Number(element("e").value), 2 ** Number(element("d").value)];
    const [width, height] = renderedSize().map((side) => Math.max(16, Math.round(side * scale)));
    const span = around();
    const interaxial = (camera.interaxial ?? 0) * e;
    if (span)
        return {
            eye: camera.eye,
            target: camera.target,
            up: camera.up,
            size: [width, height],
            interaxial,
            projection: span,
        };
    return { ...camera, size: [width, height], interaxial, screenDistance: (camera.screenDistance ?? 1) * d };
}

/** Updates the words beside the fields, and which fields are there. */
export function label() {
    if (!state.camera) return;
    const { interaxial = 0, screenDistance = 1, size: [width, height] = [1, 1], fov = 45 } = seen();
    const across = (2 * screenDistance * Math.tan((fov * Math.PI) / 360) * width) / height;
    const {
        options: { samples },
        lights,
    } = settings();
    value("e", around() ? short(interaxial) : `${short(interaxial)}, ${short((interaxial * width) / across)} px`);
    value("d", short(screenDistance));
    value("samples", String(samples));
    value("lights", lights ? String(lights) : "from the scene");
    element("d-row").hidden = Boolean(around());
    element("around-hint").hidden = !around();
    element("light-hint").hidden = element("light").value !== "paths";
    element("glasses-row").hidden = view() !== "anaglyph";
    element("marked-row").hidden = !marks();
    const legend = LEGENDS[view()];
    element("legend").hidden = !legend;
    element("legend").textContent = legend ?? "";
}

/** Shows a slider's value beside it, and says it to screen readers. @param {string} id @param {string} text */
function value(id, text) {
    element(`${id}-value`).value = text;
    element(id).setAttribute("aria-valuetext", text);
}
