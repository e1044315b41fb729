// A table that a kernel looks up by index.

//! if fetch is texture
// For CPU adapters (fetch_texture.wgsl).
@group(2) @binding(0) var table: texture_storage_2d<rgba32uint, read>;

// Texels stand row by row in textures 8192 wide, the least width that every WebGPU device offers.
fn texel_position(index: u32) -> vec2u {
    return vec2u(index & 8191u, index >> 13u);
}

fn table_texel(index: u32) -> vec4u {
    return textureLoad(table, texel_position(index));
}

//! if fetch is buffer
// For GPUs.
@group(2) @binding(0) var<storage, read> table: array<vec4u>;

fn table_texel(index: u32) -> vec4u {
    return table[index];
}
