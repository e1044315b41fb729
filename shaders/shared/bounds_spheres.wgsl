// A scene of spheres only.
fn projected_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    return sphere_bounds(primitive, projection);
}

fn blocks_within_edges(primitive: Primitive, tile: Tile) -> u32 {
    return ALL_BLOCKS;
}
