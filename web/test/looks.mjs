// Tests what a reader sees first, how the eyes are shown, and how the page looks on screens of several sizes.
import assert from "node:assert/strict";
import { readFile, stat, writeFile } from "node:fs/promises";
import path from "node:path";
import { axe, choose, difference, figures, full, opened, out, pixels, site, slide, test, whole } from "./tools.mjs";

const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };

/** Returns a picture's columns from `from` to before `to`, as bytes. */
function columns({ width, height, data }, from, to) {
    const found = [];
    for (let y = 0; y < height; y += 1) found.push(...data.slice(4 * (y * width + from), 4 * (y * width + to)));
    return found;
}

await test("a picture and what the page is are there before WebGPU is", async () => {
    let go;
    const held = new Promise((done) => {
        go = done;
    });
    const hold = (page) =>
        page.route("**/engine.js", async (route) => {
            await held;
            await route.continue();
        });
    const { page, context, faults } = await opened("?size=96x72&scene=three-spheres", { ...PHONE, prepare: hold });
    const poster = page.locator("#poster");
    await poster.waitFor();
    assert.ok(
        (await poster.evaluate(async (image) => {
            await image.decode();
            return image.naturalWidth;
        })) > 600,
    );
    for (const part of ["h1", "header p", "#poster"]) {
        const { y, height } = await page.locator(part).boundingBox();
        assert.ok(y + height < 844, `${part} is not on a phone's first screen`);
    }
    assert.match(await page.locator("header p").innerText(), /right eye is cheap/);
    await page.screenshot({ path: path.join(out, "before.png") });
    go();
    await whole(page);
    assert.ok(await poster.isHidden());
    assert.deepEqual(faults, []);
    await context.close();
});

await test("links, icon and previews are there", async () => {
    const { page, context } = await opened("?size=96x72&scene=three-spheres");
    const links = await page.locator("footer a").evaluateAll((all) => all.map((link) => link.href));
    assert.ok(links.length >= 3, String(links));
    for (const link of links) assert.equal((await fetch(link)).status, 200, link);
    const text = await readFile(path.join(site, "index.html"), "utf8");
    assert.ok(!text.includes("@"), "an address is not filled in");
    // Previews need whole addresses.
    for (const [, link] of text.matchAll(/property="og:(?:image|url)" content="([^"]*)"/g)) assert.match(link, /^http/);
    assert.match(text, /rel="icon"[^>]*svg/);
    assert.ok((await stat(path.join(site, "poster.jpg"))).size < 60_000);
    await context.close();
});

await test("a sentence has the figures of the last picture, and the choice of auto is said", async () => {
    const { page, context } = await opened("?scene=hall&size=192x144&method=bracket");
    await whole(page);
    const sentence = () => page.locator("#sentence").innerText();
    const [, left, right, share] =
        /^Left eye ([\d.]+) ms, right eye ([\d.]+) ms: ([\d.]+)% of its pixels were traced again\.$/.exec(
            await sentence(),
        ) ?? [];
    assert.ok(left > 0 && right > 0 && share > 0 && share < 50, await sentence());
    assert.ok(await page.locator("#choice").isHidden());
    await choose(page, "method", "naive");
    assert.match(await sentence(), /^Left eye .*: all of its pixels were traced, and none reused\.$/);
    const cards = await page.locator("#figures").innerText();
    assert.match(cards, /traced, nothing reused/);
    assert.doesNotMatch(cards, /re-traced|traced again/);
    await choose(page, "method", "auto");
    assert.ok(await page.locator("#choice").isVisible());
    assert.match(await page.locator("#choice").innerText(), /^auto chose \w+.*predicted to cost/);
    figures.sentence = await sentence();
    await context.close();
});

