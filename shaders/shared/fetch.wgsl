// How a scene is read, and how a table is that a kernel looks up by index: in texels of four words, by the same
// functions whatever an adapter keeps them in.

@group(0) @binding(0) var<uniform> bvh: Bvh;

//! if fetch is buffer
// In storage buffers: for GPUs.

// The root's pair, then the primitives, then all other pairs: see src/geometry.rs.
@group(0) @binding(1) var<storage, read> geometry: array<vec4u>;

// Where the texels of a pair of children begin.
alias Place = u32;

fn pair_place(pair: u32) -> Place {
    return 2u * CHILD_TEXELS * pair;
}

fn node_texel(place: Place, texel: u32) -> vec4u {
    return geometry[place + texel];
}

fn primitive_texel(slot: u32, texel: u32) -> vec4u {
    return geometry[slot * PRIMITIVE_TEXELS + (2u * CHILD_TEXELS + texel)];
}

@group(2) @binding(0) var<storage, read> table: array<vec4u>;

fn table_texel(index: u32) -> vec4u {
    return table[index];
}

//! if fetch is texture
// In textures: for CPU adapters, where a texel is an unrolled gather, faster than a storage-buffer load
// (docs/TRAVERSAL.md). Storage textures, since a sampled one's load looks its mip level up for every lane.

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

@group(2) @binding(0) var table: texture_storage_2d<rgba32uint, read>;

// Texels stand row by row in textures 8192 wide, the least width that every WebGPU device offers.
fn texel_position(index: u32) -> vec2u {
    return vec2u(index & 8191u, index >> 13u);
}

fn table_texel(index: u32) -> vec4u {
    return textureLoad(table, texel_position(index));
}
