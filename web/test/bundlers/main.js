// The page's own thread and a worker render the same pair.
import { picture } from "./picture.js";

const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
const answer = new Promise((done) => {
    worker.onmessage = ({ data }) => done(data);
    worker.onerror = ({ message }) => done(`the worker failed: ${message}`);
});
globalThis.pictures = Promise.all([picture().catch(String), answer]);
