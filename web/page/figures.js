// Shows the cost of a pair, and its difference from naive, in words and figures.
// @ts-check
import { element, short } from "./state.js";

/** Passes of the left eye alone, and passes that both eyes share. All others belong to the right eye. */
const LEFT_PASSES = ["trace_left"];
const SHARED_PASSES = [
    "trace_hits",
    "trace_soft",
    "shade_hits",
    "list_mirrors",
    "trace_mirrored",
    "pack",
    "begin_paths",
    "trace_paths",
    "add_brought",
    "smooth_variances",
    "smooth_light_once",
];

/** @param {number} share */
const percent = (share) => `${(100 * share).toFixed(1)}%`;
/** @param {number} value */
const milliseconds = (value) => `${value.toFixed(value < 10 ? 1 : 0)} ms`;

/**
 * Returns the device's time for each eye, or null if it has no clock or both eyes share passes.
 * @param {{ name: string, ms: number }[] | undefined} passes
 */
function split(passes) {
    if (!passes || passes.some(({ name, ms }) => ms > 0 && name !== "pack" && SHARED_PASSES.includes(name)))
        return null;
    const sum = (of) => passes.filter(of).reduce((total, pass) => total + pass.ms, 0);
    const left = sum(({ name }) => LEFT_PASSES.includes(name));
    const right = sum(({ name }) => ![...LEFT_PASSES, ...SHARED_PASSES].includes(name));
    return left > 0 ? { left, right } : null;
}

/** Returns the cost of a pair as it is told to readers and to other pages. @param {any} done */
export function cost({ ms, statistics: { method, choice, retracedShare, passes } }) {
    const eyes = split(passes);
    return { ms, leftMs: eyes?.left, rightMs: eyes?.right, retracedShare, method, choice };
}

/** Says what the last picture cost. @param {any} done */
export function tell(done) {
    const { ms, leftMs, rightMs, retracedShare, choice } = cost(done);
    const both = leftMs === undefined || rightMs === undefined;
    const times = both
        ? `Both eyes took ${milliseconds(ms)}`
        : `Left eye ${milliseconds(leftMs)}, right eye ${milliseconds(rightMs)}`;
    const whose = both ? "the right eye's pixels" : "its pixels";
    const traced =
        retracedShare === 1
            ? `all of ${whose} were traced, and none reused`
            : `${percent(retracedShare)} of ${whose} were traced again`;
    element("sentence").textContent = `${times}: ${traced}.`;
    element("choice").hidden = !choice;
    element("choice").textContent = choice ? `auto chose ${choice}.` : "";
}

/** @param {any} done @param {readonly number[]} pictureSize @param {number} scale */
export function figures({ ms, statistics, deviceMs, paths }, pictureSize, scale) {
    const { method, retracedShare, passes, left, right } = statistics;
    const rays = (eye) => eye.primary + eye.verification + eye.shadow + eye.secondary;
    const compiled = ms > 2 * (deviceMs ?? ms) + 300 ? ", mostly compilation" : "";
    const rows = [["time, both eyes", `${milliseconds(ms)}${compiled}`]];
    if (retracedShare === 1) {
        rows.push(["right eye", "traced, nothing reused"]);
    } else {
        rows.push(["right pixels traced again", percent(retracedShare)]);
        rows.push(["rays, right relative to left", `${((100 * rays(right)) / Math.max(1, rays(left))).toFixed(0)}%`]);
    }
    const eyes = split(passes);
    if (eyes) {
        rows.push(["device time, right relative to left", `${((100 * eyes.right) / eyes.left).toFixed(0)}%`]);
    } else if (deviceMs !== undefined) {
        rows.push(["device time", `${deviceMs.toFixed(1)} ms`]);
    }
    if (paths) rows.push(["paths per pixel", paths]);
    rows.push(["method", method], ["picture", `${pictureSize.join("x")}${scale < 1 ? ", draft" : ""}`]);
    element("figures").replaceChildren(
        ...rows.map(([name, value]) => {
            const group = document.createElement("div");
            const [term, figure] = [document.createElement("dt"), document.createElement("dd")];
            [term.textContent, figure.textContent] = [name, value];
            group.append(term, figure);
            return group;
        }),
    );
}

/** @param {any} found */
export function compared(found) {
    const text = element("compared");
    if (!found) {
        text.textContent = "";
        return;
    }
    const {
        difference: { identicalPercent, wrongSurfacePercent, psnr, largestParallaxError },
        naiveMs,
    } = found;
    text.textContent =
        `${identicalPercent.toFixed(3)}% of the right pixels are identical to naive; ` +
        `${wrongSurfacePercent.toFixed(3)}% show another surface.\n` +
        `The PSNR is ${Number.isFinite(psnr) ? `${psnr.toFixed(1)} dB` : "∞, since nothing differs"}. ` +
        `The largest parallax error is ${short(largestParallaxError)} px.\n` +
        `naive took ${naiveMs.toFixed(0)} ms for both eyes.`;
}
