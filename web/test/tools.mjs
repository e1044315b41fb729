// What the tests of the page share: a browser, pages in it, and what they show. page.mjs says how they are run.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { mkdir, readFile, readdir, rm, writeFile } from "node:fs/promises";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { promisify } from "node:util";
import { serve } from "../serve.mjs";

export const [site, out, playwright, executablePath, native, scenes, axe, iwer, full] = process.argv.slice(2);
const { chromium } = await import(pathToFileURL(path.join(playwright, "index.mjs")).href);
const run = promisify(execFile);
/** Long enough for a kernel's first compilation on two cores that do other work too. */
export const TIMEOUT = 120_000;

await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
export const { address } = await serve(site);
const flags = [
    "--no-sandbox",
    "--enable-unsafe-webgpu",
    "--headless=new",
    "--host-resolver-rules=MAP insecure.test 127.0.0.1",
];
const browser = await chromium.launch({ executablePath, args: flags });
let failures = 0;
export const figures = {};

/** Runs a test. The environment variable ONLY leaves out tests whose names it does not match. */
export async function test(name, work) {
    if (!new RegExp(process.env.ONLY ?? "").test(name)) return;
    const begin = performance.now();
    try {
        await work();
        console.log(`ok    ${name} (${((performance.now() - begin) / 1000).toFixed(1)} s)`);
    } catch (error) {
        failures += 1;
        console.log(`FAILED ${name}\n${error.stack ?? error}`);
    }
}

/** Opens a page and collects its errors. */
export async function opened(
    query = "",
    { viewport = { width: 1280, height: 860 }, at = address, prepare, ...options } = {},
) {
    const context = await browser.newContext({ viewport, acceptDownloads: true, ...options });
    const page = await context.newPage();
    page.setDefaultTimeout(TIMEOUT);
    const faults = [];
    page.on("pageerror", (error) => faults.push(String(error)));
    const foreign = [];
    page.on("request", (request) => {
        if (!request.url().startsWith(address) && !/^(blob|data):/.test(request.url())) foreign.push(request.url());
    });
    // Long tasks of the main thread are recorded, once the page is there.
    await page.addInitScript(() => {
        globalThis.longTasks = [];
        new PerformanceObserver((list) =>
            globalThis.longTasks.push(...list.getEntries().map(({ startTime, duration }) => [startTime, duration])),
        ).observe({ type: "longtask", buffered: true });
    });
    await prepare?.(page, context);
    await page.goto(at + query);
    return { page, context, faults, foreign };
}

/** Waits for a whole picture of the last request. */
export async function whole(page) {
    // A wish is set at once, or within the delay after a drag.
    await page.waitForTimeout(250);
    await page.waitForFunction(
        () => document.documentElement.dataset.state === "whole" && document.querySelector("#busy").hidden,
    );
}

export async function choose(page, id, value) {
    await page.evaluate(() => {
        document.documentElement.dataset.state = "";
    });
    await page.selectOption(`#${id}`, value);
    if (id !== "view" && id !== "glasses") await whole(page);
    else await page.waitForTimeout(500);
}

export async function slide(page, id, value) {
    await page.evaluate(
        ([id, value]) => {
            document.documentElement.dataset.state = "";
            const slider = document.querySelector(`#${id}`);
            slider.value = value;
            for (const name of ["input", "change"]) slider.dispatchEvent(new Event(name, { bubbles: true }));
        },
        [id, value],
    );
    await whole(page);
}

/** Returns the pixels of the canvas. */
export const pixels = (page) =>
    page.evaluate(() => {
        const canvas = document.querySelector("#picture");
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return { width: canvas.width, height: canvas.height, data: [...data] };
    });

export async function drop(page, files) {
    const given = await Promise.all(
        files.map(async (file) =>
            typeof file === "string" ? { name: path.basename(file), bytes: [...(await readFile(file))] } : file,
        ),
    );
    await page.evaluate((given) => {
        document.documentElement.dataset.state = "";
        const transfer = new DataTransfer();
        for (const { name, bytes } of given) transfer.items.add(new File([new Uint8Array(bytes)], name));
        for (const name of ["dragenter", "dragover", "drop"])
            document.body.dispatchEvent(
                new DragEvent(name, { bubbles: true, cancelable: true, dataTransfer: transfer }),
            );
    }, given);
}

/** Returns the pixels of a PNG file, decoded by the browser. */
export const decoded = (page, bytes) =>
    page.evaluate(
        async (bytes) => {
            const bitmap = await createImageBitmap(new Blob([new Uint8Array(bytes)], { type: "image/png" }), {
                premultiplyAlpha: "none",
                colorSpaceConversion: "none",
            });
            const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
            const context = canvas.getContext("2d");
            context.drawImage(bitmap, 0, 0);
            return [...context.getImageData(0, 0, bitmap.width, bitmap.height).data];
        },
        [...bytes],
    );

/** Renders the page's pictures natively. */
export async function natively(folder, request) {
    await mkdir(folder, { recursive: true });
    const file = path.join(folder, "request.json");
    await writeFile(file, JSON.stringify(request));
    const { stdout } = await run(native, [file, folder], { maxBuffer: 1 << 20 });
    return JSON.parse(stdout);
}

/** Returns the difference between two lists of bytes. */
export function difference(a, b) {
    assert.equal(a.length, b.length);
    let count = 0;
    let most = 0;
    a.forEach((value, index) => {
        if (value !== b[index]) count += 1;
        most = Math.max(most, Math.abs(value - b[index]));
    });
    return { bytes: a.length, differing: count, most };
}

/** Makes the worker record its requests and the devices that it opens. */
export async function watched(page) {
    await page.route("**/engine.js", async (route) => {
        const response = await route.fetch();
        const before = `
            globalThis.devices = [];
            const request = GPUAdapter.prototype.requestDevice;
            GPUAdapter.prototype.requestDevice = async function (...given) {
                const device = await request.apply(this, given);
                globalThis.devices.push(device);
                return device;
            };
            addEventListener("message", ({ data }) => { if (data.task === "render") globalThis.asked = data; });
        `;
        const text = await response.text();
        // Imports are hoisted, so code may come before them.
        await route.fulfill({ response, body: before + text });
    });
}

/** Writes figures, and ends the browser and the process. */
export async function finish() {
    await writeFile(path.join(out, "figures.json"), JSON.stringify(figures, null, 1));
    console.log(`wrote ${(await readdir(out)).join(", ")} into ${out}`);
    await browser.close();
    if (failures) console.log(`${failures} failed`);
    // A failed test may have left a server behind.
    process.exit(failures ? 1 : 0);
}
