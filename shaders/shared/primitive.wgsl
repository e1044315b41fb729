// Primitives, in the form in which texels store them and intersection tests use them.

//! use fetch

//! if texels is corners or spheres
// A primitive for intersection tests. A sphere has its centre in a and its radius in b.x.
struct Primitive {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    id: u32,          // id in the scene's order
    component: u32,   // connected component from bit 1 on; bit 0: IS_SPHERE
    reach: f32,       // of a triangle: at least its longest edge
}

//! end
// Lowest bit of a component. It is set for spheres, ellipsoids and planes, and not for triangles.
const IS_SPHERE: u32 = 1u;
// Mask of the material in w of a primitive's third texel. Above it are the upper 16 bits of a triangle's reach.
const MATERIAL: u32 = 0x0000ffffu;

fn reach_of(word: u32) -> f32 {
    return bitcast<f32>(word & 0xffff0000u);
}

//! if texels is ellipsoids
// A primitive for intersection tests. An ellipsoid has its centre in a. The rows b, c and d form the matrix that maps
// offsets from this centre to offsets from the sphere's centre. The rows are orthogonal, each along a semi-axis
// (src/scene/ellipsoid.rs). So rounding in a product with one row moves a point along that semi-axis only, by no more
// than the offset's own rounding.
struct Primitive {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    d: vec3f,
    id: u32,          // id in the scene's order
    component: u32,   // connected component from bit 1 on; bit 0: IS_SPHERE
    reach: f32,       // of a triangle: at least its longest edge; of an ellipsoid: the sphere's radius
}

// Reads a primitive's four texels. Their xyz are a, b, c and d; their w are id, component, material and radius.
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
// The first texel of a sphere holds its centre and id, the second its radius and component. The layout matches the
// layout of triangles.
fn primitive_at(slot: u32) -> Primitive {
    let first = primitive_texel(slot, 0u);
    let second = primitive_texel(slot, 1u);
    return Primitive(bitcast<vec3f>(first.xyz), bitcast<vec3f>(second.xyz), vec3f(0.0), first.w, second.w, 0.0);
}
