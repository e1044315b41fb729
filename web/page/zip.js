// Reads .zip files with the browser's own decompression. No file becomes larger than its archive says.
// @ts-check

const MOST_ENTRIES = 10_000;
const [END, ENTRY, LOCAL] = [0x06054b50, 0x02014b50, 0x04034b50];
const [STORED, DEFLATED] = [0, 8];
/** The archive's end: 22 bytes, and a comment of at most 65,535. */
const MOST_END = 22 + 0xffff;

/** @param {Blob} blob */
const view = async (blob) => new DataView(await blob.arrayBuffer());

/**
 * Returns the files of an archive, without folders and the files that macOS adds.
 * @param {File} archive @param {number} mostBytes of all files together @param {AbortSignal} [signal]
 * @returns {Promise<{ path: string, file: File }[]>}
 */
export async function unzipped(archive, mostBytes, signal) {
    /** @param {string} fault */
    const refuse = (fault) => {
        throw new Error(`${archive.name}: ${fault}; unpack it, and drop its files`);
    };
    const tail = await view(archive.slice(-MOST_END));
    let end = tail.byteLength - 22;
    while (end >= 0 && tail.getUint32(end, true) !== END) end -= 1;
    if (end < 0) return refuse("it is no .zip file, or it is cut off");
    const [count, length, start] = [
        tail.getUint16(end + 10, true),
        tail.getUint32(end + 12, true),
        tail.getUint32(end + 16, true),
    ];
    if (start === 0xffffffff || start + length > archive.size) return refuse("its list of files can't be found");
    if (count > MOST_ENTRIES) return refuse(`it has ${count} files, and more than ${MOST_ENTRIES} are not read`);
    const list = await view(archive.slice(start, start + length));
    const found = [];
    let bytes = 0;
    for (let at = 0, index = 0; index < count; index += 1) {
        if (at + 46 > list.byteLength || list.getUint32(at, true) !== ENTRY)
            return refuse("its list of files is damaged");
        const [flags, method] = [list.getUint16(at + 8, true), list.getUint16(at + 10, true)];
        const [packed, size, local] = [20, 24, 42].map((offset) => list.getUint32(at + offset, true));
        const [name, extra, comment] = [28, 30, 32].map((offset) => list.getUint16(at + offset, true));
        const path = new TextDecoder().decode(
            new Uint8Array(list.buffer, at + 46, Math.min(name, list.byteLength - at - 46)),
        );
        at += 46 + name + extra + comment;
        if (path.endsWith("/") || path.startsWith("__MACOSX/")) continue;
        bytes += size;
        if (flags & 1) return refuse(`${path} is encrypted`);
        if (method !== STORED && method !== DEFLATED)
            return refuse(`${path} is compressed in a way that browsers can't read`);
        if (bytes > mostBytes)
            return refuse(`its files have more than ${Math.floor(mostBytes / 2 ** 20)} MiB in total`);
        const header = await view(archive.slice(local, local + 30));
        if (header.byteLength < 30 || header.getUint32(0, true) !== LOCAL)
            return refuse(`${path} is not where the list says`);
        const begin = local + 30 + header.getUint16(26, true) + header.getUint16(28, true);
        const data = archive.slice(begin, begin + packed);
        const content = method === STORED ? data : await inflated(data, size, signal).catch(() => null);
        signal?.throwIfAborted();
        if (content?.size !== size) return refuse(`${path} is damaged`);
        found.push({ path, file: new File([content], path) });
    }
    return found;
}

/**
 * Decompresses data. Stops once there is more of it than the archive says.
 * @param {Blob} data @param {number} size @param {AbortSignal} [signal]
 */
async function inflated(data, size, signal) {
    const parts = [];
    let bytes = 0;
    const reader = data.stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader();
    for (;;) {
        const { done, value } = await reader.read();
        if (done) return new Blob(parts);
        bytes += value.byteLength;
        if (bytes > size || signal?.aborted) {
            await reader.cancel();
            return null;
        }
        parts.push(value);
    }
}
