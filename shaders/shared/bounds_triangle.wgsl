// Least and largest column and row of a triangle's projection; everywhere if it reaches the plane of the eyes.
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

// The planes through the eye and a triangle's edges, as intersect_triangle has them, and how much their values change from the middle
// of a block to its farthest pixel centre.
struct Edges {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    reach: vec3f,
}

fn triangle_edges(primitive: Primitive) -> Edges {
    let a = primitive.a - frame.target_eye;
    let b = primitive.b - frame.target_eye;
    let c = primitive.c - frame.target_eye;
    let normal_a = edge_normal(b, c);
    let normal_b = edge_normal(c, a);
    let normal_c = edge_normal(a, b);
    // Whatever intersect_triangle may call doubtful may be hit.
    let rounding = frame.longest * (sqrt(dot(a, a)) + primitive.reach) * primitive.reach * (2.0 * DOUBT);
    return Edges(normal_a, normal_b, normal_c, vec3f(reach(normal_a), reach(normal_b), reach(normal_c)) + rounding);
}

fn reach(normal: vec3f) -> f32 {
    let rounding = (abs(normal.x) + abs(normal.y) + abs(normal.z)) * (1.0 / 1048576.0);
    return (0.5 + frame.wider) * (abs(dot(normal, frame.step_x)) + abs(dot(normal, frame.step_y))) + rounding;
}

// Whether a ray of a block, its middle in pixels, may lie on the inner sides of all edges; which these are, the triangle's winding
// says.
fn within_edges(edges: Edges, middle: vec2f) -> bool {
    let direction = frame.target_corner + frame.step_x * middle.x + frame.step_y * middle.y;
    let there = vec3f(dot(edges.a, direction), dot(edges.b, direction), dot(edges.c, direction));
    return all(there >= -edges.reach) | all(there <= edges.reach);
}
