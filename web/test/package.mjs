// Tests the npm package.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { figures, full, natively, opened, out, site, test } from "./tools.mjs";

await test("the package's example", async () => {
    const { page, context, faults } = await opened("example/");
    await page.waitForFunction(() => document.querySelector("#figures").textContent);
    assert.match(await page.locator("#figures").innerText(), /% of the right eye's pixels/);
    await page.screenshot({ path: path.join(out, "example.png") });
    assert.deepEqual(faults, []);
    await context.close();
});

await test("wrong values are refused by name", async () => {
    const { page, context } = await opened("example/");
    const messages = await page.evaluate(async () => {
        const { Scene, render } = await import("../pkg/index.js");
        const scene = await Scene.builtin("three-spheres");
        const camera = scene.camera(64, 48);
        const tries = [
            () => render(scene, { ...camera, eye: [0, 0] }),
            () => render(scene, { ...camera, fof: 3 }),
            () => render(scene, { ...camera, fov: 200 }),
            () => render(scene, camera, { ambientOcclusion: { rays: 4, radius: 1, reach: 2 } }),
            () => new Scene().setLights([{ position: [0, 1, 0], intensity: [1, 1, 1], raduis: 1 }]),
            () => render(scene, camera, { method: "magic" }),
            () => render(scene, camera, { samples: 10 }),
            () => render(scene, camera, { signal: 3 }),
            () => render(scene, camera, { signal: AbortSignal.abort() }),
            () => render(scene, camera, { signal: AbortSignal.abort(new RangeError("enough")) }),
            () => Scene.fromFiles({ "a.obj": "text" }),
            () => new Scene().addMesh({ positions: [0, 0, 0] }),
            () =>
                new Scene().addMesh({
                    positions: new Float32Array(9),
                    indices: new Uint32Array([0, 1, 3]),
                    uvs: new Float32Array(6),
                }),
            () => render(new Scene()),
            () => new Scene().addMesh({ positions: new Float32Array(9), indices: [0, 1, 2] }),
            async () => {
                const freed = await Scene.builtin("three-spheres");
                freed.free();
                freed.free();
                return freed.info;
            },
            () => {
                const freed = new Scene();
                freed.free();
                return render(freed, camera);
            },
        ];
        const found = [];
        for (const attempt of tries) {
            try {
                await attempt();
                found.push("nothing was thrown");
            } catch (error) {
                found.push(`${error.name}: ${error.message}`);
            }
        }
        // Simultaneous requests are rendered one after the other.
        const both = await Promise.all([render(scene, camera), render(scene, camera, { method: "naive" })]);
        return [...found, both.map((pair) => pair.width).join()];
    });
    const names = await page.evaluate(async () => {
        const { init, options } = await import("../pkg/index.js");
        await init();
        return options();
    });
    const types = await readFile(path.join(site, "pkg", "stereotrace_web.d.ts"), "utf8");
    const [, fields] = types.match(/interface RenderOptions \{(.*?)\n\}/s);
    const typed = [...fields.matchAll(/^    (\w+)\?:/gm)].map(([, name]) => name);
    assert.deepEqual(typed.sort(), [...names, "signal", "onProgress"].sort());
    figures.refused = messages;
    const expected = [
        /camera\.eye/,
        /fof/,
        /200/,
        /ambientOcclusion: unknown field 'reach'/,
        /lights\[0\]: unknown field 'raduis'/,
        /magic/,
        /10 per pixel/,
        /signal/,
        /^AbortError/,
        /^RangeError: enough$/,
        /a\.obj.*Uint8Array/,
        /positions.*Float32Array/,
        /3 vertices/,
        /nothing to look at/,
        /^TypeError: mesh\.indices: .* Uint32Array or a Uint16Array/,
        /^TypeError: This Scene was freed/,
        /^TypeError: This Scene was freed/,
        /^64,64$/,
    ];
    messages.forEach((message, index) => assert.match(message, expected[index]));
    await context.close();
});

await test("indices of 16 bits and files of ArrayBuffers are those of 32 bits and of bytes", async () => {
    const { page, context } = await opened("example/");
    const found = await page.evaluate(async () => {
        const { Scene, init, render } = await import("../pkg/index.js");
        await init();
        const text = new TextEncoder().encode("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n");
        const positions = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0]);
        const indices = [0, 1, 2, 1, 3, 2];
        const scenes = [
            ...[Uint32Array, Uint16Array].map((Kind) => {
                const scene = new Scene();
                scene.addMesh({ positions, indices: new Kind(indices) });
                return scene;
            }),
            await Scene.fromFiles({ "a.obj": text }),
            await Scene.fromFiles({ "a.obj": text.buffer }),
        ];
        const camera = { eye: [0.5, 0.5, 3], target: [0.5, 0.5, 0], size: [64, 48] };
        const depths = [];
        for (const scene of scenes) depths.push((await render(scene, camera)).channel("left", "depth").join());
        return { same: depths.map((depth) => depth === depths[0]), near: depths[0].includes("3") };
    });
    assert.deepEqual(found, { same: [true, true, true, true], near: true });
    await context.close();
});

