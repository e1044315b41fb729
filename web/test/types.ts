// Code of a user of the package, for the compiler alone. The compiler must accept it, and refuse the marked lines.
import { init, Pair, Renderer, Scene, methods, render, type Camera, type Difference, type RenderOptions, type Statistics } from "../../target/page/pkg/index.js";

await init(new URL("https://example.org/stereotrace_web_bg.wasm"));
const scene: Scene = await Scene.fromFiles({ "a.obj": new Uint8Array(3) });
const camera: Camera = { ...scene.camera(640, 480), interaxialPixels: 12, interaxial: undefined };
const options: RenderOptions = { method: "bracket", samples: 4, onProgress: (done: number) => console.log(done) };
const pair: Pair = await render(scene, camera, options);
const own: Pair = await render(scene);
const statistics: Statistics = pair.statistics;
const difference: Difference = pair.difference(own);
const shown: [number, string, ImageData, ArrayLike<number>] =
    [difference.psnr + statistics.retracedShare, methods()[0], pair.anaglyph("grey"), pair.channel("left", "depth")];
const quilt: ImageData = (await new Renderer().views(scene, camera, 48)).quilt(8, 6);
scene.addMesh({ positions: new Float32Array(9), material: scene.addMaterial({ albedo: [1, 0, 0], finish: "mirror" }) });
console.log(shown, quilt);

// @ts-expect-error: two numbers are no position
const flat: Camera = { eye: [0, 1], target: [0, 0, 0] };
// @ts-expect-error: an unknown field
const odd: RenderOptions = { sample: 4 };
// @ts-expect-error: an unknown eye
pair.channel("middle", "depth");
// @ts-expect-error: arrays of numbers are no typed arrays
scene.addMesh({ positions: [0, 0, 0] });
console.log(flat, odd);
