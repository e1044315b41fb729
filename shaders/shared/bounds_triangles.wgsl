// A scene of triangles only.
fn projected_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    return triangle_bounds(primitive, projection);
}

fn edges_of(primitive: Primitive) -> Edges {
    return triangle_edges(primitive);
}

fn may_cover(edges: Edges, middle: vec2f) -> bool {
    return within_edges(edges, middle);
}
