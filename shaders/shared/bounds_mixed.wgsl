// A scene of triangles and spheres.
fn projected_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    if is_sphere(primitive) { return sphere_bounds(primitive, projection); }
    return triangle_bounds(primitive, projection);
}

// A sphere has no edges: its bounds are all there is.
fn blocks_within_edges(primitive: Primitive, tile: Tile) -> u32 {
    return select(triangle_blocks(primitive, tile), ALL_BLOCKS, is_sphere(primitive));
}
