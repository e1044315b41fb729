// Whether a light is seen from the points that a lane's rays hit.

//! if visibility is traced
// By a shadow ray, always. What it found is kept for the other eye where a method asks for it.

// The list of pixels that shade_listed shades so.
const TO_SHADE: u32 = TO_TRACE;

fn ask_source(pixels: Pixels, hits: Hits, surfaces: Surfaces) {}

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

//! if visibility is taken
// As the left view's samples say. Where they don't agree, the pixel is put off.

var<private> put_off: B;

fn lit_by(light: u32, wanted: B, ray: ShadowRay) -> B {
    let known = is_known(taken, light);
    put_off |= wanted & !known;
    return wanted & known & is_lit(taken, light);
}

fn light_bits() -> U {
    return U(0u);
}

//! if visibility is taken_or_traced
// As the left view's samples say; where they don't agree, what hides a light from one of them is tried before a shadow ray is
// traced: if that is met, it is proof.

const TO_SHADE: u32 = TO_LIGHT;

fn lit_by(light: u32, wanted: B, ray: ShadowRay) -> B {
    let known = is_known(taken, light);
    let unknown = wanted & !known;
    var lit = wanted & known & is_lit(taken, light);
    if any_ray(unknown) {
        var open = unknown;
        if KEEP_OCCLUDERS { open &= !hidden_likewise(unknown, ray); }
        if any_ray(open) { lit |= open & (occluders_of(ray, open) == U(MISS)); }
    }
    return lit;
}

fn light_bits() -> U {
    return U(0u);
}

// Which rays meet what hides some light from one of the left samples beside their points.
fn hidden_likewise(unknown: B, ray: ShadowRay) -> B {
    var hidden: U;
    var index = 0u;
    loop {
        let a = of_ray_u(taken.occluders_a, index);
        let b = of_ray_u(taken.occluders_b, index);
        if of_ray_b(unknown, index) {
            if a != MISS && is_occluded_by(a, ray, index) { hidden = with_ray_u(hidden, index, 1u); }
            if b != MISS && b != a && is_occluded_by(b, ray, index) { hidden = with_ray_u(hidden, index, 1u); }
        }
        index += 1u;
        if index >= RAYS { break; }
    }
    return hidden == U(1u);
}

//! if visibility is taken or taken_or_traced
var<private> taken: Taken;

// What the source's samples say of these points.
fn ask_source(pixels: Pixels, hits: Hits, surfaces: Surfaces) {
    taken = taken_bits(pixels, hits, surfaces);
}
