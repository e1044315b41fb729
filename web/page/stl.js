// Reads STL files: triangles without anything else.
// @ts-check

/** As many as the package reads from other files. */
const MOST_TRIANGLES = 4 << 20;
/** Maximum size of a text file, which takes several times its size while it is read. */
const MOST_TEXT = 128 << 20;
/** Bytes before the triangles of a binary file, and of each triangle. */
const [HEAD, TRIANGLE] = [84, 50];

/**
 * Returns the corners of all triangles, with y up. STL files have z up.
 * @param {Uint8Array} bytes @param {string} name
 */
export function corners(bytes, name) {
    const file = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const count = bytes.length >= HEAD ? file.getUint32(80, true) : 0;
    const isBinary = bytes.length >= HEAD && bytes.length === HEAD + TRIANGLE * count;
    if (isBinary && count > MOST_TRIANGLES) {
        throw new Error(`${name}: it has more than ${MOST_TRIANGLES.toLocaleString("en")} triangles`);
    }
    if (!isBinary && bytes.length > MOST_TEXT) {
        throw new Error(`${name}: it has more than ${MOST_TEXT / 2 ** 20} MiB of text; save it as a binary STL file`);
    }
    const found = isBinary ? binary(file, count) : text(new TextDecoder().decode(bytes));
    if (!found.length || found.length % 9 || !found.every(Number.isFinite)) {
        throw new Error(`${name}: it is no STL file, it has no triangles, or it is cut off`);
    }
    for (let at = 0; at < found.length; at += 3) [found[at + 1], found[at + 2]] = [found[at + 2], -found[at + 1]];
    return found;
}

/** @param {DataView} file @param {number} count */
function binary(file, count) {
    const found = new Float32Array(9 * count);
    for (let index = 0; index < found.length; index += 1) {
        // A triangle's normal comes before its corners.
        found[index] = file.getFloat32(HEAD + TRIANGLE * Math.floor(index / 9) + 12 + 4 * (index % 9), true);
    }
    return found;
}

/** @param {string} file */
function text(file) {
    const found = [];
    // No part of the pattern goes on into the next line, so that each line is looked at once.
    for (const [, x, y, z] of file.matchAll(/^[ \t]*vertex[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)/gim)) {
        found.push(Number(x), Number(y), Number(z));
    }
    return new Float32Array(found);
}
