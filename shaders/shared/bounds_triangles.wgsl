// A scene of triangles only.
fn projected_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    return triangle_bounds(primitive, projection);
}

fn blocks_within_edges(primitive: Primitive, tile: Tile) -> u32 {
    return triangle_blocks(primitive, tile);
}
