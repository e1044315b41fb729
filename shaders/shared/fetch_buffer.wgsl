// The scene behind storage buffers, for GPUs. Twin of fetch_texture.wgsl: same functions.

@group(0) @binding(0) var<uniform> bvh: Bvh;
@group(0) @binding(1) var<storage, read> nodes: array<vec4u>;
@group(0) @binding(2) var<storage, read> primitives: array<vec4u>;

// Where the texels of a pair of children begin.
alias Place = u32;

fn pair_place(pair: u32) -> Place {
    return 2u * CHILD_TEXELS * pair;
}

fn node_texel(place: Place, texel: u32) -> vec4u {
    return nodes[place + texel];
}

fn primitive_texel(slot: u32, texel: u32) -> vec4u {
    return primitives[slot * PRIMITIVE_TEXELS + texel];
}
