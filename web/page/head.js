// The head that turns inside an equirectangular picture. WebGL draws the planar part that it sees.
// @ts-check
import { PLACE_AROUND, drawing, uploaded } from "./webgl.js";

/** Vertical field of view in degrees: at the beginning, least and most. */
const FOV = { begin: 70, least: 20, most: 120 };

const COLORS = `#version 300 es
precision highp float;
${PLACE_AROUND}
uniform sampler2D picture;
uniform vec2 size;     // of one view's part, in pixels
uniform float views;   // side by side in the picture
uniform float pixel;   // tangent of a pixel's angle in the middle
uniform float turn;    // share of a full turn that a view shows
uniform mat3 toPair;   // from right, up and ahead in the window to the pair's coordinates
out vec4 color;
void main() {
    float view = floor(gl_FragCoord.x / size.x);
    vec2 at = pixel * (gl_FragCoord.xy - vec2(view * size.x, 0.0) - 0.5 * size);
    vec3 ray = toPair * vec3(at, 1.0);
    vec2 place = place_around(ray, turn);
    // A place between two texels of different views would mix them.
    float half_texel = 0.5 * views / float(textureSize(picture, 0).x);
    bool inside = abs(place.x - 0.5) <= 0.5;
    place.x = (clamp(place.x, half_texel, 1.0 - half_texel) + view) / views;
    color = inside ? vec4(texture(picture, place).rgb, 1.0) : vec4(0.0, 0.0, 0.0, 1.0);
}`;

export class Head {
    constructor() {
        /** Angles to the right and upwards in radians, and the vertical field of view in degrees. */
        [this.right, this.up, this.fov] = [0, 0, FOV.begin];
        this.canvas = document.createElement("canvas");
        /** @type {ReturnType<typeof drawing>} */
        this.drawing = null;
        /** The pictures' textures. @type {Map<ImageBitmap, WebGLTexture>} */
        this.uploaded = new Map();
        this.canvas.addEventListener("webglcontextlost", (event) => {
            event.preventDefault(); // else it is never restored
            this.drawing = null;
            this.uploaded.clear();
        });
    }

    /** Frees the textures of pictures that are no longer shown. */
    forget() {
        for (const texture of this.uploaded.values()) this.drawing?.gl.deleteTexture(texture);
        this.uploaded.clear();
    }

    /** Looks ahead, at an angle upwards in radians. @param {number} up */
    reset(up) {
        [this.right, this.up, this.fov] = [0, up, FOV.begin];
    }

    /**
     * Turns to the right and upwards, in radians; within the picture if it shows half a turn.
     * @param {number} right @param {number} up @param {360 | 180} span
     */
    turn(right, up, span) {
        const most = span === 180 ? Math.PI / 2 : Infinity;
        this.right = Math.max(-most, Math.min(most, this.right + right));
        this.up = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.up + up));
    }

    /** Multiplies the field of view. @param {number} factor */
    zoom(factor) {
        this.fov = Math.max(FOV.least, Math.min(FOV.most, this.fov * factor));
    }

    /** The tangent of the angle of a pixel in the middle of a picture of this height. @param {number} height */
    pixel(height) {
        return (2 * Math.tan((this.fov * Math.PI) / 360)) / height;
    }

    /**
     * Returns what the head sees, or null without WebGL and for a picture larger than its textures.
     * @param {ImageBitmap} picture @param {number} views number of views side by side in the picture
     * @param {360 | 180} span @param {readonly number[]} size width and height of one view's part
     * @returns {HTMLCanvasElement | null}
     */
    see(picture, views, span, [width, height]) {
        this.drawing ??= drawing(this.canvas.getContext("webgl2", { alpha: false, antialias: false }), COLORS);
        if (!this.drawing) return null;
        const { gl, place, most } = this.drawing;
        if (gl.isContextLost() || Math.max(picture.width, picture.height) > most) return null;
        [this.canvas.width, this.canvas.height] = [views * width, height];
        gl.viewport(0, 0, views * width, height);
        const known = this.uploaded.get(picture);
        if (known) gl.bindTexture(gl.TEXTURE_2D, known);
        else this.uploaded.set(picture, uploaded(gl, picture));
        gl.uniform2f(place("size"), width, height);
        gl.uniform1f(place("views"), views);
        gl.uniform1f(place("pixel"), this.pixel(height));
        gl.uniform1f(place("turn"), span / 360);
        const [sin, cos] = [Math.sin(this.right), Math.cos(this.right)];
        const [rise, level] = [Math.sin(this.up), Math.cos(this.up)];
        // The columns are what the window's right, up and ahead are in the pair.
        gl.uniformMatrix3fv(place("toPair"), false, [
            cos,
            0,
            -sin,
            -rise * sin,
            level,
            -rise * cos,
            level * sin,
            rise,
            level * cos,
        ]);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        return this.canvas;
    }
}
