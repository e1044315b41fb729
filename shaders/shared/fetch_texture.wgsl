// The scene behind textures: on CPU adapters a texture load is an unrolled gather, faster than a
// storage-buffer load (1.2 to 5.8 times, docs/TRAVERSAL.md). Twin of fetch_buffer.wgsl: same functions.

@group(0) @binding(0) var<uniform> bvh: Bvh;
@group(0) @binding(1) var nodes: texture_2d<u32>;
@group(0) @binding(2) var primitives: texture_2d<u32>;
@group(2) @binding(0) var<uniform> shading: Shading;
@group(2) @binding(1) var shading_table: texture_2d<u32>;

// Texels stand row by row in textures 8192 wide, the least width that every WebGPU device offers.
fn texel_position(index: u32) -> vec2u {
    return vec2u(index & 8191u, index >> 13u);
}

fn node_texel(index: u32) -> vec4u {
    return textureLoad(nodes, texel_position(index), 0);
}

fn primitive_texel(index: u32) -> vec4u {
    return textureLoad(primitives, texel_position(index), 0);
}

fn shading_texel(index: u32) -> vec4f {
    return bitcast<vec4f>(textureLoad(shading_table, texel_position(index), 0));
}
