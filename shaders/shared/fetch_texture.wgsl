// The scene behind textures, for CPU adapters: there a texel is an unrolled gather, faster than a storage-buffer load
// (docs/TRAVERSAL.md). Storage textures, since a sampled one's load looks its mip level up for every lane. Twin of
// fetch_buffer.wgsl: same functions.

@group(0) @binding(0) var<uniform> bvh: Bvh;
@group(0) @binding(1) var nodes: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(2) var primitives: texture_storage_2d<rgba32uint, read>;

fn node_texel(index: u32) -> vec4u {
    return textureLoad(nodes, texel_position(index));
}

fn primitive_texel(index: u32) -> vec4u {
    return textureLoad(primitives, texel_position(index));
}
