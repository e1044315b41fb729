// Bounds the depth of each tile of a view by the samples of an earlier frame (docs/BRACKET.md, "Earlier frames"). Four
// neighbouring samples span a quad. The deepest of the four bounds all tiles that the quad covers in the view. A quad
// that is turned over lies behind another surface, and bounds nothing.
//
// launch  one thread per run of quads of a row
// reads   history         [height + 1, width]     samples; its last row holds the eye of the earlier frame
// updates history_bounds  [tiles, BOUND_WORDS]    bits of the largest depth; cleared by the host

//! use history, pixels, tiles

var<storage, read_write> history_bounds: array<atomic<u32>>;

// Distance between the samples of a quad, in pixels.
const QUAD: u32 = 2u;
// Number of quads per thread.
const QUAD_RUN: u32 = 4u;
// Maximum number of tiles that a quad bounds. Pixels of other tiles in a wide gap are traced.
const MOST_TILES: u32 = 64u;
// Around a quad, the distance in pixels at which it still counts.
const AROUND: f32 = 0.5;

// Tiles, and the bound that they get.
struct Bounded {
    first: vec2u,
    last: vec2u,
    depth: f32,
}

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn bound_by_history(@builtin(global_invocation_id) id: vec3u) {
    let size = history_size();
    let upper = launched_row(id) * QUAD;
    if upper >= size.y { return; }
    let lower = min(upper + QUAD, size.y - 1u);
    let eye = earlier_eye();
    let begin = id.x * QUAD_RUN * QUAD;
    if begin >= size.x { return; }
    var bounded: Bounded;
    var a = landed_of(eye, vec2u(begin, upper));
    var b = landed_of(eye, vec2u(begin, lower));
    var quad = 0u;
    loop {
        let column = min(begin + (quad + 1u) * QUAD, size.x - 1u);
        let c = landed_of(eye, vec2u(column, upper));
        let d = landed_of(eye, vec2u(column, lower));
        let next = tiles_of(a, b, c, d, size);
        if any(next.first != bounded.first) || any(next.last != bounded.last) {
            raise(bounded);
            bounded = next;
        }
        bounded.depth = max(bounded.depth, next.depth);
        a = c;
        b = d;
        quad += 1u;
        if quad >= QUAD_RUN { break; }
    }
    raise(bounded);
}

// Returns the tiles that a quad covers, with a depth of 0 if it bounds none. Its corners are a and c above, b and d
// below.
fn tiles_of(a: Landed, b: Landed, c: Landed, d: Landed, size: vec2u) -> Bounded {
    var none: Bounded;
    if min(min(a.depth, b.depth), min(c.depth, d.depth)) <= 0.0 { return none; }
    let low = min(min(a.place, b.place), min(c.place, d.place)) - AROUND;
    let high = max(max(a.place, b.place), max(c.place, d.place)) + AROUND;
    let across = d.place - a.place;
    let back = c.place - b.place;
    // Rows count downwards, so this product is negative for a quad that is not turned over.
    if across.x * back.y - across.y * back.x > 0.0 { return none; }
    let limit = vec2f(size);
    if !(all(high > vec2f(0.0)) && all(low < limit)) { return none; }
    let first = vec2u(max(low, vec2f(0.0))) / TILE;
    let last = vec2u(min(high, limit - 0.5)) / TILE;
    let count = (last - first) + 1u;
    if count.x * count.y > MOST_TILES { return none; }
    return Bounded(first, last, max(max(a.depth, b.depth), max(c.depth, d.depth)));
}

fn raise(bounded: Bounded) {
    if bounded.depth <= 0.0 { return; }
    var at = bounded.first;
    loop {
        atomicMax(&history_bounds[BOUND_WORDS * (at.y * tiles_across() + at.x)], bitcast<u32>(bounded.depth));
        at.x += 1u;
        if at.x > bounded.last.x {
            at = vec2u(bounded.first.x, at.y + 1u);
            if at.y > bounded.last.y { break; }
        }
    }
}
