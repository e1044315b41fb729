// Whether a light is seen: as the left view's samples say, and by a shadow ray where they don't agree.

var<private> taken: Taken;
// Pixels that needed a shadow ray.
var<private> asked: B;

fn lit_by(light: u32, wanted: B, ray: ShadowRay) -> B {
    let known = is_known(taken, light);
    let unknown = wanted & !known;
    asked |= unknown;
    var lit = wanted & known & is_lit(taken, light);
    if any_ray(unknown) { lit |= unknown & !shadowed(ray, unknown); }
    return lit;
}

fn light_bits() -> U {
    return U(0u);
}
