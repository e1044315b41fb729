// Shows the last pair in the chosen view: a picture with a divider between the eyes, eyes by turns, or one picture.
// @ts-check
import { Head } from "./head.js";
import { isPacked, size } from "./settings.js";
import { element, state } from "./state.js";

const WIGGLE_MS = 180;

const canvas = /** @type {HTMLCanvasElement} */ (element("picture"));
const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
const marked = /** @type {HTMLCanvasElement} */ (element("traced"));
const divider = element("divider");

export const head = new Head();

/** Turns the head to where the planar camera looks. */
export function lookAhead() {
    if (!state.camera) return;
    const { eye, target, up = [0, 1, 0] } = state.camera;
    const way = target.map((value, axis) => value - eye[axis]);
    const rise = way.reduce((sum, value, axis) => sum + value * up[axis], 0) / (Math.hypot(...way) * Math.hypot(...up));
    head.reset(Math.asin(Math.max(-1, Math.min(1, rise))));
}

/** The shown pictures, and a picture of the right pixels that were traced again, which is transparent elsewhere. */
let images = /** @type {ImageBitmap[]} */ ([]);
let traced = /** @type {ImageBitmap | null} */ (null);
/** How the images show their views: their view, their projection, and how many are side by side. */
let shownAs = {
    view: /** @type {import("./settings.js").View} */ ("left"),
    around: /** @type {360 | 180 | null} */ (null),
    views: 1,
};
let swing = 0;
/** Whether nothing moves by itself. Who prefers reduced motion starts the motion. */
let still = matchMedia("(prefers-reduced-motion: reduce)").matches;

/** The projection of the shown pair. */
export const shownAround = () => shownAs.around;

/**
 * @param {{ images: ImageBitmap[], traced?: ImageBitmap | null }} next
 * @param {import("./settings.js").View} shown @param {360 | 180 | null} span
 */
export function put(next, shown, span) {
    for (const image of [...images, traced]) image?.close();
    head.forget();
    images = next.images;
    traced = next.traced ?? null;
    shownAs = { view: shown, around: span, views: isPacked(shown) ? 2 : 1 };
    swing = 0;
    element("poster").hidden = true;
    canvas.hidden = false;
    const hasDivider = shown === "slider";
    for (const part of [divider, element("eyes")]) part.hidden = !hasDivider;
    if (traced) {
        [marked.width, marked.height] = [traced.width, traced.height];
        marked.getContext("2d")?.drawImage(traced, 0, 0);
    }
    draw();
    motion();
}

/** Returns a picture, or the part of it that the head sees. @param {ImageBitmap} picture */
function sight(picture) {
    const { around, views } = shownAs;
    // Without WebGL the whole picture is shown.
    return (around && head.see(picture, views, around, size())) || picture;
}

/** Draws the pictures again, for another head, divider or eye. */
export function draw() {
    if (!images.length) return;
    const turns = shownAs.view === "wiggle";
    const image = sight(images[turns ? swing % images.length : 0]);
    const { width, height } = image;
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    element("screen").style.setProperty("--aspect", String(width / height));
    context.drawImage(image, 0, 0);
    const share = shownAs.view === "slider" ? divider.valueAsNumber / 100 : 0;
    if (shownAs.view === "slider") {
        const left = Math.round(width * share);
        const right = sight(images[1]);
        if (left < width) context.drawImage(right, left, 0, width - left, height, left, 0, width - left, height);
        divider.setAttribute("aria-valuetext", `left eye in ${divider.value}% of the width`);
    }
    marked.style.setProperty("--divider", `${100 * share}%`);
    const rightIsSeen = !turns || swing % images.length === 1;
    marked.hidden = !(traced && rightIsSeen && element("marked").checked);
}

/** Offers the pause where something moves by itself. */
export function motion() {
    const moves = shownAs.view === "wiggle" || Boolean(traced && element("marked").checked);
    const button = element("pause");
    button.hidden = !moves;
    button.setAttribute("aria-pressed", String(still));
    document.documentElement.classList.toggle("still", still);
}

setInterval(() => {
    if (shownAs.view !== "wiggle" || images.length < 2 || still || document.hidden) return;
    swing += 1;
    draw();
}, WIGGLE_MS);

divider.addEventListener("input", draw);
element("pause").addEventListener("click", () => {
    still = !still;
    motion();
});
element("marked").addEventListener("change", () => {
    draw();
    motion();
});

// Before the first picture the frame already has its shape.
const [width, height] = size();
element("screen").style.setProperty("--aspect", String(width / height));
