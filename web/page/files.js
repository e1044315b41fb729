// Reads dropped files and the files in dropped folders and archives, by their paths, and files from addresses.
// @ts-check
import { unzipped } from "./zip.js";

/** Maximum size of all files together. A page has 4 GiB of memory for everything that is made from them. */
const MOST_BYTES = 1 << 30;
/** Maximum size of a file from an address, since a link may name a file that its reader did not choose. */
const MOST_FETCHED = 256 << 20;
/** Maximum size of what such a file is, once it is unpacked. */
export const MOST_LINKED = 512 << 20;
/** Time without a byte until a server is given up. */
const PATIENCE_MS = 30_000;
const SCENES = /\.(obj|gltf|glb|ply|stl)$/i;
const ARCHIVE = /\.zip$/i;

/** @param {DataTransfer} transfer @returns {Promise<{ path: string, file: File }[]>} */
export async function dropped(transfer) {
    // Entries are gone once the event is over, so all are requested before anything is awaited.
    const entries = [...transfer.items]
        .map((item) => item.webkitGetAsEntry?.())
        .filter((entry) => entry !== null && entry !== undefined);
    if (!entries.length) return [...transfer.files].map((file) => ({ path: file.name, file }));
    return (await Promise.all(entries.map(inside))).flat();
}

/** @param {FileSystemEntry} entry @returns {Promise<{ path: string, file: File }[]>} */
async function inside(entry) {
    if (entry.isFile) {
        const file = await new Promise((done, failed) => /** @type {FileSystemFileEntry} */ (entry).file(done, failed));
        return [{ path: entry.fullPath.replace(/^\//, ""), file }];
    }
    const reader = /** @type {FileSystemDirectoryEntry} */ (entry).createReader();
    const found = [];
    // A reader returns a hundred entries at a time.
    for (;;) {
        const some = await new Promise((done, failed) => reader.readEntries(done, failed));
        if (!some.length) break;
        found.push(...some);
    }
    return (await Promise.all(found.map(inside))).flat();
}

/**
 * Returns the source that the engine opens. Throws if the scene file is not clear.
 * @param {{ path: string, file: File }[]} given @param {AbortSignal} [signal]
 * @param {number} [most] bytes of all files together
 */
export async function source(given, signal, most = MOST_BYTES) {
    check(given, most);
    const files = [];
    // One after the other, since all archives together may have so many bytes.
    for (const one of given) {
        if (ARCHIVE.test(one.path)) files.push(...(await unzipped(one.file, most - total(files), signal)));
        else files.push(one);
    }
    check(files, most);
    const scenes = files.filter(({ path }) => SCENES.test(path));
    if (!scenes.length) {
        const names = files
            .map(({ path }) => path)
            .slice(0, 5)
            .join(", ");
        throw new Error(`${names || "no files"}: no .obj, .gltf, .glb, .ply, .stl or .zip file was given`);
    }
    if (scenes.length > 1) {
        const names = scenes
            .map(({ path }) => path)
            .slice(0, 5)
            .join(", ");
        throw new Error(`${names}: open one model at a time, with its own files`);
    }
    const main = scenes[0].path;
    return { files, main, name: main.replace(/^.*\//, "").replace(SCENES, "") };
}

/** @param {{ file: File }[]} files */
const total = (files) => files.reduce((sum, { file }) => sum + file.size, 0);

/** @param {{ file: File }[]} files @param {number} most */
function check(files, most) {
    const bytes = total(files);
    if (bytes <= most) return;
    const found = Math.round(bytes / 2 ** 20);
    throw new Error(`the files have ${found} MiB in total; the page can open at most ${most / 2 ** 20} MiB`);
}

/** Returns an address, relative to the page's, or null. @param {string} text */
function addressOf(text) {
    try {
        return new URL(text, location.href);
    } catch {
        return null;
    }
}

/** Returns the name of a file in an address. @param {URL} address */
function nameIn({ pathname }) {
    const name = pathname.split("/").at(-1) ?? "";
    try {
        return decodeURIComponent(name);
    } catch {
        return name;
    }
}

/**
 * Fetches a model that another page may read (CORS). Nothing that identifies the reader is sent.
 * @param {string} text an address, relative to the page's
 * @param {AbortSignal} signal @param {(share: number) => void} tell
 */
export async function fetched(text, signal, tell) {
    const address = addressOf(text);
    if (!address || !/^https?:$/.test(address.protocol)) throw new Error("it is no http or https address");
    const name = nameIn(address);
    if (!SCENES.test(name) && !ARCHIVE.test(name)) {
        throw new Error("the address must end in .obj, .gltf, .glb, .ply, .stl or .zip");
    }
    const ending = new AbortController();
    signal.addEventListener("abort", () => ending.abort());
    /** Waits for a part of the answer. @param {Promise<any>} part @param {string} fault */
    const waited = async (part, fault) => {
        const timer = setTimeout(() => ending.abort(), PATIENCE_MS);
        try {
            return await part;
        } catch {
            signal.throwIfAborted();
            const late = `the server sent nothing for ${PATIENCE_MS / 1000} seconds`;
            throw new Error(ending.signal.aborted ? late : fault);
        } finally {
            clearTimeout(timer);
        }
    };
    const response = await waited(
        fetch(address, { credentials: "omit", referrerPolicy: "no-referrer", signal: ending.signal }),
        "the server can't be reached, or does not let other pages read the file (CORS)",
    );
    if (!response.ok || !response.body)
        throw new Error(`the server answered ${response.status} ${response.statusText}`.trim());
    const length = Number(response.headers.get("content-length"));
    const most = () => new Error(`the file has more than ${MOST_FETCHED / 2 ** 20} MiB`);
    if (length > MOST_FETCHED) throw most();
    const parts = [];
    let bytes = 0;
    const reader = response.body.getReader();
    for (;;) {
        const { done, value } = await waited(reader.read(), "the connection ended early");
        if (done) break;
        parts.push(value);
        bytes += value.byteLength;
        if (bytes > MOST_FETCHED) {
            await reader.cancel();
            throw most();
        }
        if (length) tell(Math.min(1, bytes / length));
    }
    return new File(parts, name);
}
