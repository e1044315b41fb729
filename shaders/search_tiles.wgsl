// Pass 3 of 3 of `bracket`, first part: one query of the BVH for each tile of the target's pixels (docs/BRACKET.md). The tile's frustum is
// searched as deep as the source's samples that land there; each of its blocks of 2x2 pixels gets a list of the primitives that may
// cover a pixel's centre in it.
//
// launch  one thread per tile
// reads   bounds    [tiles]             bits of a depth
// writes  found     [tiles of the rows at work, TILE_BLOCKS, LIST_WORDS]
// adds    counters  [height * COUNTERS]
// appends lists     TO_RESOLVE, SKY: tiles of the rows at work

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> bounds: array<u32>;
@group(1) @binding(2) var<storage, read_write> found: array<u32>;
@group(1) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;
@group(1) @binding(4) var<storage, read_write> lists: Lists;

// Between two samples a surface may lie a little deeper than both.
const BETWEEN: f32 = 1.001;
// The search goes a little deeper than the bound: rounding.
const DEEPER: f32 = 1.0001;
// Leaves that are gathered before their primitives are looked at.
const LEAVES: u32 = 32u;
// Links to open stand from 0 on, leaves from here down.
const FIRST_LEAF: u32 = STACK_SIZE + LEAVES - 1u;

// A tile that asks for more boxes and primitives than this is given up and traced, which is cheaper then: so many triangles stand
// in it that lists overflow anyhow. It also keeps a thread's rounds far below those that a software adapter ends loops after.
const MOST_STEPS: u32 = 1024u;

// Boxes and primitives looked at.
var<private> steps: u32;
// Primitives listed so far.
var<private> listed: array<u32, TILE_BLOCKS>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn search_tiles(@builtin(global_invocation_id) id: vec3u) {
    let corner = pixel_in_tile(vec2u(id.x, launched_row(id))) * TILE + vec2u(0u, frame.row_begin);
    if outside(corner) { return; }
    let size = min(vec2u(TILE), vec2u(frame.image_size.x, frame.row_end) - corner);
    let tile = Tile(corner + vec2u(0u, frame.first_row), size);
    let bound = min(bitcast<f32>(bounds[corner.y / TILE * tiles_across() + corner.x / TILE]) * BETWEEN, FAR);
    let lists = tile_lists(corner);
    search(tile, lists, min(bound * DEEPER, FAR));
    var anything = bound < FAR;
    var block = 0u;
    let given_up = steps > MOST_STEPS;
    anything |= given_up;
    loop {
        // What does not fit its list is traced: without a bound.
        let list = lists + block * LIST_WORDS;
        let fits = listed[block] <= LIST_MOST && !given_up;
        anything |= listed[block] > 0u;
        found[list] = select(0u, listed[block], fits);
        found[list + 1u] = select(0u, bitcast<u32>(bound), fits);
        block += 1u;
        if block >= TILE_BLOCKS { break; }
    }
    let list = select(SKY, TO_RESOLVE, anything);
    let tile_index = (corner.y - frame.row_begin) / TILE * tiles_across() + corner.x / TILE;
    append(list, reserve_for(list, 1u, LIST_WORKGROUP * RAYS / TILE_PIXELS), tile_index);
    count_pixel(corner);
    count_view(corner.y, 0u, nodes_visited, primitives_tested);
}

fn search(tile: Tile, lists: u32, limit: f32) {
    let projection = projection_of(tile);
    let offsets = offsets_from(frame.target_eye);
    var links: array<u32, STACK_SIZE + LEAVES>;
    links[0] = DONE;
    var top = 0u;
    var link = 0u;
    loop {
        // Leaves are gathered first: a subgroup's threads then do the same most of the time.
        var gathered = 0u;
        loop {
            if COUNT { nodes_visited += 1u; }
            steps += 1u;
            let place = pair_place(link);
            let a = child_at(place, 0u, offsets);
            let b = child_at(place, 1u, offsets);
            let met_a = meets_frustum(a, projection, limit);
            let met_b = meets_frustum(b, projection, limit);
            // Written whether met or not: what stands past the ends does not count.
            let leaf_a = (a.link & LEAF) != 0u;
            links[select(top + 1u, FIRST_LEAF - gathered, leaf_a)] = a.link;
            top += select(0u, 1u, met_a & !leaf_a);
            gathered += select(0u, 1u, met_a & leaf_a);
            let leaf_b = (b.link & LEAF) != 0u;
            links[select(top + 1u, FIRST_LEAF - gathered, leaf_b)] = b.link;
            top += select(0u, 1u, met_b & !leaf_b);
            gathered += select(0u, 1u, met_b & leaf_b);
            link = links[top];
            top -= 1u;
            if link == DONE || gathered + 2u > LEAVES || steps > MOST_STEPS { break; }
        }
        var leaf = 0u;
        let first_leaf = links[FIRST_LEAF];
        var slot = first_leaf & FIRST_SLOT;
        var last = slot + ((first_leaf >> 28u) & 7u);
        loop {
            if leaf >= gathered { break; }
            list_primitive(slot, tile, lists, projection);
            steps += 1u;
            slot += 1u;
            if slot > last {
                leaf += 1u;
                let next = links[FIRST_LEAF - min(leaf, LEAVES - 1u)];
                slot = next & FIRST_SLOT;
                last = slot + ((next >> 28u) & 7u);
            }
        }
        if link == DONE || steps > MOST_STEPS { break; }
    }
}

fn list_primitive(slot: u32, tile: Tile, lists: u32, projection: Projection) {
    if COUNT { primitives_tested += 1u; }
    let primitive = primitive_at(slot);
    let covered = covered_pixels(primitive, projection, tile);
    let edges = edges_of(primitive);
    let first = covered.xy / 2;
    let last = covered.zw / 2;
    var x = first.x;
    var y = first.y;
    loop {
        if covered.y > covered.w || y > last.y { break; }
        if may_cover(edges, vec2f(tile.corner) + 2.0 * vec2f(vec2i(x, y)) + 1.0) {
            let block = u32(y) * BLOCKS + u32(x);
            let place = listed[block];
            listed[block] = place + 1u;
            let entry = slot | (pixels_of_block(covered, 2 * x, 2 * y) << FIRST_PIXEL_BIT);
            if place < LIST_MOST { found[lists + block * LIST_WORDS + LIST_HEADER + place] = entry; }
        }
        x += 1;
        if x > last.x { x = first.x; y += 1; }
    }
}

// Which of a block's pixels are covered, a bit each, row by row.
fn pixels_of_block(covered: vec4i, x: i32, y: i32) -> u32 {
    let columns = select(0u, 1u, covered.x <= x) | select(0u, 2u, covered.z > x);
    let rows = select(0u, 3u, covered.y <= y) | select(0u, 12u, covered.w > y);
    return (columns * 5u) & rows;
}
