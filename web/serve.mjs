// Serves a folder on the loopback address: node serve.mjs FOLDER [PORT]. As a module: `serve(folder, port)` returns the
// server and its address.
import { createReadStream } from "node:fs";
import { stat } from "node:fs/promises";
import http from "node:http";
import path from "node:path";
import { fileURLToPath } from "node:url";

const TYPES = {
    ".html": "text/html; charset=utf-8", ".css": "text/css", ".js": "text/javascript", ".wasm": "application/wasm",
    ".json": "application/json", ".svg": "image/svg+xml", ".ts": "text/plain",
    ".jpg": "image/jpeg", ".md": "text/plain; charset=utf-8",
};

export async function serve(folder, port = 0) {
    const root = path.resolve(folder);
    const server = http.createServer(async (request, response) => {
        const fail = (code) => response.writeHead(code).end(http.STATUS_CODES[code]);
        try {
            const asked = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
            let file = path.join(root, asked);
            if (file !== root && !file.startsWith(root + path.sep)) return fail(403);
            if ((await stat(file)).isDirectory()) file = path.join(file, "index.html");
            await stat(file);
            // Without a cache, the browser shows the newest build.
            response.writeHead(200, { "content-type": TYPES[path.extname(file)] ?? "application/octet-stream", "cache-control": "no-cache" });
            createReadStream(file).on("error", () => response.destroy()).pipe(response);
        } catch {
            fail(404);
        }
    });
    await new Promise((done, failed) => server.once("error", failed).listen(port, "127.0.0.1", done));
    return { server, address: `http://127.0.0.1:${server.address().port}/` };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
    const { address } = await serve(process.argv[2] ?? ".", Number(process.argv[3] ?? 8080));
    console.log(`${address} (Ctrl+C ends it)`);
}
