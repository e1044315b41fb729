// Tests models that are opened: from files, archives and addresses.
import assert from "node:assert/strict";
import http from "node:http";
import { readFile } from "node:fs/promises";
import path from "node:path";
import zlib from "node:zlib";
import { choose, drop, figures, opened, pixels, scenes, test, whole } from "./tools.mjs";

/** Returns a .glb of one triangle with a camera. */
function triangle() {
    const positions = Buffer.from(new Float32Array([-1, -1, 0, 1, -1, 0, 0, 1, 0]).buffer);
    const text = JSON.stringify({
        asset: { version: "2.0" },
        buffers: [{ byteLength: positions.length }],
        bufferViews: [{ buffer: 0, byteLength: positions.length }],
        accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [-1, -1, 0], max: [1, 1, 0] }],
        meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
        cameras: [{ type: "perspective", perspective: { yfov: 0.8, znear: 0.1 } }],
        nodes: [{ mesh: 0 }, { camera: 0, translation: [0, 0, 4] }],
        scenes: [{ nodes: [0, 1] }],
        scene: 0,
    });
    const json = Buffer.from(text.padEnd(Math.ceil(text.length / 4) * 4));
    const chunk = (kind, bytes) => Buffer.concat([Buffer.from(new Uint32Array([bytes.length, kind]).buffer), bytes]);
    const chunks = Buffer.concat([chunk(0x4e4f534a, json), chunk(0x004e4942, positions)]);
    return Buffer.concat([Buffer.from(new Uint32Array([0x46546c67, 2, 12 + chunks.length]).buffer), chunks]);
}

await test("a .glb is shown by its own camera, and again after the engine stopped", async () => {
    const trap = async (page) => {
        await page.route("**/engine.js", async (route) => {
            const response = await route.fetch();
            const text = await response.text();
            const broken = text.replace(
                "async show(request) {",
                `async show(request) {
                    setTimeout(() => { throw new WebAssembly.RuntimeError("unreachable"); });
                    await new Promise(() => {});`,
            );
            assert.notEqual(text, broken);
            await route.fulfill({ response, body: broken });
        });
    };
    const { page, context } = await opened("?scene=three-spheres&size=96x72&view=left", { prepare: trap });
    await whole(page);
    const glb = { name: "triangle.glb", bytes: [...triangle()] };
    await drop(page, [glb]);
    await whole(page);
    assert.equal(await page.locator("#about").innerText(), "triangle, 1 triangle");
    const before = await pixels(page);
    const middle = 4 * (96 * 36 + 48);
    assert.notDeepEqual(
        before.data.slice(middle, middle + 3),
        before.data.slice(0, 3),
        "the triangle stands before the sky",
    );
    await page.selectOption("#view", "right");
    await page.waitForFunction(() => /engine stopped/.test(document.querySelector("#message p").textContent));
    await whole(page);
    await page.click("#message button");
    await drop(page, [glb]);
    await whole(page);
    assert.equal(await page.locator("#about").innerText(), "triangle, 1 triangle");
    assert.ok(await page.locator("#message").isHidden());
    await context.close();
});

await test("broken files are said on the page, and what was open stays", async () => {
    const { page, context, faults } = await opened("?scene=three-spheres&size=96x72");
    await whole(page);
    const before = JSON.stringify(await pixels(page));
    const message = async (files, expected) => {
        await drop(page, files);
        await page.waitForFunction(() => !document.querySelector("#message").hidden);
        assert.match(await page.locator("#message p").innerText(), expected);
        await page.click("#message button");
    };
    const file = (name, text) => ({ name, bytes: [...Buffer.from(text)] });
    await message([file("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")], /broken\.obj/);
    await message([file("broken.glb", "glTF\u0002 and nothing else")], /broken\.glb/);
    await message([file("empty.obj", "")], /empty|nothing/);
    await message([file("notes.txt", "no scene")], /notes\.txt: no \.obj/);
    await message([file("a.obj", ""), file("b.obj", "")], /one model at a time/);
    for (const method of ["naive", "auto"]) await choose(page, "method", method);
    assert.equal(JSON.stringify(await pixels(page)), before, "what was open stays");
    await drop(page, [file("lonely.obj", "mtllib lonely.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")]);
    await page.waitForFunction(
        () => !document.querySelector("#message").hidden || document.documentElement.dataset.state === "whole",
    );
    figures.lonely = [await page.locator("#message p").innerText(), await page.locator("#warnings").textContent()];
    assert.match(figures.lonely.join(" "), /lonely\.mtl/);
    assert.deepEqual(faults, []);
    await context.close();
});

