// Access to the scene's geometry and to a table, in texels of four words. The functions are the same for buffers and
// textures.

//! if boxes is grid
// Number of texels of a node's child (boxes.wgsl).
const CHILD_TEXELS: u32 = 1u;

//! if boxes is f32 or world
const CHILD_TEXELS: u32 = 2u;

//! end
struct Bvh {
    grid_origin: vec3f,   // grid point 0, scene coordinates
    extent: f32,          // largest side of the scene's box, world units
    grid_cell: vec3f,     // world size of a grid step
    zero: u32,            // always 0, which compilers do not know
    cutouts: u32,         // texel of the first material's mask head: src/accel/cutouts.rs
    parents: u32,         // word of the parent of pair 0, modulo 2^32; only in buffers
}

var<uniform> bvh: Bvh;

//! if fetch is buffer
// The data is in storage buffers, for GPUs.

// The order is the root's pair, the primitives, all other pairs, masks and parents (src/accel/geometry.rs).
var<storage, read> geometry: array<vec4u>;

// Index of the first texel of a pair of children.
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

// Returns the pair that a pair other than the root is a child of.
fn parent_of(pair: u32) -> u32 {
    let word = bvh.parents + pair;
    return geometry[word >> 2u][word & 3u];
}

var<storage, read> table: array<vec4u>;

fn table_texel(index: u32) -> vec4u {
    return table[index];
}

//! if fetch is texture
// The data is in textures, for CPU adapters. There a texel load is an unrolled gather, which is faster than a
// storage-buffer load (docs/TRAVERSAL.md). The textures are storage textures, since a sampled texture looks up its mip
// level for every lane.

// The first row holds the root's pair alone. Rows of primitives follow, then rows of all other pairs: see
// src/accel/geometry.rs.
var geometry: texture_storage_2d<rgba32uint, read>;

// Position of the first texel of a pair of children. The texels of a pair are in one row, so their addresses differ by
// the column only.
alias Place = vec2u;

fn pair_place(pair: u32) -> Place {
    return texel_position(2u * CHILD_TEXELS * pair);
}

fn node_texel(place: Place, texel: u32) -> vec4u {
    return textureLoad(geometry, vec2u(place.x + texel, place.y));
}

// A primitive's texels are stored in one column, in consecutive rows. A row has the first texels of 8192 primitives,
// the next row their second texels.
fn primitive_texel(slot: u32, texel: u32) -> vec4u {
    let first = texel_position(slot);
    return textureLoad(geometry, vec2u(first.x, first.y * PRIMITIVE_TEXELS + (1u + texel)));
}

var table: texture_storage_2d<rgba32uint, read>;

// Textures are 8192 texels wide, which every WebGPU device supports, and filled row by row.
fn texel_position(index: u32) -> vec2u {
    return vec2u(index & 8191u, index >> 13u);
}

fn table_texel(index: u32) -> vec4u {
    return textureLoad(table, texel_position(index));
}

//! if fetch is buffer
fn geometry_texel(index: u32) -> vec4u {
    return geometry[index];
}

//! if fetch is texture
fn geometry_texel(index: u32) -> vec4u {
    return textureLoad(geometry, texel_position(index));
}
