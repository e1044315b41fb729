// A page that embeds this one in a frame sets views by messages, and is told what they cost (docs/BROWSER.md).
//   to this page      { stereotrace: "set", values: { scene: "hall", e: 1.5, … } }      values as in the address
//   from this page    { stereotrace: "ready" }
//                     { stereotrace: "picture", values, cost }
//                     { stereotrace: "error", message }
// @ts-check
import { cost } from "./figures.js";
import { apply, linked, values } from "./link.js";
import { openLinked } from "./models.js";
import { ask } from "./render.js";
import { element, notice, state } from "./state.js";
import { label } from "./settings.js";

/** The page around this one. Messages of other windows are ignored. */
const host = parent === window ? null : parent;
/** The host's origin, once it has sent a message. It alone receives answers. A host without an origin receives none. */
let origin = "";
/** The end of what the host has asked for. */
let turn = Promise.resolve();

/** @param {object} message */
function answer(message) {
    if (origin && origin !== "null") host?.postMessage(message, origin);
}

/** Tells the host what is wrong. @param {string} message */
export const faulted = (message) => answer({ stereotrace: "error", message });

/** Tells the host about a picture, but not of a model from this device. @param {any} done */
export function told(done) {
    if (linked()) answer({ stereotrace: "picture", values: Object.fromEntries(values()), cost: cost(done) });
}

/** Changes the shown view, and returns what is wrong with the values. @param {URLSearchParams} asked */
function set(asked) {
    const faults = apply(asked).join("\n");
    notice(faults, { lasts: true });
    label();
    ask("whole");
    return faults;
}

/** Whether values ask for another scene. @param {unknown} given */
const opens = (given) => given instanceof Object && ("scene" in given || "model" in given);

/** @param {unknown} given */
async function heeded(given) {
    if (state.fault) return faulted(state.fault);
    if (!(given instanceof Object)) return faulted("values: it must be an object, with values as in the address");
    const asked = new URLSearchParams(Object.entries(given).map(([name, value]) => [name, String(value)]));
    const message = opens(given) ? await openLinked(asked) : set(asked);
    if (message) faulted(message);
}

/** Prepares the page for its frame. */
export function embedded() {
    if (!host) return;
    document.documentElement.classList.add("embedded");
    const link = element("whole-page");
    link.hidden = false;
    // The link leads to what is shown now.
    for (const event of ["pointerdown", "focus"]) {
        link.addEventListener(event, () => {
            link.href = location.href;
        });
    }
}

/** Begins to heed the host, once there is a scene that it can change. */
export function heed() {
    if (!host) return;
    addEventListener("message", ({ source, origin: from, data }) => {
        if (source !== host || data?.stereotrace !== "set") return;
        origin = from;
        const { values } = data;
        // Values wait for the scene that was asked for before. Another scene replaces it.
        turn = (opens(values) ? Promise.resolve() : turn).then(() => heeded(values)).catch(console.error);
    });
    // This says nothing that is private, so that any host may receive it.
    host.postMessage({ stereotrace: "ready" }, "*");
}
