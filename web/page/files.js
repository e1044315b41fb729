// Reads dropped files and the files in dropped folders, by their paths.
// @ts-check

/** Maximum size of all files together. A page has 4 GiB of memory for everything that is made from them. */
const MOST_BYTES = 1 << 30;
const SCENES = /\.(obj|gltf|glb|ply)$/i;

/** @param {DataTransfer} transfer @returns {Promise<{ path: string, file: File }[]>} */
export async function dropped(transfer) {
    // Entries are gone once the event is over, so all are requested before anything is awaited.
    const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter((entry) => entry !== null && entry !== undefined);
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
 * @param {{ path: string, file: File }[]} files
 */
export function source(files) {
    const bytes = files.reduce((sum, { file }) => sum + file.size, 0);
    if (bytes > MOST_BYTES) {
        const [found, most] = [Math.round(bytes / 2 ** 20), MOST_BYTES / 2 ** 20];
        throw new Error(`the files have ${found} MiB in total; the page can open at most ${most} MiB`);
    }
    const scenes = files.filter(({ path }) => SCENES.test(path));
    if (!scenes.length) {
        const names = files.map(({ path }) => path).slice(0, 5).join(", ");
        throw new Error(`${names || "no files"}: no .obj, .gltf, .glb or .ply file was given`);
    }
    if (scenes.length > 1) {
        const names = scenes.map(({ path }) => path).slice(0, 5).join(", ");
        throw new Error(`${names}: open one model at a time, with its own files`);
    }
    const main = scenes[0].path;
    return { files, main, name: main.replace(/^.*\//, "").replace(SCENES, "") };
}
