import { Scene, render } from "stereotrace";

/** Renders a pair, and returns its size and the sums of both views. */
export async function picture() {
    const scene = await Scene.builtin("three-spheres");
    const pair = await render(scene, scene.camera(64, 48));
    const sum = (eye) => pair.view(eye).data.reduce((sum, byte) => sum + byte, 0);
    return [pair.width, pair.height, sum("left"), sum("right")].join(" ");
}
