// The scene behind storage buffers, for GPUs. Twin of fetch_texture.wgsl: same functions.

@group(0) @binding(0) var<uniform> bvh: Bvh;
@group(0) @binding(1) var<storage, read> nodes: array<vec4u>;
@group(0) @binding(2) var<storage, read> primitives: array<vec4u>;

fn node_texel(index: u32) -> vec4u {
    return nodes[index];
}

fn primitive_texel(index: u32) -> vec4u {
    return primitives[index];
}
