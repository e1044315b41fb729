// Moves a camera by drags and keys around its target, which is in the middle of the screen.
// @ts-check

/** @typedef {import("./pkg/index.js").Camera} Camera */
/** @typedef {readonly number[]} Vector */

/** @param {Vector} a @param {Vector} b @returns {[number, number, number]} */
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
/** @param {Vector} a @param {Vector} b @param {number} t @returns {[number, number, number]} */
const along = (a, b, t) => [a[0] + b[0] * t, a[1] + b[1] * t, a[2] + b[2] * t];
/** @param {Vector} a @param {Vector} b */
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {Vector} a @param {Vector} b @returns {[number, number, number]} */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @param {Vector} a @returns {[number, number, number]} */
const unit = (a) => along([0, 0, 0], a, 1 / Math.hypot(...a));

/**
 * Returns a vector rotated around an axis by an angle (Rodrigues).
 * @param {Vector} v @param {Vector} axis @param {number} angle
 */
function turned(v, axis, angle) {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    return along(along(along([0, 0, 0], v, c), cross(axis, v), s), axis, dot(axis, v) * (1 - c));
}

/** Smallest angle between the view and the up direction. The horizon is undefined where they meet. */
const LEAST_SLANT = 0.05;
/** Part of that angle at which a camera from an address is refused. Addresses have rounded numbers. */
const REFUSED = 0.98;
/** Largest factor by which a camera comes nearer or goes farther than the scene's own camera. */
const FARTHEST = 64;

/** Returns the angle between the up direction and the way from the target to the eyes. @param {Camera} camera */
const slantOf = ({ eye, target, up = [0, 1, 0] }) =>
    Math.acos(Math.max(-1, Math.min(1, dot(unit(sub(eye, target)), unit(up)))));

/** Whether a camera looks straight up or down, where no gesture could move it. @param {Camera} camera */
export function steep(camera) {
    const slant = slantOf(camera);
    return Math.min(slant, Math.PI - slant) < REFUSED * LEAST_SLANT;
}

/**
 * Moves the eyes around the target, to their right and upwards, in radians.
 * @param {Camera} camera @param {number} right @param {number} up @returns {Camera}
 */
export function orbited(camera, right, up) {
    const axis = unit(camera.up ?? [0, 1, 0]);
    const arm = sub(camera.eye, camera.target);
    const slant = slantOf(camera);
    const raised = Math.max(LEAST_SLANT, Math.min(Math.PI - LEAST_SLANT, slant - up)) - slant;
    const across = unit(cross(axis, arm));
    return { ...camera, eye: along(camera.target, turned(turned(arm, across, raised), axis, right), 1) };
}

/** Returns the distance of the eyes from the target. @param {{ eye: Vector, target: Vector }} camera */
export const distance = ({ eye, target }) => Math.hypot(...sub(eye, target));

/**
 * Returns a camera whose distance from its target is neither tiny nor huge beside that of the scene's own camera.
 * @param {Camera} camera @param {Camera} own @returns {Camera}
 */
export function limited(camera, own) {
    const factor = distance(camera) / distance(own);
    const kept = Math.max(1 / FARTHEST, Math.min(FARTHEST, factor));
    return kept === factor ? camera : nearer(camera, kept / factor);
}

/**
 * Multiplies the distance of the eyes from the target. The picture keeps its depth, since all distances scale alike.
 * @param {Camera} camera @param {number} factor @returns {Camera}
 */
export function nearer(camera, factor) {
    const { eye, target, screenDistance = 1, interaxial = 1 } = camera;
    return {
        ...camera,
        eye: along(target, sub(eye, target), factor),
        screenDistance: screenDistance * factor,
        interaxial: interaxial * factor,
    };
}

/**
 * Moves the camera so that the scene on the screen follows by `right` and `down` heights of the picture.
 * @param {Camera} camera @param {number} right @param {number} down @returns {Camera}
 */
export function panned(camera, right, down) {
    const arm = sub(camera.target, camera.eye);
    const height = 2 * Math.hypot(...arm) * Math.tan(((camera.fov ?? 45) * Math.PI) / 360);
    const r = unit(cross(arm, camera.up ?? [0, 1, 0]));
    const u = unit(cross(r, arm));
    const way = along(along([0, 0, 0], r, -right * height), u, down * height);
    return { ...camera, eye: along(camera.eye, way, 1), target: along(camera.target, way, 1) };
}