await test("scenes that are asked for one upon the other: the last one is shown", async () => {
    const { page, context, faults } = await opened("?scene=three-spheres&size=96x72");
    await whole(page);
    const before = JSON.stringify(await pixels(page));
    for (const scene of ["random-20", "fence", "near", "three-spheres"]) {
        await page.selectOption("#scene", scene);
        await page.waitForTimeout(30);
    }
    await page.waitForFunction(() => document.querySelector("#about").textContent === "0 triangles, 4 other shapes");
    await page.evaluate(() => {
        document.documentElement.dataset.state = "";
    });
    await choose(page, "method", "naive");
    await choose(page, "method", "auto");
    assert.ok(JSON.stringify(await pixels(page)) === before, "another picture");
    assert.ok(await page.locator("#message").isHidden());
    assert.deepEqual(faults, []);
    await context.close();
});

/** Returns the notice about dropped files, which is then dismissed. */
async function refused(page, files) {
    await drop(page, files);
    await page.waitForFunction(() => !document.querySelector("#message").hidden);
    const text = await page.locator("#message p").innerText();
    await page.click("#message button");
    return text;
}

/** Drops files, and returns the words about the scene that they are. */
async function about(page, files) {
    await drop(page, files);
    await whole(page);
    assert.ok(await page.locator("#message").isHidden(), await page.locator("#message").innerText());
    return page.locator("#about").innerText();
}

/** Returns a .zip file, without checksums. An entry's size and flags may be lies. */
function zip(name, entries, { cut = 0 } = {}) {
    const [parts, list] = [[], []];
    let at = 0;
    for (const { name, data, stored = false, size = data.length, flags = 0 } of entries) {
        const packed = stored ? data : zlib.deflateRawSync(data);
        const path = Buffer.from(name);
        const common = Buffer.alloc(26);
        [20, flags, stored ? 0 : 8].forEach((value, index) => common.writeUInt16LE(value, 2 * index));
        [0, packed.length, size].forEach((value, index) => common.writeUInt32LE(value, 10 + 4 * index));
        common.writeUInt16LE(path.length, 22);
        const place = Buffer.alloc(14);
        place.writeUInt32LE(at, 10);
        list.push(Buffer.from("PK\u0001\u0002\u0014\0"), common, place, path);
        parts.push(Buffer.from("PK\u0003\u0004"), common, path, packed);
        at += 30 + path.length + packed.length;
    }
    const directory = Buffer.concat(list);
    const end = Buffer.alloc(18);
    [0, 0, entries.length, entries.length].forEach((value, index) => end.writeUInt16LE(value, 2 * index));
    [directory.length, at].forEach((value, index) => end.writeUInt32LE(value, 8 + 4 * index));
    const all = Buffer.concat([...parts, directory, Buffer.from("PK\u0005\u0006"), end]);
    return { name, bytes: [...all.subarray(0, all.length - cut)] };
}

/** Counts the bytes that the page decompresses. */
const counted = (page) =>
    page.addInitScript(() => {
        const { readable } = Object.getOwnPropertyDescriptors(DecompressionStream.prototype);
        globalThis.inflated = 0;
        Object.defineProperty(DecompressionStream.prototype, "readable", {
            get() {
                const transform = (chunk, controller) => {
                    globalThis.inflated += chunk.byteLength;
                    controller.enqueue(chunk);
                };
                return readable.get.call(this).pipeThrough(new TransformStream({ transform }));
            },
        });
    });

