// Tiles of right pixels, row by row, and their blocks of 2x2; projection of boxes and primitives onto a tile.

const TILE: u32 = 8u;
const TILE_PIXELS: u32 = 64u;
const BLOCKS: u32 = 4u;         // across a tile
const TILE_BLOCKS: u32 = 16u;

fn tiles_across() -> u32 {
    return (frame.image_size.x + TILE - 1u) / TILE;
}

// Pixels of a row that a thread of mark_busy tests. It reads four more samples.
const BUSY_RUN: u32 = 16u;

// Words per tile of bound_tiles' result: the bits of its bound, and its busy lights.
const BOUND_WORDS: u32 = 2u;

// Returns the index of the first of these words for a pixel's tile.
fn bound_place(pixel: vec2u) -> u32 {
    return BOUND_WORDS * (pixel.y / TILE * tiles_across() + pixel.x / TILE);
}

// Returns the number of tiles in the rows at work.
fn tiles_at_work() -> u32 {
    return (frame.row_end - frame.row_begin + TILE - 1u) / TILE * tiles_across();
}

struct Tile {
    corner: vec2u,   // in the picture
    size: vec2u,
}

// A point p relative to the right eye has the column dot(p, column) / z and the row dot(p, row) / z, with z = dot(p,
// forward). The planes face inwards through the outermost pixel centres, moved out by frame.wider.
struct Projection {
    forward: vec3f,
    column: vec3f,
    row: vec3f,
    left_plane: vec3f,
    right_plane: vec3f,
    top_plane: vec3f,
    bottom_plane: vec3f,
}

fn projection_of(tile: Tile) -> Projection {
    let forward = frame.forward;
    let right = frame.right_axis;
    let up = cross(right, forward);
    let column = (right - forward * dot(frame.target_corner, right)) / dot(frame.step_x, right);
    let row = (up - forward * dot(frame.target_corner, up)) / dot(frame.step_y, up);
    let first = vec2f(tile.corner) + 0.5 - frame.wider;
    let last = vec2f(tile.corner + tile.size) - 0.5 + frame.wider;
    return Projection(
        forward,
        column,
        row,
        column - forward * first.x,
        forward * last.x - column,
        row - forward * first.y,
        forward * last.y - row,
    );
}

// Returns the largest value of dot(p, v) in a box.
fn most(child: Child, v: vec3f) -> f32 {
    let a = child.low * v;
    let b = child.high * v;
    let m = select(a, b, a < b);
    return m.x + m.y + m.z;
}

// Has no short circuits, which would be branches.
fn meets_frustum(child: Child, projection: Projection, limit: f32) -> bool {
    let across = min(most(child, projection.left_plane), most(child, projection.right_plane));
    let down = min(most(child, projection.top_plane), most(child, projection.bottom_plane));
    let ahead = most(child, projection.forward);
    return (min(min(across, down), ahead) >= 0.0) & (-most(child, -projection.forward) <= limit);
}

// Returns the first and last column and row of the tile's pixels, from its corner, whose centres a primitive may cover.
// If a first exceeds its last, there is none.
fn covered_pixels(primitive: Primitive, projection: Projection, tile: Tile) -> vec4i {
    let bounds = projected_bounds(primitive, projection);
    let corner = vec2f(tile.corner) + 0.5;
    let most = vec2f(tile.size) - 1.0;
    let first = ceil(clamp(bounds.xy - frame.wider - corner, vec2f(0.0), most + 1.0));
    let last = floor(clamp(bounds.zw + frame.wider - corner, vec2f(-1.0), most));
    // Rejects columns past the last one.
    let none = first.x > last.x;
    return vec4i(i32(first.x), select(i32(first.y), i32(TILE), none), i32(last.x), select(i32(last.y), -1, none));
}

// Returns the blocks of 2x2 pixels that contain these, one bit each, row by row.
fn covered_blocks(covered: vec4i) -> u32 {
    let first = vec2u(covered.xy) / 2u;
    let last = vec2u(covered.zw) / 2u;
    let columns = (2u << last.x) - (1u << first.x);
    let rows = (16u << (4u * last.y)) - (1u << (4u * first.y));
    return select(0u, (columns * 0x1111u) & rows, covered.y <= covered.w);
}

const ALL_BLOCKS: u32 = 0xffffu;
const EVERYWHERE: vec4f = vec4f(-1e9, -1e9, 1e9, 1e9);
