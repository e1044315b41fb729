// Unit vectors folded onto a square (Meyer et al. 2010, "On Floating-Point Normal Vectors").

// Marks a pixel that shows no surface.
const NO_NORMAL: u32 = 0x80008000u;

// Folds the corners of the square over its inner diamond, or back.
fn folded(at: vec2f) -> vec2f {
    return (1.0 - abs(at.yx)) * select(vec2f(-1.0), vec2f(1.0), at >= vec2f(0.0));
}

fn octahedral(normal: vec3f) -> u32 {
    let flat = normal.xy / (abs(normal.x) + abs(normal.y) + abs(normal.z));
    return pack2x16snorm(select(flat, folded(flat), normal.z < 0.0));
}

fn from_octahedral(packed: u32) -> vec3f {
    return from_octahedron(unpack2x16snorm(packed));
}

fn from_octahedron(flat: vec2f) -> vec3f {
    let z = 1.0 - abs(flat.x) - abs(flat.y);
    return normalize(vec3f(select(flat, folded(flat), z < 0.0), z));
}
