// Tests what the page says and does when something is missing, lost or stopped.
import assert from "node:assert/strict";
import { address, choose, drop, opened, pixels, test, watched, whole } from "./tools.mjs";

await test("a lost device is opened again, and that is said", async () => {
    const { page, context } = await opened("?scene=three-spheres&size=96x72", { prepare: watched });
    await whole(page);
    const before = JSON.stringify(await pixels(page));
    await page.workers()[0].evaluate(() => globalThis.devices.at(-1).destroy());
    await choose(page, "method", "naive");
    assert.match(await page.locator("#message p").innerText(), /lost, and was opened again/);
    await choose(page, "method", "auto");
    assert.equal(JSON.stringify(await pixels(page)), before);
    await context.close();
});

await test("a notice goes away once a picture succeeds", async () => {
    const { page, context } = await opened("?scene=three-spheres&size=96x72");
    await whole(page);
    await drop(page, [{ name: "notes.txt", bytes: [1] }]);
    await page.waitForFunction(() => !document.querySelector("#message").hidden);
    await choose(page, "method", "naive");
    assert.ok(await page.locator("#message").isHidden());
    await context.close();
});

await test("Stop ends even a compilation, and so does another scene", async () => {
    // An engine that never answers is what a driver's compilation of a kernel looks like.
    const hang = (page) =>
        page.route("**/engine.js", async (route) => {
            const response = await route.fetch();
            const text = await response.text();
            const broken = text.replace(
                "async render({",
                `async render(request) {
                    const hangs = request.options.method === "ideal" && open.source.builtin === "three-spheres";
                    if (hangs) await new Promise(() => {});
                    return this.rendered(...arguments);
                },
                async rendered({`,
            );
            assert.notEqual(text, broken);
            await route.fulfill({ response, body: broken });
        });
    const { page, context, faults } = await opened("?scene=three-spheres&size=96x72&method=naive&view=left", {
        prepare: hang,
    });
    await whole(page);
    const before = JSON.stringify(await pixels(page));
    await page.selectOption("#method", "ideal");
    await page.waitForFunction(() => !document.querySelector("#busy").hidden);
    const begin = performance.now();
    await page.click("#stop");
    await page.waitForFunction(() => /was stopped/.test(document.querySelector("#message p").textContent));
    assert.ok(performance.now() - begin < 4000);
    assert.ok(await page.locator("#busy").isHidden());
    // A view needs a picture of the new engine.
    await page.selectOption("#method", "naive");
    await page.evaluate(() => {
        document.documentElement.dataset.state = "";
    });
    await choose(page, "view", "right");
    await whole(page);
    await choose(page, "view", "left");
    assert.ok(JSON.stringify(await pixels(page)) === before, "another picture");
    assert.equal(page.workers().length, 1);
    assert.ok(await page.locator("#message").isHidden());
    await page.selectOption("#method", "ideal");
    await page.waitForTimeout(300);
    await page.selectOption("#scene", "random-20");
    await page.waitForFunction(() => document.querySelector("#about").textContent === "392 triangles, 20 other shapes");
    await whole(page);
    assert.deepEqual(faults, []);
    await context.close();
});

/** Replaces a part of engine.js. */
const altered = (before, after) => (page) =>
    page.route("**/engine.js", async (route) => {
        const response = await route.fetch();
        const text = await response.text();
        assert.ok(text.includes(before));
        await route.fulfill({ response, body: text.replace(before, after) });
    });

