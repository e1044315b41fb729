// Tests that a view is a link, and that other pages can embed it and set views.
import assert from "node:assert/strict";
import http from "node:http";
import { address, choose, opened, pixels, slide, test, whole } from "./tools.mjs";

/** Waits until the address has the shown view. */
const remembered = (page) => page.waitForTimeout(600);

await test("the address follows the view, and leads back to it", async () => {
    const { page, context, faults } = await opened("?size=96x72&scene=three-spheres&method=bracket&view=slider&e=1");
    await whole(page);
    await remembered(page);
    const asked = () => Object.fromEntries(new URL(page.url()).searchParams);
    assert.deepEqual(
        asked(),
        { size: "96x72", scene: "three-spheres", method: "bracket" },
        "the usual values are left out",
    );
    await slide(page, "e", "2");
    await slide(page, "d", "-1");
    await slide(page, "samples", "2");
    await choose(page, "view", "anaglyph");
    await choose(page, "glasses", "grey");
    await page.evaluate(() => {
        document.documentElement.dataset.state = "";
    });
    await page.locator("#picture").focus();
    for (const key of ["ArrowLeft", "ArrowUp", "-", "-"]) await page.keyboard.press(key);
    await whole(page);
    await remembered(page);
    const { camera, ...rest } = asked();
    const expected = {
        size: "96x72",
        scene: "three-spheres",
        method: "bracket",
        e: "2",
        d: "0.5",
        samples: "4",
        view: "anaglyph",
        glasses: "grey",
    };
    assert.deepEqual(rest, expected);
    assert.match(camera, /^([-\d.]+,){5}[-\d.]+$/);
    assert.doesNotMatch(page.url(), /%/);
    const there = await opened(new URL(page.url()).search);
    await whole(there.page);
    assert.ok(await there.page.locator("#message").isHidden());
    const [here, again] = [(await pixels(page)).data, (await pixels(there.page)).data];
    const most = Math.max(
        ...here
            .map((value, index) => Math.abs(value - again[index]))
            .sort((a, b) => a - b)
            .slice(0, Math.floor(0.99 * here.length)),
    );
    assert.ok(most <= 2, `the pictures differ by ${most}`);
    await there.context.close();
    // A head that is turned is part of the view too.
    await page.evaluate(() => {
        document.documentElement.dataset.state = "";
    });
    await page.selectOption("#projection", "360");
    await whole(page);
    await page.locator("#picture").focus();
    await page.keyboard.press("ArrowRight");
    await remembered(page);
    assert.match(asked().head, /^4\.6,[-\d.]+,70\.0$/);
    const turned = await opened(new URL(page.url()).search);
    await whole(turned.page);
    await remembered(turned.page);
    assert.equal(new URL(turned.page.url()).search, new URL(page.url()).search);
    await turned.context.close();
    assert.deepEqual(faults, []);
    await context.close();
});

await test("wrong values of an address are said, and the others are used", async () => {
    const wrong =
        "?scene=hell&method=magic&e=9&d=x&samples=5&size=3x3&camera=1,2&projection=90&view=slide&lights=-1&head=1";
    const { page, context } = await opened(`${wrong.replace("&head=1", "")}&glasses=grey`);
    await page.waitForFunction(() => /scene=hell/.test(document.querySelector("#message p").textContent));
    const text = await page.locator("#message p").innerText();
    for (const [name, value] of new URLSearchParams(wrong.replace("&head=1", "")))
        assert.ok(text.includes(`${name}=${value}: `), `${name} in ${text}`);
    assert.match(text, /e=9: it must be a number from 0 to 4\./);
    assert.match(text, /samples=5: it must be a square number from 1 to 25\./);
    assert.match(text, /method=magic: it must be one of auto|method=magic: it must be one of .*auto/);
    assert.equal(await page.locator("#glasses").inputValue(), "grey");
    assert.equal(await page.locator("#scene").inputValue(), "hall");
    await context.close();
    const head = await opened("?scene=three-spheres&size=96x72&projection=180&head=1");
    await whole(head.page);
    // A picture that succeeds does not hide this.
    assert.match(await head.page.locator("#message p").innerText(), /head=1: it must be three numbers/);
    await head.context.close();
    const above = await opened("?scene=three-spheres&size=96x72&camera=0,9,0.1,0,0,0&lights=2.5");
    await whole(above.page);
    const said = await above.page.locator("#message p").innerText();
    assert.match(said, /camera=0,9,0\.1,0,0,0: it must not look straight up or down\./);
    assert.match(said, /lights=2\.5: it must be a whole number from 0 to 8\./);
    await above.context.close();
});

