// A table behind a storage buffer, for GPUs. Twin of table_texture.wgsl.

@group(2) @binding(0) var<storage, read> table: array<vec4u>;

fn table_texel(index: u32) -> vec4u {
    return table[index];
}
