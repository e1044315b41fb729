// Moves the camera by drags, fingers, wheel and keys; in pictures all around, turns the head.
// @ts-check
import { remember } from "./link.js";
import { limited, nearer, orbited, panned } from "./orbit.js";
import { draw, head, lookAhead } from "./picture.js";
import { moved } from "./render.js";
import { VIEWS, around } from "./settings.js";
import { element, state } from "./state.js";

/** @typedef {import("./pkg/index.js").Camera} Camera */

const canvas = /** @type {HTMLCanvasElement} */ (element("picture"));
/** @type {Map<number, { x: number, y: number }>} */
const pointers = new Map();

/** Moves the camera. @param {(camera: Camera) => Camera} move */
export function steer(move) {
    const {
        camera,
        open: { camera: own },
    } = state;
    if (!camera || !own) return;
    state.camera = limited(move(camera), own);
    moved();
}

/** Turns the head, in radians. @param {number} right @param {number} up @param {360 | 180} span */
export function look(right, up, span) {
    head.turn(right, up, span);
    draw();
    remember();
}

canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
});
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
for (const name of /** @type {const} */ (["pointerup", "pointercancel"])) {
    canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
}
canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before || !state.camera) return;
    const after = { x: event.clientX, y: event.clientY };
    const height = canvas.clientHeight;
    const [dx, dy] = [(after.x - before.x) / height, (after.y - before.y) / height];
    const span = around();
    const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
    const apart = (point) => Math.max(1, other ? Math.hypot(point.x - other.x, point.y - other.y) : 1);
    pointers.set(event.pointerId, after);
    if (span) {
        const angle = head.pixel(1) / (other ? 2 : 1);
        if (other) head.zoom(apart(before) / apart(after));
        look(-dx * angle, dy * angle, span);
    } else if (other) {
        // Each of two fingers moves the middle by half of its own movement.
        steer((camera) => panned(nearer(camera, apart(before) / apart(after)), dx / 2, dy / 2));
    } else if (event.shiftKey || event.buttons & 6) {
        steer((camera) => panned(camera, dx, dy));
    } else {
        steer((camera) => orbited(camera, -Math.PI * dx, Math.PI * dy));
    }
});
canvas.addEventListener(
    "wheel",
    (event) => {
        if (!state.camera) return;
        event.preventDefault();
        zoom(Math.exp(Math.max(-0.3, Math.min(0.3, event.deltaY * (event.deltaMode ? 0.04 : 0.0012)))));
    },
    { passive: false },
);

/** @param {HTMLInputElement} slider @param {number} steps */
function step(slider, steps) {
    slider.valueAsNumber += steps * Number(slider.step);
    moved();
}

/** @param {HTMLSelectElement} list @param {number} index */
function select(list, index) {
    list.selectedIndex = index % list.options.length;
    list.dispatchEvent(new Event("change"));
}

/** @param {number} right @param {number} up */
function turn(right, up) {
    const span = around();
    if (span) look(right, up, span);
    else steer((camera) => orbited(camera, right, up));
}

/** @param {number} factor */
function zoom(factor) {
    const span = around();
    if (!span) return steer((camera) => nearer(camera, factor));
    head.zoom(factor);
    look(0, 0, span);
}

function reset() {
    state.camera = state.open.camera;
    for (const id of ["e", "d"]) element(id).value = element(id).defaultValue;
    lookAhead();
    moved();
}

/** @type {Record<string, () => void>} */
const KEYS = {
    ArrowLeft: () => turn(-0.08, 0),
    ArrowRight: () => turn(0.08, 0),
    ArrowUp: () => turn(0, 0.08),
    ArrowDown: () => turn(0, -0.08),
    "+": () => zoom(0.9),
    "=": () => zoom(0.9),
    "-": () => zoom(1 / 0.9),
    "[": () => step(element("e"), -2),
    "]": () => step(element("e"), 2),
    ",": () => step(element("d"), -1),
    ".": () => step(element("d"), 1),
    v: () => select(element("view"), element("view").selectedIndex + 1),
    m: () => select(element("method"), element("method").selectedIndex + 1),
    r: () => reset(),
};

// Keys act while the picture has the focus, so that they neither disturb screen readers nor spoken commands.
canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !state.camera) return;
    const view = Number(event.key) - 1;
    if (view >= 0 && view < Object.keys(VIEWS).length) select(element("view"), view);
    else if (KEYS[event.key]) KEYS[event.key]();
    else return;
    event.preventDefault();
});
