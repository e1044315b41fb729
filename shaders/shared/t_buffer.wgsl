// A T-buffer (Raghuvanshi & Dhande, section II) holds for each pixel the t and the primitive of its ray's nearest hit.
// It is filled by drawing each primitive over the pixels that its projection may reach: their rays are tested against
// the primitive. Rays and tests are the same as in traversal, so every t is bit-identical. A ray that misses the
// primitive leaves its pixel unchanged. docs/T-BUFFER.md has the argument.
//
// A pixel has two words: the complement of t's bits, and the primitive's slot + 1, or 0 for a miss. Since t is not
// negative, its bits are ordered like t. Their complements have the reverse order, so the largest complement belongs to
// the nearest hit.
//
// The canvas is a picture or a light's shadow-buffer (shadow_canvas.wgsl).

//! use around, camera, counters, cutouts, ellipsoid, fetch, frame, lane, pixels, primitive, primitives, projection
//! use rays, tiles

// Lists of the primitives that may cover a pixel's centre, and the number of the pass.
struct Drawing {
    few: DrawnHead,                 // primitives that cover few pixels
    more: DrawnHead,                // primitives that cover a few tiles
    parts: DrawnHead,               // parts of primitives that cover many tiles
    further_parts: atomic<u32>,     // number of parts in addition to the first part of each primitive
    pass_at_work: u32,              // 1: stores the nearest t; SECOND_PASS: stores its primitive
    entries: array<u32>,
}

struct DrawnHead {
    workgroups: vec3u,              // arguments of an indirect dispatch
    count: atomic<u32>,
}

const SECOND_PASS: u32 = 2u;

// The entries have room for three words per primitive and for FURTHER_PARTS additional parts. A primitive is in one
// list only. The list `few` grows from the first word. The list `more` grows backwards from the word before
// primitives_in_tree(). The list `parts` grows backwards from the end. A part has two words. The first one is the slot.
// The second one holds the part's index, and the number of parts from bit PARTS_BIT upwards.
const FURTHER_PARTS: u32 = 65536u;
const PARTS_BIT: u32 = 16u;
// Number of threads that share a part. On a software adapter they form one vector, which reads a single primitive.
const GROUP: u32 = 8u;
// Number of entries of `few` per thread. A software adapter always runs the second test, but only once for all these
// entries.
const FEW_EACH: u32 = 4u;
// Number of workgroups per row of the dispatches over primitives and over each list.
const PROJECTED_ACROSS: u32 = 1024u;
const FEW_ACROSS: u32 = 32u;
const MORE_ACROSS: u32 = 64u;
const PARTS_ACROSS: u32 = 64u;
// Number of list entries per row of workgroups.
const FEW_IN_ROW: u32 = FEW_ACROSS * LIST_WORKGROUP * FEW_EACH;
const MORE_IN_ROW: u32 = MORE_ACROSS * LIST_WORKGROUP;
const PARTS_IN_ROW: u32 = PARTS_ACROSS * LIST_WORKGROUP / GROUP;

//! if planes is none
const FIRST_IN_TREE: u32 = 0u;

//! if planes is some
// Planes have the first slots. The kernel that reads the buffer tests them.
const FIRST_IN_TREE: u32 = PLANES;

//! end
// Returns the number of primitives in the tree, derived from the size that the host gave the buffer.
fn primitives_in_tree() -> u32 {
    return (arrayLength(&drawing.entries) - 2u * FURTHER_PARTS) / 3u;
}

fn place_of_more(entry: u32) -> u32 {
    return primitives_in_tree() - 1u - entry;
}

// Returns the index of the first of a part's two words.
fn place_of_part(part: u32) -> u32 {
    return arrayLength(&drawing.entries) - 2u - 2u * part;
}

//! if canvas is picture
// Returns the row whose counters receive work that belongs to no particular row. Up to two rows of the previous band
// precede the band's own rows. The result is one of the band's own rows.
fn counted_row() -> u32 {
    return min(frame.band.row_begin + 2u, frame.band.row_end - 1u);
}

// Bounds on where a primitive may be visible.

//! if primitives is triangles
fn most_along(primitive: Primitive, v: vec3f) -> f32 { return triangle_most(primitive, v); }

//! if primitives is spheres
fn most_along(primitive: Primitive, v: vec3f) -> f32 { return ball_most(primitive, v); }

//! if primitives is mixed
fn most_along(primitive: Primitive, v: vec3f) -> f32 {
    return select(triangle_most(primitive, v), ball_most(primitive, v), is_sphere(primitive));
}

//! if texels is corners or spheres
fn ball_radius(primitive: Primitive) -> f32 { return primitive.b.x; }

fn ball_reach(primitive: Primitive, v: vec3f) -> f32 { return primitive.b.x * length(v); }

//! if texels is ellipsoids
// Returns the longest semi-axis.
fn ball_radius(primitive: Primitive) -> f32 { return primitive.reach; }

fn ball_reach(primitive: Primitive, v: vec3f) -> f32 { return length(half_widths(primitive, v)); }

