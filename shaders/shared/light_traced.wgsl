// Whether a light is seen: by a shadow ray, always. What it found is kept for the other eye where a method asks for it.

var<private> found_bits: U;
// What hides the last of the lights that are hidden, by its place among the primitives.
var<private> found_occluders: U = U(MISS);

fn lit_by(light: u32, wanted: B, ray: ShadowRay) -> B {
    let occluders = occluders_of(ray, wanted);
    let lit = wanted & (occluders == U(MISS));
    if KEEP_BITS && light < 16u {
        found_bits |= select(U(0u), U(1u << (light + 16u)), wanted) | select(U(0u), U(1u << light), lit);
        found_occluders = select(found_occluders, occluders, wanted & !lit);
    }
    return lit;
}

fn light_bits() -> U {
    return found_bits;
}
