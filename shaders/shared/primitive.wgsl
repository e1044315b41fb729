// Primitives, as the tree's texels hold them and intersection needs them.

//! use fetch

//! if texels is corners or spheres
// A primitive, as intersection needs it. A sphere has its centre in a and its radius in b.x.
struct Primitive {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    id: u32,          // in the scene's order
    component: u32,   // connected component, from bit 1 on; IS_SPHERE
    reach: f32,       // of a triangle: at least its longest edge
}

//! end
// Lowest bit of a component: set for spheres, ellipsoids and planes, which are no triangles.
const IS_SPHERE: u32 = 1u;
// The material, in w of a primitive's third texel. Above it are the upper 16 bits of a triangle's reach.
const MATERIAL: u32 = 0x0000ffffu;

fn reach_of(word: u32) -> f32 {
    return bitcast<f32>(word & 0xffff0000u);
}

//! if texels is ellipsoids
// A primitive, as intersection needs it. An ellipsoid has its centre in a. The rows b, c and d form the matrix that
// maps offsets from this centre to offsets from the sphere's centre. The rows are orthogonal, each along a semi-axis
// (src/scene/ellipsoid.rs). So rounding in a product with one row moves a point along that semi-axis only, by no more
// than the offset's own rounding.
struct Primitive {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    d: vec3f,
    id: u32,          // in the scene's order
    component: u32,   // connected component, from bit 1 on; IS_SPHERE
    reach: f32,       // of a triangle: at least its longest edge; of an ellipsoid: the sphere's radius
}

// Reads four texels: these vectors in xyz, with id, component, material and radius in w.
fn primitive_at(slot: u32) -> Primitive {
    let first = primitive_texel(slot, 0u);
    let second = primitive_texel(slot, 1u);
    let third = primitive_texel(slot, 2u);
    let fourth = primitive_texel(slot, 3u);
    let reach = select(reach_of(third.w), bitcast<f32>(fourth.w), (second.w & IS_SPHERE) != 0u);
    return Primitive(
        bitcast<vec3f>(first.xyz),
        bitcast<vec3f>(second.xyz),
        bitcast<vec3f>(third.xyz),
        bitcast<vec3f>(fourth.xyz),
        first.w,
        second.w,
        reach,
    );
}

//! if texels is corners
fn primitive_at(slot: u32) -> Primitive {
    let first = primitive_texel(slot, 0u);
    let second = primitive_texel(slot, 1u);
    let third = primitive_texel(slot, 2u);
    return Primitive(
        bitcast<vec3f>(first.xyz),
        bitcast<vec3f>(second.xyz),
        bitcast<vec3f>(third.xyz),
        first.w,
        second.w,
        reach_of(third.w),
    );
}

//! if texels is spheres
// Centre and id, then radius and component, in texels like those of a triangle.
fn primitive_at(slot: u32) -> Primitive {
    let first = primitive_texel(slot, 0u);
    let second = primitive_texel(slot, 1u);
    return Primitive(bitcast<vec3f>(first.xyz), bitcast<vec3f>(second.xyz), vec3f(0.0), first.w, second.w, 0.0);
}
