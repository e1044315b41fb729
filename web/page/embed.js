// A page that embeds this one in a frame sets views by messages, and is told what they cost (docs/BROWSER.md).
//   to this page      { stereotrace: "set", values: { scene: "hall", e: 1.5, … } }      values as in the address
//   from this page    { stereotrace: "ready" }
//                     { stereotrace: "picture", values, cost }
//                     { stereotrace: "error", message }
// @ts-check
import { cost } from "./figures.js";
import { apply, values } from "./link.js";
import { openLinked } from "./models.js";
import { ask } from "./render.js";
import { element, notice, state } from "./state.js";
import { label } from "./settings.js";

/** The page around this one. Messages of other windows are ignored. */
const host = parent === window ? null : parent;
/** The host's origin, once it has sent a message. It alone receives answers. A host without an origin receives none. */
let origin = "";

/** @param {object} message */
function answer(message) {
    if (origin && origin !== "null") host?.postMessage(message, origin);
}

/** Tells the host about a picture. @param {any} done */
export function told(done) {
    answer({ stereotrace: "picture", values: Object.fromEntries(values()), cost: cost(done) });
}

/** Changes the shown view, and returns what is wrong with the values. @param {URLSearchParams} asked */
function set(asked) {
    const faults = apply(asked).join("\n");
    notice(faults, { lasts: true });
    label();
    ask("whole");
    return faults;
}

/** Begins to heed the host. */
export function embedded() {
    if (!host) return;
    document.documentElement.classList.add("embedded");
    const link = element("whole-page");
    link.hidden = false;
    // The link leads to what is shown now.
    link.addEventListener("pointerdown", () => {
        link.href = location.href;
    });
    link.addEventListener("focus", () => {
        link.href = location.href;
    });
    addEventListener("message", async ({ source, origin: from, data }) => {
        if (source !== host || data?.stereotrace !== "set") return;
        origin = from;
        if (state.fault) return answer({ stereotrace: "error", message: state.fault });
        if (typeof data.values !== "object" || data.values === null) {
            return answer({
                stereotrace: "error",
                message: "values: it must be an object, with values as in the address",
            });
        }
        const asked = new URLSearchParams(Object.entries(data.values).map(([name, value]) => [name, String(value)]));
        const message = asked.has("scene") || asked.has("model") ? await openLinked(asked) : set(asked);
        if (message) answer({ stereotrace: "error", message });
    });
    // This says nothing that is private, so that any host may receive it.
    host.postMessage({ stereotrace: "ready" }, "*");
}
