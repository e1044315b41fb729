// Frusta of tiles, bounded by planes, and projections of boxes and primitives onto tiles.

//! use boxes, counters, ellipsoid, fetch, frame, jitter, planes, primitive, primitives, tiles, triangle

//! if camera is planar
// A point p relative to the target's eye has the depth z = dot(p, forward). Its column is dot(p, column) / z, and its
// row is dot(p, row) / z. The planes face inwards through the outermost pixel centres, moved out by the guard band.
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
    let forward = frame.eyes.forward;
    let right = frame.eyes.right_axis;
    let up = cross(right, forward);
    let column = (right - forward * dot(frame.eyes.target_corner, right)) / dot(frame.eyes.step_x, right);
    let row = (up - forward * dot(frame.eyes.target_corner, up)) / dot(frame.eyes.step_y, up);
    let first = vec2f(tile.corner) + 0.5 - frame.eyes.wider;
    let last = vec2f(tile.corner + tile.size) - 0.5 + frame.eyes.wider;
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

// Returns whether a box may meet a tile's frustum up to a depth limit. The function uses no short-circuit operators,
// which would be branches.
fn meets_frustum(child: Child, projection: Projection, limit: f32) -> bool {
    let across = min(most(child, projection.left_plane), most(child, projection.right_plane));
    let down = min(most(child, projection.top_plane), most(child, projection.bottom_plane));
    let ahead = most(child, projection.forward);
    return (min(min(across, down), ahead) >= 0.0) & (-most(child, -projection.forward) <= limit);
}

//! end
// Returns the guard band around the projections of primitives, in pixels across and down. Samples are jittered along
// their rows only.
fn guard_band() -> vec2f { return vec2f(frame.eyes.wider, frame.eyes.wider - jitter_reach()); }

// Returns the largest value of dot(p, v) over all points p of a box.
fn most(child: Child, v: vec3f) -> f32 {
    let a = child.low * v;
    let b = child.high * v;
    let m = select(a, b, a < b);
    return m.x + m.y + m.z;
}

// Returns the range of a tile's pixels whose centres a primitive may cover: first column, first row, last column, last
// row. Coordinates count from the tile's corner. If a first value exceeds its last one, the range is empty.
fn covered_pixels(primitive: Primitive, projection: Projection, tile: Tile) -> vec4i {
    let bounds = projected_bounds(primitive, projection);
    let corner = vec2f(tile.corner) + 0.5;
    let most = vec2f(tile.size) - 1.0;
    let first = ceil(clamp(bounds.xy - frame.eyes.wider - corner, vec2f(0.0), most + 1.0));
    let last = floor(clamp(bounds.zw + frame.eyes.wider - corner, vec2f(-1.0), most));
    // If the range of columns is empty, the range of rows is made empty too.
    let none = first.x > last.x;
    return vec4i(i32(first.x), select(i32(first.y), i32(TILE), none), i32(last.x), select(i32(last.y), -1, none));
}

const EVERYWHERE: vec4f = vec4f(-1e9, -1e9, 1e9, 1e9);

//! if primitives is triangles
fn projected_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    return triangle_bounds(primitive, projection);
}

fn blocks_within_edges(primitive: Primitive, tile: Tile) -> u32 {
    return triangle_blocks(primitive, tile);
}

//! if primitives is spheres
fn projected_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    return sphere_bounds(primitive, projection);
}

// A sphere has no edges, so its projected bounds suffice.
fn blocks_within_edges(primitive: Primitive, tile: Tile) -> u32 {
    return ALL_BLOCKS;
}

//! if primitives is mixed
fn projected_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    if is_sphere(primitive) { return sphere_bounds(primitive, projection); }
    return triangle_bounds(primitive, projection);
}

fn blocks_within_edges(primitive: Primitive, tile: Tile) -> u32 {
    return select(triangle_blocks(primitive, tile), ALL_BLOCKS, is_sphere(primitive));
}

