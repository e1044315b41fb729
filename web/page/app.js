// The page: it connects the fields and buttons, and begins with what its address asks for. engine.js renders in a
// worker.
// @ts-check
import { plot, tabulate } from "./chart.js";
import { Engine } from "./client.js";
import { embedded, heed } from "./embed.js";
import { compared } from "./figures.js";
import { dropped } from "./files.js";
import { offer } from "./headset.js";
import { remember, share } from "./link.js";
import { FIRST_SCENE, openFiles, openLinked, openScene } from "./models.js";
import { draw, lookAhead, shownAround } from "./picture.js";
import { alone, ask, moved, resized, show, stop } from "./render.js";
import { VIEWS, around, label, seen, settings, view } from "./settings.js";
import { download, element, engine, notice, state } from "./state.js";
import { tiltable } from "./tilt.js";

const QUILT = { columns: 8, rows: 6, size: /** @type {const} */ ([420, 560]), interaxialPixels: 3 };
const ROUNDS = 3;

// --- Files ---

let over = 0;
addEventListener("dragenter", (event) => {
    event.preventDefault();
    over += 1;
    element("drop").hidden = false;
});
addEventListener("dragleave", () => {
    over = Math.max(0, over - 1);
    element("drop").hidden = over === 0;
});
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", async (event) => {
    event.preventDefault();
    over = 0;
    element("drop").hidden = true;
    if (event.dataTransfer) await openFiles(await dropped(event.dataTransfer));
});
element("files").addEventListener("change", async () => {
    const files = [...element("files").files].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
    element("files").value = "";
    if (files.length) await openFiles(files);
});

// --- Settings and buttons ---

element("panel").addEventListener("submit", (event) => event.preventDefault());
element("scene").addEventListener("change", () => void openScene({ builtin: element("scene").value }));
for (const id of ["e", "d"]) element(id).addEventListener("input", moved);
for (const id of ["samples", "lights"]) {
    element(id).addEventListener("input", label);
    element(id).addEventListener("change", () => ask("whole"));
}
element("projection").addEventListener("change", lookAhead);
for (const id of ["method", "size", "light", "projection"])
    element(id).addEventListener("change", () => {
        label();
        ask("whole");
    });
for (const id of ["view", "glasses"])
    element(id).addEventListener("change", () => {
        label();
        // In full screen, the size depends on the view.
        ask(resized() ? "whole" : "show");
    });
element("message").lastElementChild.addEventListener("click", () => notice(""));
element("stop").addEventListener("click", () => void stop());
element("share").addEventListener("click", () => void share());
element("full").addEventListener("click", async () => {
    await element("frame").requestFullscreen();
    // Its keys change the view, as the buttons are out of sight.
    element("picture").focus();
});

