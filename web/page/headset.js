// Shows the last pair in a headset by WebXR: a planar pair as a window, a pair all around as a sphere. WebGL draws it,
// since the page has the pair's pictures in host memory anyway.
// @ts-check
import { element, engine, notice } from "./state.js";
import { PLACE_AROUND, drawing, uploaded } from "./webgl.js";

/** Distance in metres between the eyes of a headset that shows one view, and the least and most of a window. */
const METRES = { eyes: 0.063, nearest: 0.5, farthest: 50 };

const COLORS = `#version 300 es
precision highp float;
${PLACE_AROUND}
in vec2 at;
uniform sampler2D picture;
uniform vec4 projection; // of the headset's view: scales of x and y, then their skews
uniform mat3 toPair;     // from the headset's view to right, up and ahead
uniform vec3 eye;        // right, up and ahead from where the head began, in metres
uniform float turn;      // share of a full turn that the picture shows; 0 for a window
uniform vec3 window;     // width, height and distance ahead in metres
out vec4 color;
void main() {
    vec3 ray = toPair * vec3((at + projection.zw) / projection.xy, -1.0);
    vec2 place;
    if (turn > 0.0) {
        place = place_around(ray, turn);
    } else {
        vec2 hit = eye.xy + (window.z - eye.z) / ray.z * ray.xy;
        place = ray.z * (window.z - eye.z) > 0.0 ? vec2(0.5 + hit.x / window.x, 0.5 - hit.y / window.y) : vec2(-1.0);
    }
    bool inside = all(lessThanEqual(abs(place - 0.5), vec2(0.5)));
    color = inside ? vec4(texture(picture, place).rgb, 1.0) : vec4(0.0, 0.0, 0.0, 1.0);
}`;

/** The running session. @type {any} */
let session = null;

/**
 * Draws a pair in a session until it ends.
 * @param {any} session @param {ImageBitmap[]} pair @param {import("./pkg/index.js").Camera} camera
 */
async function present(session, pair, camera) {
    const gl = document.createElement("canvas").getContext("webgl2", { xrCompatible: true, antialias: false });
    const opened = drawing(gl, COLORS);
    if (!gl || !opened) throw new Error("This browser has no WebGL 2, which a headset's pictures need.");
    const size = Math.max(...pair.flatMap(({ width, height }) => [width, height]));
    if (size > opened.most)
        throw new Error(`A side of ${size} pixels is more than this device's textures have: ${opened.most}.`);
    const textures = pair.map((picture) => uploaded(gl, picture));
    const layer = new /** @type {any} */ (globalThis).XRWebGLLayer(session, gl);
    session.updateRenderState({ baseLayer: layer });
    const space = await session.requestReferenceSpace("local");

    const { projection: span, interaxial = 0, screenDistance = 1, fov = 45, size: [width, height] = [1, 1] } = camera;
    /** Where the head began: its place, and its right and ahead on the floor. @type {any} */
    let began = null;
    session.addEventListener("select", () => {
        began = null;
    });

    /** @param {any} pose */
    function begin({ transform, views }) {
        const { position, matrix } = transform;
        const level = Math.hypot(matrix[8], matrix[10]);
        // A head that looks straight up or down has no such direction.
        const [x, z] = level > 0.1 ? [-matrix[8] / level, -matrix[10] / level] : [0, -1];
        const [a, b] = views.map((/** @type {any} */ view) => view.transform.position);
        const eyes = (b && Math.hypot(a.x - b.x, a.y - b.y, a.z - b.z)) || METRES.eyes;
        // So large that the headset's eyes are where the pair's eyes are.
        const distance = interaxial > 0 ? (screenDistance * eyes) / interaxial : METRES.farthest;
        const ahead = Math.max(METRES.nearest, Math.min(METRES.farthest, distance));
        const tall = 2 * ahead * Math.tan((fov * Math.PI) / 360);
        return { position, x, z, window: [(tall * width) / height, tall, ahead] };
    }

    /** @param {number} _ @param {any} frame */
    function draw(_, frame) {
        session.requestAnimationFrame(draw);
        const pose = frame.getViewerPose(space);
        if (!gl || !opened || !pose) return;
        began ??= begin(pose);
        const { position, x, z, window } = began;
        // From the reference space to right, up and ahead.
        const turned = (/** @type {number[]} */ [vx, vy, vz]) => [-z * vx + x * vz, vy, x * vx + z * vz];
        gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
        for (const view of pose.views) {
            const port = layer.getViewport(view);
            if (!port) continue;
            gl.viewport(port.x, port.y, port.width, port.height);
            const { matrix, position: at } = view.transform;
            gl.bindTexture(gl.TEXTURE_2D, textures[view.eye === "right" ? 1 : 0]);
            const projection = [0, 5, 8, 9].map((index) => view.projectionMatrix[index]);
            gl.uniform4fv(opened.place("projection"), projection);
            const columns = [0, 4, 8].flatMap((first) => turned([...matrix.slice(first, first + 3)]));
            gl.uniformMatrix3fv(opened.place("toPair"), false, columns);
            gl.uniform3fv(opened.place("eye"), turned([at.x - position.x, at.y - position.y, at.z - position.z]));
            gl.uniform1f(opened.place("turn"), span ? span / 360 : 0);
            gl.uniform3fv(opened.place("window"), window);
            gl.drawArrays(gl.TRIANGLES, 0, 3);
        }
    }
    session.requestAnimationFrame(draw);
    await new Promise((done) => session.addEventListener("end", done));
    // Browsers keep few contexts, and another session makes another one.
    gl.getExtension("WEBGL_lose_context")?.loseContext();
}

/** Offers the button where there is a headset. */
export async function offer() {
    const { xr } = /** @type {any} */ (navigator);
    const button = element("headset");
    const look = async () => {
        button.hidden = !(await xr?.isSessionSupported("immersive-vr").catch(() => false));
    };
    xr?.addEventListener("devicechange", look);
    await look();
    button.addEventListener("click", async () => {
        if (session) return session.end();
        try {
            // First of all, as it needs the click.
            session = await xr.requestSession("immersive-vr");
            session.addEventListener("end", () => {
                session = null;
                button.setAttribute("aria-pressed", "false");
            });
            button.setAttribute("aria-pressed", "true");
            const { images, camera } = await engine().ask("show", { view: "slider" });
            await present(session, images, camera);
            for (const image of images) image.close();
        } catch (error) {
            await session?.end();
            notice(`The headset shows nothing: ${error.message}`);
        }
    });
}