//! if camera is planar
// Returns the smallest and largest column and row of a triangle's projection. The result is EVERYWHERE if the triangle
// reaches the plane through the eye and perpendicular to the view axis.
fn triangle_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    let a = primitive.a - frame.eyes.target_eye;
    let b = primitive.b - frame.eyes.target_eye;
    let c = primitive.c - frame.eyes.target_eye;
    let z = vec3f(dot(a, projection.forward), dot(b, projection.forward), dot(c, projection.forward));
    let near = min(z.x, min(z.y, z.z));
    let x = vec3f(dot(a, projection.column), dot(b, projection.column), dot(c, projection.column)) / z;
    let y = vec3f(dot(a, projection.row), dot(b, projection.row), dot(c, projection.row)) / z;
    let bounds = vec4f(
        min(x.x, min(x.y, x.z)),
        min(y.x, min(y.y, y.z)),
        max(x.x, max(x.y, x.z)),
        max(y.x, max(y.y, y.z)),
    );
    return select(EVERYWHERE, bounds, near > 0.0);
}

//! end
fn components(v: vec3f) -> f32 {
    return abs(v.x) + abs(v.y) + abs(v.z);
}

//! if canvas is picture and camera is planar
// Returns the blocks of a tile, one bit each, in which some ray may lie inside all planes through the eye and a
// triangle's edges. The planes are the same as in intersect_triangle. The inner side depends on the winding, so both
// sides are tested.
fn triangle_blocks(primitive: Primitive, tile: Tile) -> u32 {
    let a = primitive.a - frame.eyes.target_eye;
    let b = primitive.b - frame.eyes.target_eye;
    let c = primitive.c - frame.eyes.target_eye;
    let normal_a = edge_normal(b, c);
    let normal_b = edge_normal(c, a);
    let normal_c = edge_normal(a, b);
    // The value of a plane's equation is linear in column and row. It is computed at the centre of the first block.
    let middle = vec2f(tile.corner) + 1.0;
    let first = frame.eyes.target_corner + frame.eyes.step_x * middle.x + frame.eyes.step_y * middle.y;
    let values = vec3f(dot(normal_a, first), dot(normal_b, first), dot(normal_c, first));
    let across = vec3f(
        dot(normal_a, frame.eyes.step_x),
        dot(normal_b, frame.eyes.step_x),
        dot(normal_c, frame.eyes.step_x),
    );
    let down = vec3f(
        dot(normal_a, frame.eyes.step_y),
        dot(normal_b, frame.eyes.step_y),
        dot(normal_c, frame.eyes.step_y),
    );
    // `reach` bounds the change of a plane's value from a block's centre to its farthest pixel centre. Rays that
    // intersect_triangle may find uncertain count as possible hits.
    let doubtful = frame.eyes.longest * (sqrt(dot(a, a)) + primitive.reach) * primitive.reach * (2.0 * DOUBT);
    let rounding = vec3f(
        components(normal_a),
        components(normal_b),
        components(normal_c),
    ) * (1.0 / 1048576.0) + doubtful;
    let reach = (0.5 + frame.eyes.wider) * (abs(across) + abs(down)) + rounding;
    return blocks_of_rows(values, across, down, reach);
}

//! if canvas is picture
// Returns the blocks of a tile, one bit each, in which the values of all three planes may have one sign. `values` are
// those at the centre of the first block, and change by `across` and `down` per pixel.
fn blocks_of_rows(values: vec3f, across: vec3f, down: vec3f, reach: vec3f) -> u32 {
    return blocks_of_row(values, across, reach)
        | (blocks_of_row(values + 2.0 * down, across, reach) << 4u)
        | (blocks_of_row(values + 4.0 * down, across, reach) << 8u)
        | (blocks_of_row(values + 6.0 * down, across, reach) << 12u);
}

// Tests the four blocks of a row at once.
fn blocks_of_row(values: vec3f, across: vec3f, reach: vec3f) -> u32 {
    let columns = vec4f(0.0, 2.0, 4.0, 6.0);
    let a = values.x + across.x * columns;
    let b = values.y + across.y * columns;
    let c = values.z + across.z * columns;
    let one_way = (a >= vec4f(-reach.x)) & (b >= vec4f(-reach.y)) & (c >= vec4f(-reach.z));
    let other_way = (a <= vec4f(reach.x)) & (b <= vec4f(reach.y)) & (c <= vec4f(reach.z));
    let bits = select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), one_way | other_way);
    return (bits.x | bits.y) | (bits.z | bits.w);
}

//! end
// Minimum depth of the near side of a sphere or ellipsoid, as a share of its distance and size. The slopes of tangent
// planes have small divisors at smaller depths, so their rounding error is too large.
const NEAR_PLANE: f32 = 1.0 / 8.0;