//! end
// Upper bound of the rounding error of a dot product, relative to one vector's length times the sum of the other's
// absolute components.
const PRODUCT_SLACK: f32 = 1.0 / 1048576.0;

// Returns an upper bound of the dot product of v with the offset from the eye to any point of a triangle.
fn triangle_most(primitive: Primitive, v: vec3f) -> f32 {
    let a = primitive.a - eye_point();
    let b = primitive.b - eye_point();
    let c = primitive.c - eye_point();
    let farthest = sqrt(dot(a, a)) + primitive.reach;
    return max(dot(a, v), max(dot(b, v), dot(c, v))) + farthest * components(v) * PRODUCT_SLACK;
}

// Returns the upper bound of triangle_most for a sphere or an ellipsoid.
fn ball_most(primitive: Primitive, v: vec3f) -> f32 {
    let center = primitive.a - eye_point();
    let farthest = length(center) + ball_radius(primitive);
    return dot(center, v) + ball_reach(primitive, v) + farthest * components(v) * PRODUCT_SLACK;
}

//! if canvas is picture
// The projection of a picture's pixels.
alias Canvas = Projection;

fn canvas_at_work() -> Canvas { return projection_of(rows_at_work()); }

fn rows_at_work() -> Tile {
    let size = vec2u(frame.band.size.x, frame.band.row_end - frame.band.row_begin);
    return Tile(vec2u(0u, frame.band.first_row + frame.band.row_begin), size);
}

// Returns whether a primitive lies outside the frustum of the current rows. This test also culls primitives that reach
// the plane of the eye. They have no projected bounds, but many of them lie beside the picture or behind the eye.
fn is_out_of_sight(primitive: Primitive, projection: Canvas) -> bool {
    let across = min(most_along(primitive, projection.left_plane), most_along(primitive, projection.right_plane));
    let down = min(most_along(primitive, projection.top_plane), most_along(primitive, projection.bottom_plane));
    return min(min(across, down), most_along(primitive, projection.forward)) < 0.0;
}

// Returns the range of pixels, within the current rows, that a primitive's projection may reach: first column, first
// row, last column, last row. If a first value exceeds its last one, the range is empty.
fn drawn_over(primitive: Primitive, projection: Canvas) -> vec4i {
    let bounds = projected_bounds(primitive, projection);
    let margin = guard_band();
    let rows = rows_at_work();
    let low = vec2f(rows.corner);
    let high = low + vec2f(rows.size) - 1.0;
    let first = ceil(clamp(bounds.xy - margin - 0.5, low, high + 1.0));
    let last = floor(clamp(bounds.zw + margin - 0.5, low - 1.0, high));
    return vec4i(vec2i(first), vec2i(last));
}

// These functions return a lane's pixels on the canvas and the rays of these pixels.
fn on_canvas(pixels: Pixels) -> Pixels { return pixels; }

fn rays_from(pixels: Pixels) -> Rays {
    return rays_of(pixels);
}

//! end
fn is_drawn_nowhere(over: vec4i) -> bool { return any(over.xy > over.zw); }

// Returns the number of tiles that cover these pixels, counted from the first pixel.
fn tiles_over(over: vec4i) -> u32 {
    let tiles = (vec2u(over.zw + 1 - over.xy) + TILE - 1u) / TILE;
    return tiles.x * tiles.y;
}

// Returns the pixels of a lane that begins at a given pixel of the picture, in buffer coordinates.
fn pixels_from(corner: vec2u) -> Pixels {
    return Pixels(RAY_X + U(corner.x), RAY_Y + U(corner.y - frame.band.first_row));
}

// Masks of deferred rays, one bit per ray.
struct Later {
    doubtful: u32,    // uncertain hit
    contested: u32,   // another primitive has the same t
}

fn is_none(later: Later) -> bool { return (later.doubtful | later.contested) == 0u; }

// Whether this is the second pass.
var<private> names_primitives: bool;

// Returns which pixels lie at or before a last column and row.
fn before_end(pixels: Pixels, last: vec2i) -> B {
    let end = vec2u(max(last, vec2i(0)));
    return (pixels.x <= U(end.x)) & (pixels.y + frame.band.first_row <= U(end.y));
}

//! if canvas is picture or middles
// Tests the rays of a lane's pixels, up to a last column and row, against a primitive, and stores their hits.
fn draw(primitive: Primitive, slot: u32, pixels: Pixels, last: vec2i) -> Later {
    let inside = before_end(pixels, last);
    let places = on_canvas(pixels);
    let rays = rays_from(places);
    let found = intersect(primitive, rays, scales_of(rays), F(0.0));
    if COUNT && any_ray(inside) { count_test(pixel_of_ray(places, 0u)); }
    var later = Later(bits_of(found.doubtful & inside), 0u);
    // This is the condition of is_nearer for a ray that has no hit yet.
    var left = found.hit & inside & (found.t >= F(0.0)) & (found.t <= F(FAR));
    loop {
        let ray = first_ray(left);
        if of_ray_b(left, ray) {
            let is_kept = keep_drawn(2u * pixel_index(pixel_of_ray(places, ray)), of_ray(found.t, ray), slot);
            later.contested |= select(1u << ray, 0u, is_kept);
        }
        left = without_ray(left, ray);
        if !any_ray(left) { break; }
    }
    return later;
}

