// A phone that is tilted looks around the scene.
// @ts-check
import { look, steer } from "./gestures.js";
import { orbited } from "./orbit.js";
import { around } from "./settings.js";
import { element, notice, state } from "./state.js";

/** Angle of the camera's orbit per angle of the phone. A head turns as far as the phone. */
const GAIN = 0.5;
const RADIANS = Math.PI / 180;

let last = /** @type {{ beta: number, gamma: number } | null} */ (null);

/** @param {DeviceOrientationEvent} event */
function tilted({ beta, gamma }) {
    if (beta === null || gamma === null || !state.camera) return;
    const [top, side] = last ? [beta - last.beta, gamma - last.gamma] : [0, 0];
    const angle = Math.hypot(top, side);
    // Small changes are noise. Large ones are a phone that was turned over.
    if (last && angle < 0.3) return;
    last = { beta, gamma };
    if (angle > 30) return;
    // The angles are about the phone's own axes, however its screen is turned.
    const turn = (screen.orientation?.angle ?? 0) * RADIANS;
    const up = RADIANS * (Math.cos(turn) * top - Math.sin(turn) * side);
    const right = RADIANS * (Math.sin(turn) * top + Math.cos(turn) * side);
    const span = around();
    if (span) look(right, up, span);
    else steer((camera) => orbited(camera, GAIN * right, -GAIN * up));
}

/** Offers the button where there are such sensors. */
export function tiltable() {
    const button = element("tilt");
    const events = /** @type {any} */ (globalThis.DeviceOrientationEvent);
    button.hidden = !events || !matchMedia("(pointer: coarse)").matches;
    button.addEventListener("click", async () => {
        const on = button.getAttribute("aria-pressed") !== "true";
        // Safari asks its user.
        if (on && (await events.requestPermission?.().catch(() => "denied")) === "denied") {
            return notice("This browser does not let the page read the phone's tilt.");
        }
        button.setAttribute("aria-pressed", String(on));
        last = null;
        if (on) addEventListener("deviceorientation", tilted);
        else removeEventListener("deviceorientation", tilted);
    });
}