//! if texels is corners or spheres and camera is planar
// Returns the smallest and largest column and row of a sphere's projection. The result is EVERYWHERE if the sphere
// comes close to the plane of the eye. The bounds are tangents in the planes of columns and of rows.
fn sphere_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    let center = primitive.a - frame.eyes.target_eye;
    let radius = primitive.b.x;
    let z = dot(center, projection.forward);
    let columns = tangents(dot(center, frame.eyes.right_axis), z, radius);
    let up = cross(frame.eyes.right_axis, projection.forward);
    let rows = tangents(dot(center, up), z, radius);
    let per_column = 1.0 / dot(frame.eyes.step_x, frame.eyes.right_axis);
    let per_row = 1.0 / dot(frame.eyes.step_y, up);
    let x = (columns - dot(frame.eyes.target_corner, frame.eyes.right_axis)) * per_column;
    let y = (rows - dot(frame.eyes.target_corner, up)) * per_row;
    let bounds = vec4f(min(x.x, x.y), min(y.x, y.y), max(x.x, x.y), max(y.x, y.y));
    return select(EVERYWHERE, bounds, z - radius > (length(center) + radius) * NEAR_PLANE);
}

//! if texels is corners or spheres or ellipsoids
// Returns the least and largest slope of the lines through the eye that touch a circle around (across, z).
fn tangents(across: f32, z: f32, radius: f32) -> vec2f {
    let rest = (z - radius) * (z + radius);
    let root = radius * sqrt(max(across * across + rest, 0.0));
    return vec2f(across * z - root, across * z + root) / rest;
}

//! if texels is ellipsoids and camera is planar
// Returns the smallest and largest column and row of an ellipsoid's projection. The result is EVERYWHERE if the
// ellipsoid comes close to the plane of the eye. The bounds are tangent planes through the eye, along the picture's
// columns and rows.
fn sphere_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    let center = primitive.a - frame.eyes.target_eye;
    let up = cross(frame.eyes.right_axis, projection.forward);
    // The length of a vector from half_widths is the ellipsoid's extent along that axis.
    let forward = half_widths(primitive, projection.forward);
    let z = dot(center, projection.forward);
    let depth = length(forward);
    let columns = touching(
        dot(center, frame.eyes.right_axis),
        z,
        half_widths(primitive, frame.eyes.right_axis),
        forward,
        depth,
    );
    let rows = touching(dot(center, up), z, half_widths(primitive, up), forward, depth);
    let per_column = 1.0 / dot(frame.eyes.step_x, frame.eyes.right_axis);
    let per_row = 1.0 / dot(frame.eyes.step_y, up);
    let x = (columns - dot(frame.eyes.target_corner, frame.eyes.right_axis)) * per_column;
    let y = (rows - dot(frame.eyes.target_corner, up)) * per_row;
    let bounds = vec4f(min(x.x, x.y), min(y.x, y.y), max(x.x, x.y), max(y.x, y.y));
    return select(EVERYWHERE, bounds, z - depth > (length(center) + primitive.reach) * NEAR_PLANE);
}

//! if planes is some and camera is planar
// Tolerance of a ray's speed of approach to a plane, as a fraction of the longest direction. It exceeds the rounding
// error.
const PLANE_SLACK: f32 = 1.0 / 524288.0;

// Returns whether some ray of a tile may meet a plane. The speed of approach is linear in column and row, so it is
// largest in a corner. The loop contains no return statement: llvmpipe's OpenGL would instead return the value after
// the loop.
fn meets_planes(tile: Tile) -> bool {
    // Jittered samples are offset along their rows.
    let aside = vec2f(jitter_reach(), 0.0);
    let middle = vec2f(tile.corner) + 0.5;
    let first = middle - aside;
    let last = middle + vec2f(tile.size) - 1.0 + aside;
    var met = false;
    var slot = 0u;
    loop {
        let normal = bitcast<vec3f>(primitive_texel(slot, 1u).xyz);
        let towards = select(normal, -normal, plane_above(slot, frame.eyes.target_eye) < 0.0);
        let columns = vec2f(first.x, last.x) * dot(towards, frame.eyes.step_x);
        let rows = vec2f(first.y, last.y) * dot(towards, frame.eyes.step_y);
        let fastest = dot(towards, frame.eyes.target_corner) + max(columns.x, columns.y) + max(rows.x, rows.y);
        met |= fastest >= -frame.eyes.longest * PLANE_SLACK;
        slot += 1u;
        if slot >= PLANES { break; }
    }
    cut_short |= slot < PLANES;
    return met;
}
