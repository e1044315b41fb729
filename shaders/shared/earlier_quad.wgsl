// The four samples of an earlier frame around a point (docs/BRACKET.md, "Earlier frames").

//! use history, jitter

// The samples, and where the point is between them.
struct EarlierQuad {
    shown: bool,      // whether all four show the point's surface
    upper: vec2u,     // the sample on the left in the upper row
    lower: vec2u,     // the sample on the left in the lower row
    way: vec3f,       // position of the point in the upper row, in the lower row, and from row to row, 0 to 1
    a: vec4u,         // texels: upper row
    b: vec4u,
    c: vec4u,         // lower row
    d: vec4u,
    depth: f32,       // of the point, from the earlier eye
    steepest: f32,    // largest difference of a sample's depth from the point's, as a share of the depth
}

fn no_quad() -> EarlierQuad {
    var none: EarlierQuad;
    return none;
}

fn quad_around(eye: EarlierEye, point: vec3f, normal: vec3f, component: u32) -> EarlierQuad {
    let there = point - eye.place;
    // The earlier eye must have seen the same side of the surface.
    if dot(there, normal) >= 0.0 { return no_quad(); }
    // The vector whose product with all directions to pixels is 1.
    let across = cross(eye.step_x, eye.step_y);
    let forward = across / dot(across, eye.corner);
    let depth = dot(there, forward);
    if !(depth > 0.0) { return no_quad(); }
    let aside = there / depth - eye.corner;
    let place = in_steps_of(aside, eye.step_x, eye.step_y) - 0.5;
    let size = vec2f(history_size());
    if !(place.y >= 0.0 && place.y + 1.0 < size.y) { return no_quad(); }
    let row = u32(place.y);
    // Samples of a row are offset from the centres of their pixels.
    // Rows have the same offsets in both frames, since they have one seed if light is recalled.
    let columns = vec2f(place.x) - vec2f(row_aside(row), row_aside(row + 1u));
    if !(all(columns >= vec2f(0.0)) && all(columns + 1.0 < vec2f(size.x))) { return no_quad(); }
    let upper = vec2u(u32(columns.x), row);
    let lower = vec2u(u32(columns.y), row + 1u);
    let a = textureLoad(history, upper, 0);
    let b = textureLoad(history, upper + vec2u(1u, 0u), 0);
    let c = textureLoad(history, lower, 0);
    let d = textureLoad(history, lower + vec2u(1u, 0u), 0);
    let differ = vec4u(a.z, b.z, c.z, d.z) != vec4u(component);
    let steepest = STEEPEST * length(eye.step_x);
    let apart = abs(depth / bitcast<vec4f>(vec4u(a.x, b.x, c.x, d.x)) - 1.0);
    let shown = !any(differ) && all(apart <= vec4f(steepest));
    let way = vec3f(fract(columns), fract(place.y));
    return EarlierQuad(shown, upper, lower, way, a, b, c, d, depth, steepest);
}

// Returns whether a point lies deeper than the plane through its samples.
fn is_in_groove(quad: EarlierQuad) -> bool {
    // Reciprocals of depths are linear on a plane.
    return quad.depth * between_four(1.0 / depths_of(quad), quad.way) - 1.0 > GROOVE * quad.steepest;
}

fn depths_of(quad: EarlierQuad) -> vec4f { return bitcast<vec4f>(vec4u(quad.a.x, quad.b.x, quad.c.x, quad.d.x)); }

// Interpolates between the values of four samples: upper row, then lower row.
fn between_four(values: vec4f, way: vec3f) -> f32 {
    return mix(mix(values.x, values.y, way.x), mix(values.z, values.w, way.y), way.z);
}
