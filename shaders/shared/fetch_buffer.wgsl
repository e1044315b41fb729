// The scene behind storage buffers, for GPUs. Twin of fetch_texture.wgsl: same functions.

@group(0) @binding(0) var<uniform> bvh: Bvh;
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
