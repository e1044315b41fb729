// The scene behind textures, for CPU adapters: there a texel is an unrolled gather, faster than a storage-buffer load
// (docs/TRAVERSAL.md). Storage textures, since a sampled one's load looks its mip level up for every lane. Twin of
// fetch_buffer.wgsl: same functions.

@group(0) @binding(0) var<uniform> bvh: Bvh;
// The root's pair alone in the first row, then rows of primitives, then rows of all other pairs: see src/geometry.rs.
@group(0) @binding(1) var geometry: texture_storage_2d<rgba32uint, read>;

// Where the texels of a pair of children begin. They stand in one row, so that all have one address but for the column.
alias Place = vec2u;

fn pair_place(pair: u32) -> Place {
    return texel_position(2u * CHILD_TEXELS * pair);
}

fn node_texel(place: Place, texel: u32) -> vec4u {
    return textureLoad(geometry, vec2u(place.x + texel, place.y));
}

// A primitive's texels stand below each other: 8192 primitives' first ones in a row, then their second ones.
fn primitive_texel(slot: u32, texel: u32) -> vec4u {
    let first = texel_position(slot);
    return textureLoad(geometry, vec2u(first.x, first.y * PRIMITIVE_TEXELS + (1u + texel)));
}
