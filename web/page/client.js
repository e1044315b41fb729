// The engine (engine.js) as the page sees it: a worker that is asked by messages and answers each of them.
// @ts-check

/** @param {string} message */
const aborted = (message) => new DOMException(message, "AbortError");

/** @typedef {(done: number) => void} Tell receives progress, 0 to 1 */
/** @typedef {{ done: (result: any) => void, failed: (error: any) => void, tell?: Tell }} Asked */

export class Engine {
    constructor() {
        /** @type {Map<number, Asked>} */
        this.waiting = new Map();
        this.last = 0;
        this.ended = false;
        this.worker = new Worker("engine.js", { type: "module" });
        /** @type {(error: any) => void} */
        this.refuse = () => {};
        this.ready = new Promise((done, failed) => {
            let ready = false;
            this.refuse = failed;
            this.worker.onerror = (event) => {
                const reason = event.message ?? "see the browser's console";
                failed(new Error(`the engine could not be loaded: ${reason}`));
                // An error between two messages, such as a panic while waiting for the device, answers none of them.
                this.#fail(Object.assign(new Error(reason), { name: ready ? "RuntimeError" : "Error" }));
            };
            this.worker.onmessage = ({ data }) => {
                if (data.ready) {
                    ready = true;
                    return done(undefined);
                }
                const asked = this.waiting.get(data.id);
                if (!asked) return;
                if ("done" in data) return asked.tell?.(data.done);
                this.waiting.delete(data.id);
                if (data.error) asked.failed(Object.assign(new Error(data.error.message), { name: data.error.name }));
                else asked.done(data.result);
            };
        });
        // Each task reports the failure, and no task may be waiting.
        this.ready.catch(() => {});
    }

    /** @param {any} error */
    #fail(error) {
        for (const { failed } of this.waiting.values()) failed(error);
        this.waiting.clear();
    }

    /** @param {string} task @param {object} request @param {Tell | undefined} [tell] @returns {Promise<any>} */
    async ask(task, request = {}, tell) {
        await this.ready;
        if (this.ended) throw aborted("the engine was replaced");
        const id = ++this.last;
        return new Promise((done, failed) => {
            this.waiting.set(id, { done, failed, tell });
            this.worker.postMessage({ id, task, ...request });
        });
    }

    /** Ends the current rendering with an AbortError, after the rows that the device is rendering. */
    stop() {
        this.worker.postMessage({ task: "stop" });
    }

    /** Ends the worker. All that it was asked for ends with an AbortError. */
    end() {
        this.ended = true;
        this.worker.terminate();
        this.refuse(aborted("the engine was ended"));
        this.#fail(aborted("the engine was ended"));
    }
}
