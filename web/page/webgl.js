// What the parts of the page that draw pictures by WebGL share: one triangle over the whole target, and textures.
// @ts-check

const VERTICES = `#version 300 es
out vec2 at;
void main() {
    at = vec2(4.0 * float(gl_VertexID & 1) - 1.0, 4.0 * float(gl_VertexID >> 1) - 1.0);
    gl_Position = vec4(at, 0.0, 1.0);
}`;

/** For fragment shaders: the place from 0 to 1 of a ray (right, up, ahead) in an equirectangular picture. */
export const PLACE_AROUND = `
const float PI = 3.14159265;
vec2 place_around(vec3 ray, float turn) { // turn: the share of a full turn that the picture shows
    return vec2(0.5 + atan(ray.x, ray.z) / (2.0 * PI * turn), 0.5 - atan(ray.y, length(ray.xz)) / PI);
}`;

/**
 * Prepares to draw triangles of three vertices, whose colours a fragment shader gives. Its input `at` is the place in
 * normalized device coordinates. Returns null if the context is lost.
 * @param {WebGL2RenderingContext | null} gl @param {string} colors
 */
export function drawing(gl, colors) {
    if (!gl || gl.isContextLost()) return null;
    const program = gl.createProgram();
    for (const [kind, source] of /** @type {const} */ ([
        [gl.VERTEX_SHADER, VERTICES],
        [gl.FRAGMENT_SHADER, colors],
    ])) {
        const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
        gl.shaderSource(shader, source);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(`WebGL: ${gl.getProgramInfoLog(program)}`);
    gl.useProgram(program);
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    /** @type {Map<string, WebGLUniformLocation | null>} */
    const places = new Map();
    const place = (/** @type {string} */ name) => {
        if (!places.has(name)) places.set(name, gl.getUniformLocation(program, name));
        return /** @type {WebGLUniformLocation | null} */ (places.get(name));
    };
    return { gl, most, place };
}

/** Returns a picture's texture, which is bound. @param {WebGL2RenderingContext} gl @param {ImageBitmap} picture */
export function uploaded(gl, picture) {
    const texture = /** @type {WebGLTexture} */ (gl.createTexture());
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const [name, value] of [
        [gl.TEXTURE_MIN_FILTER, gl.LINEAR],
        [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
        [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE],
        [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
    ]) {
        gl.texParameteri(gl.TEXTURE_2D, name, value);
    }
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, picture);
    return texture;
}