element("compare").addEventListener("click", () =>
    alone("comparing", async () => {
        compared(await engine().ask("compare"));
        element("view").value = "difference";
        label();
        remember();
        await show();
    }),
);
element("save").addEventListener("click", () =>
    alone("writing", async () => {
        const span = shownAround();
        // Players of equirectangular pictures know both views by such names.
        const [shown, name] =
            span === 360 ? ["top-bottom", "360_TB"] : span ? ["side-by-side", "180x180_3dh"] : [view(), view()];
        download(await engine().ask("png", { ...settings(), view: shown }), `${state.open.name}_${name}.png`);
    }),
);
element("save-eyes").addEventListener("click", () =>
    alone("writing", async () => {
        for (const eye of ["left", "right"])
            download(await engine().ask("png", { view: eye }), `${state.open.name}_${eye}.png`);
    }),
);
element("quilt").addEventListener("click", () =>
    alone("rendering a quilt", async (tell) => {
        const { columns, rows, size, interaxialPixels } = QUILT;
        if (around()) throw new Error("A quilt is planar: choose the planar projection.");
        const { interaxial: _, ...rest } = seen();
        const camera = { ...rest, size, interaxialPixels };
        const request = { camera, options: settings().options, columns, rows, name: state.open.name };
        const { blob, name } = await engine().ask("quilt", request, tell);
        download(blob, name);
    }),
);
element("measure").addEventListener("click", () =>
    alone("measuring", async (tell) => {
        const { samples } = settings().options;
        const found = await engine().ask("measure", { camera: seen(), options: { samples }, rounds: ROUNDS }, tell);
        element("chart").hidden = false;
        element("plot").replaceChildren(plot(found));
        tabulate(found, element("chart").querySelector("table"));
        element("json").value = JSON.stringify(found, null, 1);
        const { matches: still } = matchMedia("(prefers-reduced-motion: reduce)");
        element("chart").scrollIntoView({ behavior: still ? "auto" : "smooth" });
    }),
);
element("report").addEventListener("click", () =>
    alone("measuring this device", async (tell) => {
        const page = await engine().ask("report", {}, tell);
        download(new Blob([page], { type: "text/html" }), "stereotrace-report.html");
    }),
);
element("copy").addEventListener("click", async () => {
    try {
        await navigator.clipboard.writeText(element("json").value);
        element("copied").textContent = "copied";
    } catch {
        element("json").select();
        element("copied").textContent = "copying failed; copy the selected text below";
    }
});
let settling = 0;
// On phones full screen may have the window's size.
for (const event of ["resize", "fullscreenchange"]) {
    addEventListener(event, () => {
        clearTimeout(settling);
        settling = setTimeout(() => {
            // A phone's address bar changes the window's height, but rarely the picture's.
            if (resized()) ask("whole");
            else draw();
        }, 300);
    });
}

// --- Begin ---

/** Returns what is missing if nothing can be rendered. */
function missing() {
    if (!isSecureContext) {
        return (
            "This page needs WebGPU, which browsers offer only over https and on localhost. " +
            "Open the page at such an address."
        );
    }
    if (!("gpu" in navigator)) {
        return (
            "This browser has no WebGPU, which this page needs. Chrome and Edge have it from version 113, " +
            "Safari from 26, and Firefox from 141 on Windows. In Firefox on other systems you may have to enable it."
        );
    }
    return "";
}

/** @param {HTMLSelectElement} list @param {string[]} names @param {string} [usual] the first one, if it is not said */
const fill = (list, names, usual = names[0]) =>
    list.replaceChildren(...names.map((name) => new Option(name, name, name === usual, name === usual)));

async function begin() {
    element("view").replaceChildren(...Object.entries(VIEWS).map(([name, text]) => new Option(text, name)));
    element("full").hidden = !document.fullscreenEnabled;
    tiltable();
    void offer();
    embedded();
    const fault = missing();
    if (fault) return nothing(fault);
    state.engine = new Engine();
    const { adapter, builtins, methods, anaglyphs, version } = await engine().ask("begin");
    if (!adapter) {
        return nothing(
            "This browser has WebGPU, but found no graphics adapter for it. The driver may be too old or " +
                "blocked, or hardware acceleration may be disabled in the browser's settings.",
        );
    }
    state.adapter = adapter;
    fill(element("scene"), builtins, FIRST_SCENE);
    fill(element("method"), methods, "auto");
    fill(element("glasses"), anaglyphs);
    const { vendor, architecture, device, description, software, timestamps } = adapter;
    const name = [vendor, architecture, device, description].filter(Boolean).join(" ") || "an unnamed adapter";
    element("adapter").textContent =
        `stereotrace ${version} on ${name}.` +
        (software ? " It is a software adapter. Pictures take a second or more, but milliseconds on a GPU." : "") +
        (timestamps ? "" : " It has no timestamps, so times are of whole frames and include the browser's overhead.");
    await openLinked(new URLSearchParams(location.search));
}

/** Says why nothing can be rendered. The picture that was made before stays. @param {string} text */
function nothing(text) {
    state.fault = text;
    state.engine = null;
    notice(text, { lasts: true });
    element("sentence").textContent =
        "This picture was made before: the right half shows the right eye, and marks what was traced again.";
    for (const field of element("panel").elements) field.disabled = true;
    for (const id of ["view", "marked", "headset", "full", "share"]) element(id).disabled = true;
    document.documentElement.dataset.state = "nothing";
}

begin()
    .catch((error) => nothing(error.message))
    .finally(heed);