await test("the package is loaded by its first promise, or by init", async () => {
    const { page, context } = await opened("pkg/README.md");
    const found = await page.evaluate(async () => {
        const said = async (call) => {
            try {
                return String(await call());
            } catch (error) {
                return String(error);
            }
        };
        const all = await import("/pkg/index.js");
        const early = [
            await said(() => new all.Scene()),
            await said(() => new all.Renderer()),
            await said(() => all.methods()),
            await said(() => all.init("/index.html")),
            await said(() => all.init("/nowhere.wasm")),
        ];
        const bytes = await (await fetch("/pkg/stereotrace_web_bg.wasm")).arrayBuffer();
        await Promise.all([all.init(bytes), all.init()]);
        const loads = performance.getEntriesByType("resource").filter(({ name }) => name.endsWith("_bg.wasm")).length;
        return { early, loads, scene: new all.Scene() instanceof all.Scene, methods: all.methods().length > 3 };
    });
    const [scene, renderer, methods, page404, none] = found.early;
    for (const message of [scene, renderer, methods]) assert.match(message, /is not loaded; await init\(\) first/);
    for (const message of [page404, none]) assert.match(message, /could not be loaded; pass its address or its bytes/);
    assert.deepEqual([found.loads, found.scene, found.methods], [1, true, true]);
    await context.close();
});

await test("Node is told to use a browser", () => {
    const module = JSON.stringify(pathToFileURL(path.join(site, "pkg", "index.js")));
    const code = `import(${module}).then(({ Scene }) => Scene.builtin("hall"))`;
    const { status, stderr } = spawnSync(process.execPath, ["--eval", code], { encoding: "utf8" });
    assert.notEqual(status, 0);
    assert.match(stderr, /stereotrace needs WebGPU, and Node has none/);
});

if (full)
    await test("the time of a pair of 512x512", async () => {
        const timed = await opened("example/");
        const here = await timed.page.evaluate(async () => {
            const { Scene, Renderer } = await import("../pkg/index.js");
            const [scene, renderer] = [await Scene.builtin("hall"), new Renderer()];
            const camera = scene.camera(512, 512);
            const times = { naive: [], bracket: [] };
            for (let round = 0; round < 4; round += 1) {
                for (const method of Object.keys(times)) {
                    const begin = performance.now();
                    const pair = await renderer.render(scene, camera, { method });
                    // The first round compiles kernels.
                    if (round) times[method].push(performance.now() - begin);
                    pair.free();
                }
            }
            return {
                camera,
                ms: Object.fromEntries(
                    Object.entries(times).map(([name, all]) => [name, all.sort((a, b) => a - b)[1]]),
                ),
            };
        });
        const folder = path.join(out, "native", "hall-512");
        const there = await natively(folder, {
            scene: { builtin: "hall" },
            camera: here.camera,
            methods: ["naive", "bracket"],
            rounds: 3,
        });
        figures.pair512 = { browser: here.ms, native: there.ms };
        await timed.context.close();
    });