//! if canvas is picture
// Counts a primitive test. Only counting kernels call this function; they have one ray per lane.
fn count_test(pixel: vec2u) {
    atomicAdd(&counters[pixel.y * COUNTERS + PRIMITIVES_TESTED], 1u);
    if COST_MAP { atomicAdd(&counters[frame.band.size.y * COUNTERS + pixel_index(pixel)], 1u); }
}

//! if canvas is picture or middles
// Stores a ray's hit. The maximum is commutative, so the order of threads does not matter in the first pass. It does
// not matter in the second pass either, if only one primitive has the nearest t. Returns false if another primitive is
// stored: then the caller must call `claim`.
fn keep_drawn(place: u32, t: f32, slot: u32) -> bool {
    let key = ~bitcast<u32>(abs(t)); // -0 is 0
    if !names_primitives {
        atomicMax(&t_buffer[place], key);
        return true;
    }
    if atomicLoad(&t_buffer[place]) != key { return true; }
    return atomicCompareExchangeWeak(&t_buffer[place + 1u], 0u, slot + 1u).exchanged;
}

// Assigns a pixel to the primitive with the smallest id among those at its t, and to the first slot among copies. A
// failed round means that another primitive with a smaller id was stored meanwhile.
fn claim(place: u32, slot: u32, id: u32) {
    var done = false;
    loop {
        let there = atomicLoad(&t_buffer[place + 1u]);
        let other = max(there, 1u) - 1u;
        let other_id = primitive_texel(other, 0u).w;
        let is_first = there == 0u || id < other_id || (id == other_id && slot < other);
        if !is_first {
            done = true;
            break;
        }
        if atomicCompareExchangeWeak(&t_buffer[place + 1u], there, slot + 1u).exchanged {
            done = true;
            break;
        }
    }
    cut_short |= !done;
}

// Runs the second test of deferred rays, one ray per round.
fn draw_again(primitive: Primitive, slot: u32, pixels: Pixels, later: Later) {
    let places = on_canvas(pixels);
    let rays = rays_from(places);
    var left = later.doubtful | later.contested;
    loop {
        let ray = min(firstTrailingBit(left), RAYS - 1u);
        let place = 2u * pixel_index(pixel_of_ray(places, ray));
        let direction = of_ray3(rays.direction, ray);
        let seen = look_again(primitive, rays.origin, direction, 0.0);
        let t = at_second_look(primitive, slot, rays.origin, direction, seen);
        var contested = ((later.contested >> ray) & 1u) != 0u;
        if left != 0u && !contested && t >= 0.0 && t <= FAR { contested = !keep_drawn(place, t, slot); }
        if left != 0u && contested { claim(place, slot, primitive.id); }
        left &= select(left - 1u, 0u, left == 0u);
        if left == 0u { break; }
    }
    cut_short |= left != 0u;
}

//! end
// Number of rounds that a lane needs for a block of 2x2 pixels.
const TURNS: u32 = 4u / RAYS;

// Draws a primitive over some of the tiles that it may cover, counted row by row. It draws every `apart`-th tile from
// `begin` on, before `end`. For a triangle, only the blocks that may lie within its edges are drawn.
fn draw_tiles(primitive: Primitive, slot: u32, over: vec4i, begin: u32, end: u32, apart: u32) {
    let corner = vec2u(over.xy);
    let size = vec2u(over.zw + 1) - corner;
    let across = (size.x + TILE - 1u) / TILE;
    var tile = begin;
    var first = vec2u(0u);
    var blocks = 0u;
    var turn = 0u;
    loop {
        var pixels: Pixels;
        var later: Later;
        loop {
            // Finds the next tile with something to draw.
            loop {
                if blocks != 0u || tile >= end { break; }
                first = corner + vec2u(tile % across, tile / across) * TILE;
                blocks = blocks_to_draw(primitive, Tile(first, min(vec2u(TILE), corner + size - first)));
                tile += apart;
            }
            if blocks == 0u { break; }
            loop {
                let block = firstTrailingBit(blocks);
                let place = vec2u(block % BLOCKS, block / BLOCKS) * 2u + vec2u(turn & 1u, turn >> 1u);
                pixels = pixels_from(first + place);
                later = draw(primitive, slot, pixels, over.zw);
                turn += 1u;
                if turn >= TURNS {
                    turn = 0u;
                    blocks &= blocks - 1u;
                }
                if !is_none(later) || blocks == 0u { break; }
            }
            if !is_none(later) { break; }
        }
        // This call runs for each block that defers rays, and once at the end.
        draw_again(primitive, slot, pixels, later);
        if blocks == 0u && tile >= end { break; }
    }
    cut_short |= blocks != 0u || tile < end;
}

// Returns the blocks of a tile to draw, one bit each, row by row.
fn blocks_to_draw(primitive: Primitive, tile: Tile) -> u32 {
    let all = vec4i(vec2i(0), vec2i(tile.size) - 1);
    return covered_blocks(all) & blocks_within_edges(primitive, tile);
}
