// Bounds of a primitive's projection, and the blocks of a tile that its edges let it reach.

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

// A sphere has no edges, so its bounds suffice.
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

//! end
// Returns the least and largest column and row of a triangle's projection; EVERYWHERE if it reaches the plane of the
// eyes.
fn triangle_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    let a = primitive.a - frame.target_eye;
    let b = primitive.b - frame.target_eye;
    let c = primitive.c - frame.target_eye;
    let z = vec3f(dot(a, projection.forward), dot(b, projection.forward), dot(c, projection.forward));
    let near = min(z.x, min(z.y, z.z));
    let x = vec3f(dot(a, projection.column), dot(b, projection.column), dot(c, projection.column)) / z;
    let y = vec3f(dot(a, projection.row), dot(b, projection.row), dot(c, projection.row)) / z;
    let bounds = vec4f(min(x.x, min(x.y, x.z)), min(y.x, min(y.y, y.z)), max(x.x, max(x.y, x.z)), max(y.x, max(y.y, y.z)));
    return select(EVERYWHERE, bounds, near > 0.0);
}

fn components(v: vec3f) -> f32 {
    return abs(v.x) + abs(v.y) + abs(v.z);
}

//! if canvas is picture
// Returns the blocks of a tile, one bit each, in which some ray may lie inside all planes through the eye and a
// triangle's edges. The planes are those of intersect_triangle. The inner side depends on the winding, so both are
// tried.
fn triangle_blocks(primitive: Primitive, tile: Tile) -> u32 {
    let a = primitive.a - frame.target_eye;
    let b = primitive.b - frame.target_eye;
    let c = primitive.c - frame.target_eye;
    let normal_a = edge_normal(b, c);
    let normal_b = edge_normal(c, a);
    let normal_c = edge_normal(a, b);
    // A plane's value is linear in column and row. It starts at the middle of the first block.
    let middle = vec2f(tile.corner) + 1.0;
    let first = frame.target_corner + frame.step_x * middle.x + frame.step_y * middle.y;
    let values = vec3f(dot(normal_a, first), dot(normal_b, first), dot(normal_c, first));
    let across = vec3f(dot(normal_a, frame.step_x), dot(normal_b, frame.step_x), dot(normal_c, frame.step_x));
    let down = vec3f(dot(normal_a, frame.step_y), dot(normal_b, frame.step_y), dot(normal_c, frame.step_y));
    // How much it changes from a block's middle to its farthest pixel centre. Rays that intersect_triangle may find
    // uncertain count as possible hits.
    let doubtful = frame.longest * (sqrt(dot(a, a)) + primitive.reach) * primitive.reach * (2.0 * DOUBT);
    let rounding = vec3f(components(normal_a), components(normal_b), components(normal_c)) * (1.0 / 1048576.0) + doubtful;
    let reach = (0.5 + frame.wider) * (abs(across) + abs(down)) + rounding;
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
// Slopes of tangent planes are divided by the ball's distance to the plane of the eyes. Below this share of its
// distance and size, rounding is too large.
const NEAR_PLANE: f32 = 1.0 / 8.0;

//! if texels is corners or spheres
// Returns the least and largest column and row of a sphere's projection; EVERYWHERE if it comes close to the plane of
// the eyes. The bounds are tangents in the planes of columns and of rows.
fn sphere_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    let center = primitive.a - frame.target_eye;
    let radius = primitive.b.x;
    let z = dot(center, projection.forward);
    let columns = tangents(dot(center, frame.right_axis), z, radius);
    let up = cross(frame.right_axis, projection.forward);
    let rows = tangents(dot(center, up), z, radius);
    let per_column = 1.0 / dot(frame.step_x, frame.right_axis);
    let per_row = 1.0 / dot(frame.step_y, up);
    let x = (columns - dot(frame.target_corner, frame.right_axis)) * per_column;
    let y = (rows - dot(frame.target_corner, up)) * per_row;
    let bounds = vec4f(min(x.x, x.y), min(y.x, y.y), max(x.x, x.y), max(y.x, y.y));
    return select(EVERYWHERE, bounds, z - radius > (length(center) + radius) * NEAR_PLANE);
}

// Returns the least and largest slope of the lines through the eye that touch a circle around (across, z).
fn tangents(across: f32, z: f32, radius: f32) -> vec2f {
    let rest = (z - radius) * (z + radius);
    let root = radius * sqrt(max(across * across + rest, 0.0));
    return vec2f(across * z - root, across * z + root) / rest;
}