await test("a divider shows the left eye beside the right eye, and marks what was traced again", async () => {
    const { page, context, faults } = await opened("?scene=hall&size=160x120&method=bracket&view=left");
    await whole(page);
    const left = await pixels(page);
    await choose(page, "view", "right");
    const right = await pixels(page);
    const marks = page.locator("#traced");
    const marked = await marks.evaluate((canvas) => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return data.filter((_, index) => index % 4 === 3 && data[index]).length / (canvas.width * canvas.height);
    });
    const share = Number(/traced again\s*([\d.]+)%/.exec(await page.locator("#figures").innerText())[1]) / 100;
    assert.ok(Math.abs(marked - share) < 0.001 && marked > 0, `${marked} is marked, ${share} was traced`);
    await choose(page, "view", "slider");
    const shown = await pixels(page);
    assert.deepEqual(columns(shown, 0, 80), columns(left, 0, 80));
    assert.deepEqual(columns(shown, 80, 160), columns(right, 80, 160));
    assert.equal(await marks.evaluate((canvas) => getComputedStyle(canvas).clipPath), "inset(0px 0px 0px 50%)");
    assert.equal(await marks.evaluate((canvas) => getComputedStyle(canvas).animationName), "pulse");
    // The divider is dragged by its line.
    const { x, y, width, height } = await page.locator("#screen").boundingBox();
    await page.mouse.move(x + width / 2, y + height / 3);
    await page.mouse.down();
    await page.mouse.move(x + width / 4, y + height / 2, { steps: 4 });
    await page.mouse.up();
    assert.deepEqual(columns(await pixels(page), 40, 160), columns(right, 40, 160));
    await page.locator("#divider").focus();
    await page.keyboard.press("End");
    assert.equal(difference((await pixels(page)).data, left.data).differing, 0, "the divider is at the right end");
    assert.equal(await page.locator("#divider").getAttribute("aria-valuetext"), "left eye in 100% of the width");
    // Beside the line, a drag moves the camera.
    await page.keyboard.press("Home");
    await page.evaluate(() => {
        document.documentElement.dataset.state = "";
    });
    await page.mouse.move(x + width / 2, y + height / 3);
    await page.mouse.down();
    await page.mouse.move(x + width / 4, y + height / 2, { steps: 4 });
    await page.mouse.up();
    await whole(page);
    assert.notEqual(difference((await pixels(page)).data, right.data).differing, 0);
    await page.uncheck("#marked");
    assert.ok(await marks.isHidden());
    await choose(page, "method", "naive");
    await page.check("#marked");
    assert.ok(await marks.isHidden(), "naive reuses nothing, so nothing is traced again");
    assert.deepEqual(faults, []);
    await context.close();
});

/** Returns how many different pictures are seen in a second. */
const swings = (page) =>
    page.evaluate(async () => {
        const canvas = document.querySelector("#picture");
        const found = new Set();
        for (let time = 0; time < 25; time += 1) {
            found.add(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.join());
            await new Promise((done) => setTimeout(done, 41));
        }
        return found.size;
    });

await test("motion can be paused, and waits for those who prefer less of it", async () => {
    const { page, context } = await opened("?scene=three-spheres&size=96x72&method=bracket&view=wiggle");
    await whole(page);
    assert.equal(await swings(page), 2);
    await page.click("#pause");
    assert.equal(await page.locator("#pause").getAttribute("aria-pressed"), "true");
    assert.equal(await swings(page), 1);
    await page.click("#pause");
    assert.equal(await swings(page), 2);
    await choose(page, "view", "left");
    assert.ok(await page.locator("#pause").isHidden(), "nothing moves");
    await context.close();
    const less = await opened("?scene=three-spheres&size=96x72&method=bracket&view=wiggle", {
        reducedMotion: "reduce",
    });
    await whole(less.page);
    assert.equal(await swings(less.page), 1);
    await choose(less.page, "view", "slider");
    assert.equal(
        await less.page.locator("#traced").evaluate((canvas) => getComputedStyle(canvas).animationName),
        "none",
    );
    await choose(less.page, "view", "wiggle");
    await less.page.click("#pause");
    assert.equal(await swings(less.page), 2, "the reader has started it");
    await less.context.close();
});

