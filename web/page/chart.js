// Draws the figures of all methods as a chart and a table.
// @ts-check

const [WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [760, 420, 70, 110, 16, 46];
/** Shares of wrong pixels below this percentage are drawn on the axis. */
const LEAST = 0.001;

/** @param {string} name @param {Record<string, string | number>} attributes @param {string} [text] */
function node(name, attributes, text) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
    if (text !== undefined) made.textContent = text;
    return made;
}

/**
 * Plots the time of a pair relative to naive against the percentage of wrong pixels, on a logarithmic axis.
 * @param {any} figures
 */
export function plot(figures) {
    const svg = node("svg", {
        viewBox: `0 0 ${WIDTH} ${HEIGHT}`,
        role: "img",
        "aria-label": "Share of wrong pixels against time",
    });
    const most = Math.max(1.2, ...figures.methods.map((row) => row.msOfNaive)) * 1.05;
    /** @param {number} share */
    const x = (share) => LEFT + ((WIDTH - LEFT - RIGHT) * share) / most;
    /** @param {number} percent */
    const y = (percent) =>
        HEIGHT -
        BOTTOM -
        ((HEIGHT - TOP - BOTTOM) * (Math.log10(Math.max(percent, LEAST)) - Math.log10(LEAST))) /
            (2 - Math.log10(LEAST));
    for (let power = Math.log10(LEAST); power <= 2; power += 1) {
        const at = y(10 ** power);
        svg.append(node("line", { x1: LEFT, x2: WIDTH - RIGHT, y1: at, y2: at }));
        const label = power === Math.log10(LEAST) ? "≤ 0.001%" : `${Number((10 ** power).toPrecision(1))}%`;
        svg.append(node("text", { x: LEFT - 8, y: at + 4, "text-anchor": "end", class: "axis" }, label));
    }
    for (let share = 0; share <= most; share += most > 3 ? 1 : 0.2) {
        svg.append(
            node(
                "text",
                { x: x(share), y: HEIGHT - BOTTOM + 18, "text-anchor": "middle", class: "axis" },
                share.toFixed(most > 3 ? 0 : 1),
            ),
        );
    }
    svg.append(
        node(
            "text",
            { x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - 8, "text-anchor": "middle", class: "axis" },
            "time of the pair relative to naive (vertical axis: share of right pixels that differ from naive)",
        ),
    );
    // Labels that would cover each other are moved down, with a line to their points.
    /** @type {number[][]} */
    const taken = [];
    for (const row of figures.methods) {
        const [px, py] = [x(row.msOfNaive), y(100 - row.identicalPercent)];
        let place = Math.max(TOP + 8, py + 4);
        const down = place < HEIGHT / 2 ? 14 : -14;
        while (taken.some(([tx, ty]) => Math.abs(tx - px) < 90 && Math.abs(ty - place) < 13)) place += down;
        taken.push([px, place]);
        if (Math.abs(place - py) > 8) svg.append(node("path", { d: `M${px} ${py}L${px + 10} ${place - 4}` }));
        svg.append(node("circle", { cx: px, cy: py, r: 4 }), node("text", { x: px + 12, y: place }, row.method));
    }
    return svg;
}

/** @param {any} figures @param {HTMLTableElement} table */
export function tabulate(figures, table) {
    /** @type {[string, (row: any) => string][]} */
    const columns = [
        ["method", (row) => row.method],
        ["ms", (row) => row.ms.toFixed(1)],
        ["relative to naive", (row) => row.msOfNaive.toFixed(3)],
        ["device ms", (row) => row.deviceMs?.toFixed(1) ?? "–"],
        ["2nd eye", (row) => row.secondEye?.toFixed(3) ?? "–"],
        ["traced", (row) => `${(100 * row.retracedShare).toFixed(1)}%`],
        ["wrong colour", (row) => `${(100 - row.identicalPercent).toFixed(3)}%`],
        ["wrong surface", (row) => `${row.wrongSurfacePercent.toFixed(3)}%`],
        ["PSNR", (row) => (row.psnr === null ? "∞" : `${row.psnr.toFixed(1)} dB`)],
    ];
    const line = (cells, kind) => {
        const tr = document.createElement("tr");
        tr.append(...cells.map((text) => Object.assign(document.createElement(kind), { textContent: text })));
        return tr;
    };
    table.tHead?.replaceChildren(
        line(
            columns.map(([name]) => name),
            "th",
        ),
    );
    table.tBodies[0].replaceChildren(
        ...figures.methods.map((row) =>
            line(
                columns.map(([, cell]) => cell(row)),
                "td",
            ),
        ),
    );
}
