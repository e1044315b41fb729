// A scene of triangles and spheres.
fn projected_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    if is_sphere(primitive) { return sphere_bounds(primitive, projection); }
    return triangle_bounds(primitive, projection);
}

fn edges_of(primitive: Primitive) -> Edges {
    var edges = triangle_edges(primitive);
    // A sphere has none: its bounds are all there is.
    edges.reach = select(edges.reach, vec3f(FAR), is_sphere(primitive));
    return edges;
}

fn may_cover(edges: Edges, middle: vec2f) -> bool {
    return within_edges(edges, middle);
}
