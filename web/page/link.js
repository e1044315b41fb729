// A view is a link: its scene, camera and settings are in the page's address.
// @ts-check
import { distance, limited, steep } from "./orbit.js";
import { head, lookAhead } from "./picture.js";
import { around } from "./settings.js";
import { element, state } from "./state.js";

/** Browsers allow some hundred changes of the address per minute. */
const REMEMBER_MS = 400;
/** Fields whose values are in the address where they are not the usual ones. */
const FIELDS = ["method", "view", "projection", "glasses", "light", "samples", "lights", "e", "d"];
/** Sliders whose values are other numbers in the address: from the slider to the address, and back. */
const SCALES = {
    samples: { out: (value) => value ** 2, in: Math.sqrt },
    d: { out: (value) => Number((2 ** value).toPrecision(4)), in: Math.log2 },
};
/** What the values of sliders for whole numbers are in the address. */
const KINDS = { samples: "a square number", lights: "a whole number" };
const DEGREES = 180 / Math.PI;

/** Returns a field's usual value. @param {string} id @returns {string} */
function usual(id) {
    if (id === "light") return state.open.light;
    const field = element(id);
    return (
        field.defaultValue ?? ([...field.options].find((option) => option.defaultSelected) ?? field.options[0]).value
    );
}

/** Sets a field, and returns what is wrong with its value. @param {string} id @param {string} text */
function set(id, text) {
    const field = element(id);
    if (field.options) {
        const names = [...field.options].map((option) => option.value);
        if (!names.includes(text)) return `${id}=${text}: it must be one of ${names.join(", ")}.`;
        field.value = text;
        return "";
    }
    const scale = SCALES[id] ?? { out: Number, in: Number };
    const number = text.trim() === "" ? NaN : scale.in(Number(text));
    const [least, most] = [field.min, field.max].map(Number);
    const far = number < least - 1e-3 || number > most + 1e-3;
    const kind = KINDS[id] ?? "a number";
    if (!Number.isFinite(number) || far || (KINDS[id] && !Number.isInteger(number))) {
        return `${id}=${text}: it must be ${kind} from ${scale.out(least)} to ${scale.out(most)}.`;
    }
    field.value = number;
    return "";
}

/** Reads a list of numbers, or returns null. @param {string} text @param {number} count */
function numbers(text, count) {
    const found = text.split(",").map((part) => (part.trim() === "" ? NaN : Number(part)));
    return found.length === count && found.every((value) => Number.isFinite(value) && Math.abs(value) < 1e9)
        ? found
        : null;
}

/**
 * Sets the fields and the camera of the open scene, and returns what is wrong with the values.
 * @param {URLSearchParams} values @returns {string[]}
 */
export function apply(values) {
    const faults = FIELDS.filter((id) => values.has(id)).map((id) => set(id, values.get(id) ?? ""));
    faults.push(sized(values.get("size")), placed(values.get("camera")));
    if (values.has("camera") || values.has("projection")) lookAhead();
    faults.push(turned(values.get("head")));
    return faults.filter(Boolean);
}

/** Sets the picture's size, on which a scene's own interaxial depends. @param {string | null} text */
export function sized(text) {
    if (text === null) return "";
    const sides = /^(\d{2,4})x(\d{2,4})$/.exec(text)?.slice(1).map(Number);
    if (text !== "auto" && !sides?.every((side) => side >= 16)) {
        return `size=${text}: it must be auto, or WIDTHxHEIGHT with sides from 16 to 9999.`;
    }
    const list = element("size");
    if (![...list.options].some((option) => option.value === text)) list.add(new Option(text));
    list.value = text;
    return "";
}

/** Places the camera: the eyes' middle and the target, three numbers each. @param {string | null} text */
function placed(text) {
    const own = state.open.camera;
    if (text === null || !own) return "";
    const [x, y, z, ...rest] = numbers(text, 6) ?? [];
    const eye = /** @type {const} */ ([x, y, z]);
    const target = /** @type {[number, number, number]} */ (rest);
    if (!rest.length || distance({ eye, target }) === 0) {
        return `camera=${text}: it must be six numbers, the eyes' place and another place that they look at.`;
    }
    if (steep({ ...own, eye, target })) return `camera=${text}: it must not look straight up or down.`;
    // All lengths scale with the distance.
    const factor = distance({ eye, target }) / distance(own);
    const [interaxial, screenDistance] = [own.interaxial ?? 1, own.screenDistance ?? 1].map(
        (length) => length * factor,
    );
    state.camera = limited({ ...own, eye, target, interaxial, screenDistance }, own);
    return "";
}

/** Turns the head: degrees to the right and upwards, and the field of view. @param {string | null} text */
function turned(text) {
    const span = around();
    if (text === null || !span) return "";
    const found = numbers(text, 3);
    if (!found)
        return `head=${text}: it must be three numbers: degrees to the right, upwards, and of the field of view.`;
    const [right, up, fov] = found;
    head.reset(0);
    head.turn(right / DEGREES, up / DEGREES, span);
    head.zoom(fov / head.fov);
    return "";
}

/** Returns what the shown view consists of. A model from this device is not part of it. */
export function values() {
    const found = new URLSearchParams();
    const { source, camera: own } = state.open;
    const { camera } = state;
    if (source?.builtin && source.builtin !== usual("scene")) found.set("scene", source.builtin);
    if (source?.address) found.set("model", source.address);
    for (const id of FIELDS) {
        const field = element(id);
        if (field.value === usual(id)) continue;
        found.set(id, SCALES[id] ? String(SCALES[id].out(Number(field.value))) : field.value);
    }
    if (element("size").value !== "auto") found.set("size", element("size").value);
    if (!linked() || !camera || !own) return found;
    const place = ({ eye, target }) => [...eye, ...target].map((value) => Number(value.toPrecision(6))).join(",");
    if (place(camera) !== place(own)) found.set("camera", place(camera));
    if (around())
        found.set(
            "head",
            [head.right, head.up]
                .map((angle) => (angle * DEGREES).toFixed(1))
                .concat(head.fov.toFixed(1))
                .join(","),
        );
    return found;
}

/** Returns whether a link can lead to the open scene. */
export const linked = () => !state.open.source?.files || Boolean(state.open.source.address);

/** Returns the link to the shown view. */
export function link() {
    const address = new URL(location.href);
    // Commas and slashes may stand in a query as they are.
    address.search = values().toString().replaceAll("%2C", ",").replaceAll("%2F", "/").replaceAll("%3A", ":");
    return address.href;
}

let timer = 0;
/** The link that was shared last. */
let shared = "";
/** Puts the shown view into the page's address, once nothing moves. */
export function remember() {
    clearTimeout(timer);
    timer = setTimeout(() => {
        const url = link();
        history.replaceState(null, "", url);
        if (url === shared) return;
        element("shared").textContent = "";
        element("link").hidden = true;
    }, REMEMBER_MS);
}

/** Shares the link: by the system's own means on phones, else by the clipboard. */
export async function share() {
    const told = element("shared");
    const url = (shared = link());
    const without = linked() ? "" : " Your model stays on this device: the link has only the settings.";
    try {
        if (navigator.share && matchMedia("(pointer: coarse)").matches) {
            await navigator.share({ title: document.title, url });
            told.textContent = `The link was shared.${without}`;
        } else {
            await navigator.clipboard.writeText(url);
            told.textContent = `The link is in the clipboard.${without}`;
        }
        element("link").hidden = true;
    } catch (error) {
        if (error.name === "AbortError") return;
        element("link").hidden = false;
        element("link").value = url;
        element("link").select();
        told.textContent = `Copy the link below.${without}`;
    }
}
