// Whether a light is seen: by a shadow ray, always. What it found is kept for the other eye where a method asks for it.

var<private> found_bits: U;

fn lit_by(light: u32, wanted: B, ray: ShadowRay) -> B {
    let lit = wanted & !shadowed(ray, wanted);
    if KEEP_BITS && light < 16u {
        found_bits |= select(U(0u), U(1u << (light + 16u)), wanted) | select(U(0u), U(1u << light), lit);
    }
    return lit;
}

fn light_bits() -> U {
    return found_bits;
}
