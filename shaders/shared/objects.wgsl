// Table of the primitives' objects, in the order of the BVH. A texel holds four entries.

//! use fetch

//! if fetch is buffer
var<storage, read> object_table: array<vec4u>;

fn object_texel(index: u32) -> vec4u { return object_table[index]; }

//! if fetch is texture
var object_table: texture_storage_2d<rgba32uint, read>;

fn object_texel(index: u32) -> vec4u { return textureLoad(object_table, texel_position(index)); }
