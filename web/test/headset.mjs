// Tests pairs in a headset, which iwer emulates. Where places of the pair are seen follows from the emulated headset's
// figures alone.
import assert from "node:assert/strict";
import path from "node:path";
import { decoded, iwer, opened, out, test, whole } from "./tools.mjs";

/** The emulated views are side by side, each a square with a vertical field of view of 90 degrees. */
const [SIDE, TALL] = [320, 1];
/** Distance between the emulated eyes in metres. */
const EYES = 0.063;
const RADIANS = Math.PI / 180;

const worn = async (page) => {
    await page.addInitScript({ path: path.join(iwer, "build", "iwer.min.js") });
    await page.addInitScript(() => {
        globalThis.device = new globalThis.IWER.XRDevice(globalThis.IWER.metaQuest3, { stereoEnabled: true });
        globalThis.device.installRuntime({ forceInstall: true });
    });
};

/** Opens the hall in a page with a headset. Returns it with both views and the camera. */
async function begun(projection, size) {
    const query = `?scene=hall&size=${size.join("x")}&method=naive&projection=${projection ?? "planar"}`;
    const found = await opened(query, { viewport: { width: 2 * SIDE, height: SIDE }, prepare: worn });
    await whole(found.page);
    const { camera, views } = await found.page.evaluate(
        async ([projection, size]) => {
            const { Scene, render } = await import("./pkg/index.js");
            const scene = await Scene.builtin("hall");
            let camera = scene.camera(...size);
            const { eye, target, interaxial } = camera;
            if (projection) camera = { eye, target, interaxial, size, projection };
            const pair = await render(scene, camera, { method: "naive" });
            return { camera, views: ["left", "right"].map((eye) => [...pair.view(eye).data]) };
        },
        [projection, size],
    );
    return { ...found, camera, eyes: views.map((data) => ({ data, width: size[0], height: size[1] })) };
}

/** Looks at the pair with the head as it begins, and with one turned and moved to the right; then puts it down. */
async function pictures(page, name, degrees, metres) {
    const button = page.locator("#headset");
    await button.click();
    const found = [await seen(page, name, 0, 0), await seen(page, `${name}-turned`, degrees, metres)];
    assert.equal(await button.getAttribute("aria-pressed"), "true");
    // The picture covers the page.
    await page.evaluate(() => document.querySelector("#headset").click());
    await page.waitForFunction(() => document.querySelector("#headset[aria-pressed=false]"));
    return Promise.all(found.map((picture) => decoded(page, picture)));
}

/** Turns the head to the left by an angle in degrees, moves it to the right in metres, and returns what is seen. */
async function seen(page, name, degrees, metres) {
    await page.evaluate(
        ([half, metres]) => {
            const { device } = globalThis;
            device.quaternion.set(0, Math.sin(half), 0, Math.cos(half));
            device.position.x = metres;
        },
        [(degrees / 2) * RADIANS, metres],
    );
    await page.waitForTimeout(500);
    return page.screenshot({ path: path.join(out, `${name}.png`) });
}

/** Returns a pixel of the headset's picture in which an eye sees a direction (right, up, ahead). */
function pixel(eye, [right, up, ahead]) {
    const [x, y] = [right / ahead / TALL, up / ahead / TALL];
    assert.ok(Math.abs(x) < 1 && Math.abs(y) < 1 && ahead > 0, "the direction is out of sight");
    return [eye * SIDE + Math.floor((0.5 + x / 2) * SIDE), Math.floor((0.5 - y / 2) * SIDE)];
}

/** Turns a direction by an angle to the right. */
function turned([right, up, ahead], degrees) {
    const [sin, cos] = [Math.sin(degrees * RADIANS), Math.cos(degrees * RADIANS)];
    return [cos * right + sin * ahead, up, cos * ahead - sin * right];
}

/** Checks that each eye sees its own view: the mean difference between bytes of pixels is small. */
function compare(shown, eyes, placesOf, most) {
    for (const eye of [0, 1]) {
        const places = placesOf(eye);
        assert.ok(places.length > 300, `${places.length} places`);
        const [own, other] = [eyes[eye], eyes[1 - eye]].map(({ data, width }) => {
            const differences = places.flatMap(([[x, y], [u, v]]) =>
                [0, 1, 2].map((part) =>
                    Math.abs(shown[4 * (y * 2 * SIDE + x) + part] - data[4 * (v * width + u) + part]),
                ),
            );
            return differences.reduce((sum, difference) => sum + difference, 0) / differences.length;
        });
        assert.ok(own < most && other > 2.5 * own, `${own} from its own view, ${other} from the other`);
    }
}

/** Pixels of a picture, with their places in it from 0 to 1. */
function* grid({ width, height }, step) {
    for (let v = step; v < height - step; v += step)
        for (let u = step; u < width - step; u += step) yield [[u, v], (u + 0.5) / width, (v + 0.5) / height];
}

await test("a headset shows a planar pair as a window as far away as its screen", async () => {
    const { page, context, faults, camera, eyes } = await begun(null, [192, 144]);
    const distance = (camera.screenDistance * EYES) / camera.interaxial;
    const tall = 2 * distance * Math.tan((camera.fov / 2) * RADIANS);
    const ways = [
        [0, 0],
        [10, 0.2],
    ];
    for (const [index, shown] of (await pictures(page, "headset", ...ways[1])).entries()) {
        const [degrees, metres] = ways[index];
        const places = (eye) => {
            // The eyes turn with the head.
            const [right, , ahead] = turned([(eye - 0.5) * EYES, 0, 0], -degrees);
            return [...grid(eyes[eye], 6)].map(([from, x, y]) => {
                const point = [((x - 0.5) * tall * 4) / 3, (0.5 - y) * tall, distance];
                const direction = [point[0] - right - metres, point[1], point[2] - ahead];
                return [pixel(eye, turned(direction, degrees)), from];
            });
        };
        // Measured: 6.2 to 7.5, and at least 26 from the other view.
        compare(shown, eyes, places, 10);
        assert.deepEqual([...shown.slice(0, 3)], [0, 0, 0], "the window is all around");
    }
    assert.deepEqual(faults, []);
    await context.close();
});

await test("a headset turns in a pair all around", async () => {
    const { page, context, faults, eyes } = await begun(360, [256, 128]);
    for (const [index, shown] of (await pictures(page, "headset-around", 100, 0.5)).entries()) {
        const places = (eye) =>
            [...grid(eyes[eye], 3)].flatMap(([from, x, y]) => {
                const [longitude, latitude] = [2 * Math.PI * (x - 0.5), Math.PI * (0.5 - y)];
                const level = Math.cos(latitude);
                const ray = [level * Math.sin(longitude), Math.sin(latitude), level * Math.cos(longitude)];
                const [right, up, ahead] = turned(ray, index ? 100 : 0);
                const isSeen = ahead > 0 && Math.max(Math.abs(right), Math.abs(up)) < 0.95 * ahead;
                return isSeen ? [[pixel(eye, [right, up, ahead]), from]] : [];
            });
        // Measured: 1.4 to 2.7, and at least 31 from the other view.
        compare(shown, eyes, places, 4);
    }
    assert.deepEqual(faults, []);
    await context.close();
});