await test("an archive is opened, and bombs and damaged ones are refused", async () => {
    const query = "?scene=three-spheres&size=96x72&method=naive&view=left";
    const { page, context, faults } = await opened(query, { prepare: counted });
    await whole(page);
    const [obj, mtl] = await Promise.all(
        ["still_life.obj", "still_life.mtl"].map((name) => readFile(path.join(scenes, name))),
    );
    const plain = await about(
        page,
        ["still_life.obj", "still_life.mtl"].map((name) => path.join(scenes, name)),
    );
    const before = JSON.stringify(await pixels(page));
    const entries = [
        { name: "a/", data: Buffer.alloc(0), stored: true },
        { name: "a/still_life.obj", data: obj },
        { name: "a/still_life.mtl", data: mtl, stored: true },
        { name: "__MACOSX/a/._still_life.obj", data: Buffer.from("no scene") },
    ];
    assert.equal(await about(page, [zip("all.zip", entries)]), plain);
    assert.equal(JSON.stringify(await pixels(page)), before);
    const zeros = Buffer.alloc(64 << 20);
    assert.match(
        await refused(page, [zip("bomb.zip", [{ name: "a.obj", data: zeros, size: 1000 }])]),
        /bomb\.zip: a\.obj is damaged/,
    );
    const inflated = await page.evaluate(() => globalThis.inflated);
    assert.ok(inflated > 1000 && inflated < 4 << 20, `${inflated} bytes of the bomb were decompressed`);
    assert.match(
        await refused(page, [zip("large.zip", [{ name: "a.obj", data: obj, size: 0x7fffffff }])]),
        /large\.zip: its files have more than 1024 MiB/,
    );
    assert.match(
        await refused(page, [zip("secret.zip", [{ name: "a.obj", data: obj, flags: 1 }])]),
        /a\.obj is encrypted; unpack it/,
    );
    assert.match(
        await refused(page, [zip("cut.zip", entries, { cut: 30 })]),
        /cut\.zip: it is no \.zip file, or it is cut off/,
    );
    assert.match(
        await refused(page, [
            zip("two.zip", [
                { name: "a.obj", data: obj },
                { name: "b.obj", data: obj },
            ]),
        ]),
        /one model at a time/,
    );
    assert.match(await refused(page, [zip("none.zip", [{ name: "a.txt", data: obj }])]), /a\.txt: no \.obj/);
    assert.deepEqual(faults, []);
    await context.close();
});

await test("STL files are opened, binary and as text", async () => {
    const { page, context, faults } = await opened("?scene=three-spheres&size=96x72&method=naive&view=left");
    await whole(page);
    const corners = [
        [-1, 0, -1],
        [1, 0, -1],
        [0, 0, 1],
    ];
    const binary = Buffer.alloc(84 + 50);
    binary.writeUInt32LE(1, 80);
    corners.flat().forEach((value, index) => binary.writeFloatLE(value, 84 + 12 + 4 * index));
    const loop = corners.map((corner) => `vertex ${corner.join(" ")}\n`).join("");
    const text = `solid part\nfacet normal 0 -1 0\nouter loop\n${loop}endloop\nendfacet\nendsolid\n`;
    assert.equal(await about(page, [{ name: "part.stl", bytes: [...binary] }]), "part, 1 triangle");
    const first = await pixels(page);
    // The triangle stands upright: the sky is beside its upper corner, and the triangle beside its lower ones.
    const row = (y) =>
        [...Array(96).keys()].filter((x) => first.data[4 * (96 * y + x)] !== first.data[4 * 96 * y]).length;
    assert.ok(row(20) < row(50) && row(50) > 10, `${row(20)}, ${row(50)}`);
    assert.equal(await about(page, [{ name: "PART.STL", bytes: [...Buffer.from(text)] }]), "PART, 1 triangle");
    assert.deepEqual((await pixels(page)).data, first.data);
    const blank = "\n".repeat(200_000) + text;
    assert.equal(await about(page, [{ name: "blank.stl", bytes: [...Buffer.from(blank)] }]), "blank, 1 triangle");
    const cut = { name: "cut.stl", bytes: [...binary.subarray(0, 120)] };
    assert.match(await refused(page, [cut]), /cut\.stl: it is no STL file, it has no triangles, or it is cut off/);
    assert.deepEqual(faults, []);
    await context.close();
});

