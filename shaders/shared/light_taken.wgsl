// Whether a light is seen: as the left view's samples say. Where they don't agree, the pixel is put off.

var<private> taken: Taken;
var<private> put_off: B;

fn lit_by(light: u32, wanted: B, ray: ShadowRay) -> B {
    let known = is_known(taken, light);
    put_off |= wanted & !known;
    return wanted & known & is_lit(taken, light);
}

fn light_bits() -> U {
    return U(0u);
}