await test("fields have names and values for screen readers, and the page is walked by keys", async () => {
    const { page, context } = await opened("?scene=three-spheres&size=96x72&method=bracket");
    await whole(page);
    for (const [name, id] of [
        ["Interaxial e", "e"],
        ["Screen distance d", "d"],
        ["Samples per pixel", "samples"],
        ["Lights", "lights"],
    ]) {
        const slider = page.getByRole("slider", { name, exact: true });
        assert.equal(await slider.getAttribute("id"), id);
        await page.locator(`label[for=${id}]`).click();
        assert.equal(await page.evaluate(() => document.activeElement?.id), id, "a label leads to its slider");
        assert.equal(await slider.getAttribute("aria-valuetext"), await page.locator(`#${id}-value`).innerText());
    }
    await slide(page, "samples", "3");
    assert.equal(await page.locator("#samples").getAttribute("aria-valuetext"), "9");
    // A letter acts on the picture alone.
    await page.locator("#share").focus();
    await page.keyboard.press("v");
    assert.equal(await page.locator("#view").inputValue(), "slider");
    await page.locator("#picture").focus();
    await page.keyboard.press("v");
    assert.equal(await page.locator("#view").inputValue(), "wiggle");
    // Every control can be reached, and shows that it has the focus.
    await choose(page, "view", "slider");
    await page.evaluate(() => {
        const begin = document.querySelector("h1");
        begin.tabIndex = -1;
        begin.focus();
    });
    const reached = [];
    for (let step = 0; step < 45; step += 1) {
        await page.keyboard.press("Tab");
        const found = await page.evaluate(() => {
            const { activeElement: active } = document;
            const seen = active?.matches("#files") ? active.closest("label") : active;
            return active === document.body
                ? null
                : { id: active?.id || active?.textContent, outline: seen && getComputedStyle(seen).outlineStyle };
        });
        if (!found) break;
        assert.notEqual(found.outline, "none", `${found.id} shows no focus`);
        reached.push(found.id);
    }
    figures.reached = reached;
    const controls = [
        "picture",
        "divider",
        "view",
        "marked",
        "pause",
        "full",
        "share",
        "files",
        "scene",
        "e",
        "d",
        "method",
        "save",
        "Documentation",
    ];
    for (const id of controls) assert.ok(reached.includes(id), `${id} was not reached: ${reached}`);
    await context.close();
});

await test("full screen is filled by each view, and a tilted phone looks around", async () => {
    const { page, context, faults } = await opened("?scene=three-spheres&method=naive&view=side-by-side", PHONE);
    await whole(page);
    await page.evaluate(() => {
        document.documentElement.dataset.state = "";
    });
    await page.click("#full");
    await whole(page);
    assert.equal(await page.evaluate(() => document.fullscreenElement?.id), "frame");
    assert.equal(await page.evaluate(() => document.activeElement?.id), "picture", "keys change the view");
    const [wide, high] = await page.evaluate(() => [innerWidth, innerHeight]);
    const fills = async () => {
        const { width, height } = await pixels(page);
        assert.ok(Math.abs(width / height - wide / high) < 0.02, `${width}x${height} in ${wide}x${high}`);
    };
    await fills();
    await page.evaluate(() => {
        document.documentElement.dataset.state = "";
    });
    await page.keyboard.press("6");
    await whole(page);
    await fills();
    await page.evaluate(() => {
        document.documentElement.dataset.state = "";
        return document.exitFullscreen();
    });
    await whole(page);
    const before = JSON.stringify(await pixels(page));
    const tilt = (gamma, beta = 10) =>
        page.evaluate(
            ([beta, gamma]) => dispatchEvent(new DeviceOrientationEvent("deviceorientation", { beta, gamma })),
            [beta, gamma],
        );
    await tilt(20);
    await page.waitForTimeout(300);
    assert.ok(JSON.stringify(await pixels(page)) === before, "nobody asked for it");
    await page.evaluate(() => {
        document.documentElement.dataset.state = "";
    });
    await page.click("#tilt");
    // The browser allows it later.
    await page.locator("#tilt[aria-pressed=true]").waitFor();
    for (const gamma of [0, 5, 12]) await tilt(gamma);
    await whole(page);
    assert.ok(JSON.stringify(await pixels(page)) !== before, "a tilt changes nothing");
    // All around, it turns the head. Axes are the screen's.
    await page.selectOption("#size", "320x240");
    await choose(page, "projection", "180");
    const camera = () => new URL(page.url()).searchParams.get("camera");
    const head = async () => {
        await page.waitForTimeout(600);
        return new URL(page.url()).searchParams.get("head")?.split(",").map(Number);
    };
    const [place, [, up]] = [camera(), await head()];
    await tilt(20);
    assert.deepEqual((await head()).slice(0, 2), [8, up]);
    await page.evaluate(() => Object.defineProperty(screen.orientation, "angle", { value: 90 }));
    await tilt(20, 15);
    assert.deepEqual((await head()).slice(0, 2), [13, up]);
    assert.equal(camera(), place, "the eyes stay");
    assert.deepEqual(faults, []);
    await context.close();
});

