// Least and largest column and row of a sphere's projection; everywhere if it reaches the plane of the eyes. The bounds are those of
// the tangents in the planes of columns and of rows.
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
    return select(EVERYWHERE, bounds, z - radius > 0.0);
}

// Least and largest slope of the lines through the eye that touch a circle around (across, z).
fn tangents(across: f32, z: f32, radius: f32) -> vec2f {
    let rest = (z - radius) * (z + radius);
    let root = radius * sqrt(max(across * across + rest, 0.0));
    return vec2f(across * z - root, across * z + root) / rest;
}