await test("a scene that is never open is given up by Stop, and replaced by another one", async () => {
    const hang = altered(
        "async open({ source, size }) {",
        `async open({ source, size }) {
            if (source.builtin === "random-20") await new Promise(() => {});`,
    );
    const { page, context, faults } = await opened("?scene=three-spheres&size=96x72&method=naive&view=left", {
        prepare: hang,
    });
    await whole(page);
    const before = JSON.stringify(await pixels(page));
    await page.selectOption("#scene", "random-20");
    await page.waitForFunction(() => !document.querySelector("#busy").hidden);
    await page.click("#stop");
    await page.waitForFunction(() => /Opening was stopped/.test(document.querySelector("#message p").textContent));
    await whole(page);
    assert.equal(await page.locator("#scene").inputValue(), "three-spheres");
    assert.ok(JSON.stringify(await pixels(page)) === before, "another picture");
    await page.selectOption("#scene", "random-20");
    await page.waitForTimeout(300);
    await page.selectOption("#scene", "fence");
    await page.waitForFunction(() => document.documentElement.dataset.state === "whole");
    assert.equal(await page.locator("#scene").inputValue(), "fence");
    assert.equal(page.workers().length, 1);
    assert.ok(await page.locator("#message").isHidden());
    // A file that can't be read, while the engine hangs over another scene: the scene before comes back.
    await page.selectOption("#scene", "random-20");
    await page.waitForTimeout(300);
    await drop(page, [{ name: "broken.obj", bytes: [...Buffer.from("v 0 0 0\nf 1 2 9\n")] }]);
    await page.waitForFunction(() => /broken\.obj/.test(document.querySelector("#message p").textContent));
    await whole(page);
    assert.equal(await page.locator("#scene").inputValue(), "fence");
    assert.match(await page.locator("#message p").innerText(), /broken\.obj/, "a picture does not hide this");
    assert.deepEqual(faults, []);
    await context.close();
});

await test("an engine that stops at each picture is restarted twice", async () => {
    const stops = altered(
        "async render({",
        `async render() { throw new WebAssembly.RuntimeError("unreachable"); },
        async unused({`,
    );
    const { page, context, faults } = await opened("?scene=three-spheres&size=96x72", { prepare: stops });
    let engines = 0;
    page.on("worker", () => (engines += 1));
    await page.waitForFunction(() => /after each restart/.test(document.querySelector("#message p").textContent));
    await page.waitForTimeout(500);
    assert.ok(engines <= 4, `${engines} engines`);
    assert.ok(await page.locator("#busy").isHidden());
    assert.deepEqual(faults, []);
    await context.close();
});

/** Opens a page that can render nothing, and returns its words. */
async function nothing(query, options, expected) {
    const { page, context, faults } = await opened(query, options);
    await page.waitForFunction(() => document.documentElement.dataset.state === "nothing");
    assert.match(await page.locator("#message p").innerText(), expected);
    assert.ok(await page.locator("#scene").isDisabled());
    assert.ok(await page.locator("#poster").isVisible());
    assert.match(await page.locator("#sentence").innerText(), /made before/);
    await drop(page, [{ name: "a.obj", bytes: [1] }]);
    await page.waitForFunction(() => /can't be shown/.test(document.querySelector("#message p").textContent));
    assert.match(await page.locator("#message p").innerText(), expected);
    assert.deepEqual(faults, []);
    await context.close();
}

await test("without WebGPU, and over http, the page says so, and again to dropped models", async () => {
    const hide = (page) =>
        page.addInitScript(() => {
            delete Navigator.prototype.gpu;
        });
    await nothing("", { prepare: hide }, /no WebGPU/);
    await nothing("", { at: address.replace("127.0.0.1", "insecure.test") }, /only over https and on localhost/);
    const lacking = (page) => page.route("**/engine.js", (route) => route.fulfill({ status: 404, body: "" }));
    await nothing("", { prepare: lacking }, /engine could not be loaded/);
});

await test("scripts that can't be loaded are said", async () => {
    const lacking = (page) => page.route("**/app.js", (route) => route.fulfill({ status: 404, body: "" }));
    const { page, context } = await opened("", { prepare: lacking });
    await page.locator(".unloaded").waitFor();
    assert.match(await page.locator(".unloaded").innerText(), /from a web server, not as a file/);
    assert.ok(await page.locator("#poster").isVisible());
    await context.close();
});
