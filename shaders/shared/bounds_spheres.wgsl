// A scene of spheres only.
fn projected_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    return sphere_bounds(primitive, projection);
}

struct Edges { none: u32 }

fn edges_of(primitive: Primitive) -> Edges {
    return Edges(0u);
}

fn may_cover(edges: Edges, middle: vec2f) -> bool {
    return true;
}