await test("axe finds no fault, in light and dark, wide and narrow", async () => {
    for (const options of [{}, { colorScheme: "dark" }, { ...PHONE, colorScheme: "dark" }]) {
        const { page, context } = await opened("?scene=three-spheres&size=96x72&method=bracket", options);
        await whole(page);
        await page.addScriptTag({ path: path.join(axe, "axe.min.js") });
        const violations = await page.evaluate(async () =>
            (await globalThis.axe.run()).violations.map(({ id, nodes }) => [id, nodes.map(({ html }) => html)]),
        );
        assert.deepEqual(violations, []);
        await context.close();
    }
});

await test("screenshots", async () => {
    for (const [width, height] of [
        [1280, 860],
        [800, 1100],
        [390, 844],
    ]) {
        for (const colorScheme of ["light", "dark"]) {
            const size = width > 400 ? "512x384" : "320x240";
            const { page, context } = await opened(`?method=bracket&size=${size}`, {
                viewport: { width, height },
                colorScheme,
            });
            await whole(page);
            // The marks are shown at their brightest.
            await page.evaluate(() => {
                for (const animation of document.getAnimations()) [animation.currentTime] = [1100, animation.pause()];
            });
            const wide = await page.evaluate(() => [
                document.documentElement.scrollWidth,
                document.documentElement.clientWidth,
            ]);
            assert.ok(wide[0] <= wide[1], `${wide[0]} over ${wide[1]}`);
            await page.screenshot({ path: path.join(out, `${width}-${colorScheme}.png`), fullPage: true });
            await context.close();
        }
    }
});

await test("two fingers come nearer", async () => {
    const { page, context } = await opened("?scene=hall&size=320x240", { ...PHONE, colorScheme: "dark" });
    await whole(page);
    const before = JSON.stringify(await pixels(page));
    const touch = await context.newCDPSession(page);
    const { x, y, width } = await page.locator("#picture").boundingBox();
    await page.evaluate(() => {
        document.documentElement.dataset.state = "";
    });
    // One finger is left of the divider, and one is right of it.
    for (const [type, apart] of [
        ["touchStart", 40],
        ["touchMove", 70],
        ["touchMove", 110],
    ]) {
        const touchPoints = [-1, 1].map((side, id) => ({ x: x + width / 2 + side * apart, y: y + 100, id }));
        await touch.send("Input.dispatchTouchEvent", { type, touchPoints });
    }
    await touch.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
    await whole(page);
    assert.notEqual(JSON.stringify(await pixels(page)), before, "a pinch changes nothing");
    await context.close();
});

if (full)
    await test("the poster", async () => {
        const { page, context } = await opened("?method=bracket&samples=4&size=720x540");
        await whole(page);
        const bytes = await page.evaluate(async () => {
            const [picture, traced] = ["picture", "traced"].map(
                (id) => /** @type {HTMLCanvasElement} */ (document.getElementById(id)),
            );
            const { width, height } = picture;
            const canvas = new OffscreenCanvas(width, height);
            const context = canvas.getContext("2d");
            context.drawImage(picture, 0, 0);
            context.drawImage(traced, width / 2, 0, width / 2, height, width / 2, 0, width / 2, height);
            context.fillStyle = "#fff";
            context.fillRect(width / 2 - 1, 0, 2, height);
            return [
                ...new Uint8Array(
                    await (await canvas.convertToBlob({ type: "image/jpeg", quality: 0.6 })).arrayBuffer(),
                ),
            ];
        });
        await writeFile(path.join(out, "poster.jpg"), Buffer.from(bytes));
        figures.poster = await page.locator("#sentence").innerText();
        await context.close();
    });
