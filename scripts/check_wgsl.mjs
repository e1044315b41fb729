// Shows every WGSL file of a folder to Tint, Chrome's front end, by Dawn's package for Node. No driver is needed.
//   node check_wgsl.mjs FOLDER PACKAGE
// FOLDER is what the test `every_distinct_module_is_written_to_target_wgsl` writes, PACKAGE the path of webgpu's
// index.js.
// A line `// FILE:LINE` above each definition says where it comes from, so that an error is told by that file and line.
import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const [folder, index] = process.argv.slice(2);
const { create } = await import(pathToFileURL(index).href);
// Held globally: Dawn crashes or hangs once this is collected as garbage, and an optimised function drops a variable
// after its last use.
globalThis.gpu = create(['backend=null']);
const adapter = await globalThis.gpu.requestAdapter();
if (!adapter) throw new Error('Dawn offers no null adapter');
const device = await adapter.requestDevice();

/** The file and line of a module's line, both counted from 1. */
function origin(name, lines, lineNum) {
    for (let above = lineNum - 2; above >= 0; above--) {
        const begin = /^\/\/ (\S+\.wgsl):(\d+)$/.exec(lines[above]);
        if (begin) return `shaders/${begin[1]}:${Number(begin[2]) + lineNum - 2 - above}`;
    }
    return `${name}:${lineNum}`;
}

// Most parts stand in many modules: each message is said once, with the number of modules that it stands in.
const found = new Map();
const names = readdirSync(folder).filter((name) => name.endsWith('.wgsl')).sort();
for (const name of names) {
    const text = readFileSync(join(folder, name), 'utf8');
    const lines = text.split('\n');
    // Else Dawn prints a rejected module whole.
    device.pushErrorScope('validation');
    const info = await device.createShaderModule({ code: text }).getCompilationInfo();
    const error = await device.popErrorScope();
    const messages = info.messages.filter((message) => message.type === 'error');
    const told = new Set(messages.map(({ lineNum, message }) => `${origin(name, lines, lineNum)}: ${message}`));
    if (error && told.size === 0) told.add(`${name}: ${error.message}`);
    for (const message of told) found.set(message, (found.get(message) ?? 0) + 1);
}
for (const [message, count] of found) console.error(`${message} (in ${count} of ${names.length} modules)`);
if (names.length === 0) console.error(`no *.wgsl in ${folder}`);
console.log(`Tint: ${names.length} modules, ${found.size} errors`);
// Leaving at once spares the orderly end, in which Dawn's null device has nothing to do.
process.exit(found.size > 0 || names.length === 0 ? 1 : 0);
