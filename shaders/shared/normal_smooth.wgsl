// Vertex normals: a fourth texel a primitive holds three of them, each two 16-bit snorms (octahedral mapping; Cigolle
// et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors"), and 1 if they are to be used.

const PRIMITIVE_TEXELS: u32 = 4u;

fn unpack_normal(word: u32) -> vec3f {
    let e = unpack2x16snorm(word);
    let z = 1.0 - abs(e.x) - abs(e.y);
    let fold = max(-z, 0.0);
    let xy = e + select(vec2f(fold), vec2f(-fold), e >= vec2f(0.0));
    return normalize(vec3f(xy, z));
}

// On the side of the geometric normal. Turned towards the viewer by itself, a normal that points away at a silhouette
// would be mirrored, and a lit rim go dark.
fn shading_normal(slot: u32, weights: vec3f, geometric: vec3f) -> vec3f {
    let packed = primitive_texel(slot, 3u);
    let sum = weights.x + weights.y + weights.z;
    let w = weights / sum;
    let blend = unpack_normal(packed.x) * w.x + unpack_normal(packed.y) * w.y + unpack_normal(packed.z) * w.z;
    let usable = packed.w == 1u && dot(blend, blend) > 1e-6;
    let normal = normalize(blend);
    return select(geometric, select(normal, -normal, dot(normal, geometric) < 0.0), usable);
}
