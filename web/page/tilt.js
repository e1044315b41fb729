// A phone that is tilted looks around the scene.
// @ts-check
import { steer } from "./gestures.js";
import { orbited } from "./orbit.js";
import { element } from "./state.js";

/** Angle of the camera's orbit per angle of the phone. */
const GAIN = 0.5;
const RADIANS = Math.PI / 180;

let last = /** @type {{ beta: number, gamma: number } | null} */ (null);

/** @param {DeviceOrientationEvent} event */
function tilted({ beta, gamma }) {
    if (beta === null || gamma === null) return;
    const [up, right] = last ? [beta - last.beta, gamma - last.gamma] : [0, 0];
    // Small changes are noise. Large ones are a phone that was turned over.
    if (last && Math.hypot(up, right) < 0.3) return;
    last = { beta, gamma };
    if (Math.hypot(up, right) > 30) return;
    steer((camera) => orbited(camera, GAIN * RADIANS * right, -GAIN * RADIANS * up));
}

/** Offers the button where there are such sensors. */
export function tiltable() {
    const button = element("tilt");
    const events = /** @type {any} */ (globalThis.DeviceOrientationEvent);
    button.hidden = !events || !matchMedia("(pointer: coarse)").matches;
    button.addEventListener("click", async () => {
        const on = button.getAttribute("aria-pressed") !== "true";
        // Safari asks its user.
        if (on && (await events.requestPermission?.().catch(() => "denied")) === "denied") return;
        button.setAttribute("aria-pressed", String(on));
        last = null;
        if (on) addEventListener("deviceorientation", tilted);
        else removeEventListener("deviceorientation", tilted);
    });
}