await test("a view is shared", async () => {
    const { page, context } = await opened("?size=96x72&scene=three-spheres", {
        permissions: ["clipboard-read", "clipboard-write"],
    });
    await whole(page);
    await choose(page, "view", "right");
    await page.click("#share");
    await page.waitForFunction(() => document.querySelector("#shared").textContent);
    assert.match(await page.locator("#shared").innerText(), /in the clipboard/);
    const link = await page.evaluate(() => navigator.clipboard.readText());
    assert.ok(link.startsWith(address) && link.includes("view=right"), link);
    await page.evaluate(() => {
        navigator.clipboard.writeText = async () => {
            throw new Error("denied");
        };
    });
    await page.click("#share");
    await page.waitForFunction(() => !document.querySelector("#link").hidden);
    assert.equal(await page.locator("#link").inputValue(), link);
    await choose(page, "view", "left");
    await remembered(page);
    assert.ok(await page.locator("#link").isHidden(), "it is the link to another view");
    assert.equal(await page.locator("#shared").textContent(), "");
    await context.close();
});

/** Serves a page. */
const site = (body) =>
    new Promise((done) => {
        const server = http.createServer((_, response) =>
            response.writeHead(200, { "content-type": "text/html" }).end(body),
        );
        server.listen(0, "127.0.0.1", () => done({ server, url: `http://127.0.0.1:${server.address().port}/` }));
    });

await test("another site embeds the page, sets views, and is told what they cost", async () => {
    const query = "?scene=three-spheres&size=96x72&method=bracket";
    const host = await site(`<script>
            heard = [];
            addEventListener("message", (event) => heard.push([event.origin, event.data]));
        </script>
        <iframe src="${address}${query}" width="500" height="500" allow="fullscreen"></iframe>`);
    const { page, context, faults } = await opened("", { at: host.url });
    const heard = (kind, least = 1) =>
        page
            .waitForFunction(
                ([kind, least]) => {
                    const found = globalThis.heard.filter(([, data]) => data.stereotrace === kind);
                    return found.length >= least && found.at(-1);
                },
                [kind, least],
            )
            .then((found) => found.jsonValue());
    const [origin, ready] = await heard("ready");
    assert.equal(origin, new URL(address).origin);
    assert.deepEqual(ready, { stereotrace: "ready" });
    const frame = page.frames()[1];
    await whole(frame);
    assert.ok(await frame.locator("#panel").isHidden());
    assert.ok(await frame.locator("#tools").isVisible());
    assert.equal((await page.evaluate(() => globalThis.heard)).length, 1, "a host that says nothing is told nothing");
    // The frame itself is another window than its host.
    await frame.evaluate(() => postMessage({ stereotrace: "set", values: { view: "right" } }, "*"));
    await page.waitForTimeout(300);
    assert.equal(await frame.locator("#view").inputValue(), "slider");
    const set = (values) =>
        page.evaluate(
            ([values, origin]) => frames[0].postMessage({ stereotrace: "set", values }, origin),
            [values, origin],
        );
    await set({ view: "left", e: 2, samples: 4 });
    const [, { values, cost }] = await heard("picture");
    assert.deepEqual(values, { ...Object.fromEntries(new URLSearchParams(query)), view: "left", e: "2", samples: "4" });
    assert.ok(
        cost.leftMs > 0 && cost.rightMs > 0 && cost.retracedShare < 0.5 && cost.method === "bracket",
        JSON.stringify(cost),
    );
    await set({ e: 40 });
    assert.match((await heard("error"))[1].message, /e=40: it must be a number/);
    await set(null);
    assert.match((await heard("error", 2))[1].message, /values: it must be an object/);
    await set({ scene: "random-20", size: "96x72", method: "naive" });
    await page.waitForFunction(() => globalThis.heard.at(-1)[1].values?.scene === "random-20");
    assert.equal(await frame.locator("#whole-page").isVisible(), true);
    assert.deepEqual(faults, []);
    await context.close();
    host.server.close();
});

await test("a host that answers the page's first message has its values in the first picture it is told", async () => {
    const host = await site(`<script>
            pictures = [];
            addEventListener("message", ({ source, data }) => {
                const values = { e: 1.5, method: "naive" };
                if (data.stereotrace === "ready") source.postMessage({ stereotrace: "set", values }, "*");
                if (data.stereotrace === "picture") pictures.push(data);
            });
        </script>
        <iframe src="${address}?scene=three-spheres&size=96x72" width="500" height="500"></iframe>`);
    const { page, context, faults } = await opened("", { at: host.url });
    await page.waitForFunction(() => globalThis.pictures.length);
    const [{ values, cost }] = await page.evaluate(() => globalThis.pictures);
    assert.deepEqual(values, { scene: "three-spheres", size: "96x72", e: "1.5", method: "naive" });
    assert.equal(cost.method, "naive");
    assert.deepEqual(faults, []);
    await context.close();
    host.server.close();
});