await test("a link opens a model from an address, and says why it can't", async () => {
    const glb = triangle();
    const large = Buffer.from(zip("large.zip", [{ name: "a.obj", data: Buffer.from("v"), size: 768 << 20 }]).bytes);
    const identifying = [];
    const server = http.createServer((request, response) => {
        const kind = request.url.slice(1).split("/")[0];
        const headers = kind === "closed" ? {} : { "access-control-allow-origin": "*" };
        identifying.push(request.headers.cookie, request.headers.referer);
        if (kind === "broken") return response.writeHead(200, headers).end("glTF\u0002 and nothing else");
        if (kind === "packed") return response.writeHead(200, headers).end(large);
        if (kind === "none") return response.writeHead(404, headers).end();
        if (kind === "large") headers["content-length"] = 300 << 20;
        if (kind !== "endless") return response.writeHead(200, headers).end(kind === "large" ? undefined : glb);
        // Without a length, only the bytes say how large it is.
        response.writeHead(200, headers);
        const more = () => {
            while (!response.destroyed && response.write(Buffer.alloc(1 << 20)));
        };
        response.on("drain", more);
        return more();
    });
    await new Promise((done) => server.listen(0, "127.0.0.1", done));
    const other = `http://127.0.0.1:${server.address().port}`;
    const { page, context, faults } = await opened(`?size=96x72&method=naive&view=left&model=${other}/open/100%.glb`, {
        prepare: (_, context) => context.addCookies([{ name: "a", value: "b", url: other }]),
    });
    await whole(page);
    assert.equal(await page.locator("#about").innerText(), "100%, 1 triangle");
    await page.waitForTimeout(600);
    assert.equal(new URL(page.url()).searchParams.get("model"), `${other}/open/100%.glb`);
    await context.close();
    const tries = [
        ["closed/triangle.glb", /does not let other pages read the file \(CORS\)/],
        ["none/triangle.glb", /the server answered 404/],
        ["large/triangle.glb", /more than 256 MiB/],
        ["endless/triangle.glb", /more than 256 MiB/],
        ["open/triangle.txt", /must end in \.obj/],
        ["broken/triangle.glb", /: triangle\.glb: /],
        ["packed/large.zip", /its files have more than 512 MiB in total/],
    ];
    for (const [file, expected] of [
        ...tries.map(([file, expected]) => [`${other}/${file}`, expected]),
        ["file:///etc/a.glb", /no http or https address/],
    ]) {
        const { page, context } = await opened(`?size=96x72&method=naive&model=${file}`);
        await page.waitForFunction(() => !document.querySelector("#message").hidden);
        const text = await page.locator("#message p").innerText();
        assert.ok(text.startsWith(`model=${file}: `), text);
        assert.match(text, expected);
        await whole(page);
        assert.equal(await page.locator("#scene").inputValue(), "hall", "another scene is shown instead");
        await page.waitForTimeout(600);
        assert.equal(new URL(page.url()).searchParams.get("model"), file, "a reload tries again");
        await context.close();
    }
    assert.deepEqual([...new Set(identifying)], [undefined], "nothing identifies the reader");
    assert.deepEqual(faults, []);
    server.closeAllConnections();
    server.close();
});

await test("a model that comes late replaces nothing, and Stop gives it up", async () => {
    const answers = [];
    const server = http.createServer((_, response) => answers.push(response));
    await new Promise((done) => server.listen(0, "127.0.0.1", done));
    const model = `http://127.0.0.1:${server.address().port}/a.glb`;
    const { page, context, faults } = await opened(`?size=96x72&method=naive&view=left&model=${model}`);
    const fetching = () => page.waitForFunction(() => /fetching/.test(document.querySelector("#busy").textContent));
    await fetching();
    await page.selectOption("#scene", "three-spheres");
    await whole(page);
    for (const answer of answers) answer.writeHead(200, { "access-control-allow-origin": "*" }).end(triangle());
    await page.waitForTimeout(600);
    assert.equal(await page.locator("#about").innerText(), "0 triangles, 4 other shapes");
    assert.ok(await page.locator("#message").isHidden());
    await page.goto(`${new URL(page.url()).origin}/?size=96x72&method=naive&view=left&model=${model}`);
    await fetching();
    await page.click("#stop");
    await page.waitForFunction(() => /Opening was stopped/.test(document.querySelector("#message p").textContent));
    assert.ok(await page.locator("#busy").isHidden());
    await page.selectOption("#scene", "three-spheres");
    await whole(page);
    assert.deepEqual(faults, []);
    await context.close();
    server.closeAllConnections();
    server.close();
});
