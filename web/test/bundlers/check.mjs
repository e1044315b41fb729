// Opens what the bundlers made, and Vite's own server, and compares their pictures.
import assert from "node:assert/strict";
import { readdir } from "node:fs/promises";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { createServer } from "vite";

const [playwright, executablePath, server] = process.argv.slice(2);
const { chromium } = await import(pathToFileURL(path.join(playwright, "index.mjs")).href);
const { serve } = await import(pathToFileURL(server).href);

const browser = await chromium.launch({
    executablePath,
    args: ["--no-sandbox", "--enable-unsafe-webgpu", "--headless=new"],
});
let expected;
let failed = 0;

async function look(name, address) {
    const page = await browser.newPage();
    const faults = [];
    page.on("pageerror", (error) => faults.push(String(error)));
    page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
    try {
        await page.goto(address);
        await page.waitForFunction(() => globalThis.pictures, undefined, { timeout: 60_000 });
        const pictures = await page.evaluate(() => globalThis.pictures);
        expected ??= pictures[0];
        assert.match(pictures[0], /^64 48 \d+ \d+$/);
        assert.deepEqual(pictures, pictures.map(() => expected));
        console.log(`ok    ${name}: ${pictures.join(", ")}`);
    } catch (error) {
        failed += 1;
        console.log(`FAILED ${name}: ${error.message}\n${faults.join("\n")}`);
    }
    await page.close();
}

for (const name of (await readdir("dist")).sort()) {
    const { server, address } = await serve(path.join("dist", name));
    await look(name, address);
    server.close();
}
const vite = await createServer({ root: ".", server: { port: 0 }, logLevel: "warn" });
await vite.listen();
await look("vite's server", vite.resolvedUrls.local[0]);
await vite.close();
await browser.close();
process.exit(failed ? 1 : 0);
