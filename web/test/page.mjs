// Tests the page in a headless Chromium on SwiftShader: node page.mjs SITE OUT PLAYWRIGHT CHROMIUM NATIVE SCENES AXE
// IWER [full]. With `full` a pair of 512x512 is timed too, and the poster is made. Pixels are compared with the output of
// NATIVE (`--example web_native`) on the same driver. Screenshots and figures are written to OUT.
import { finish } from "./tools.mjs";

// Static imports would run at the same time.
for (const part of ["pictures", "looks", "links", "headset", "files", "faults", "package"]) await import(`./${part}.mjs`);
await finish();
