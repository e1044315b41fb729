// Shadow rays.

//! if shadows is from_light
// From the light to the surface: a lane's have one origin, which is what its traversal wants.

// A shadow ray ends off the surface by this share of its length besides: the rounding of a direction so long.
const OFFSET_BY_LIGHT: f32 = 1.0 / 1048576.0;

var<private> shadow_rays: u32;

// What stands in the way, by its place among the primitives; MISS where nothing does.
fn occluders_of(ray: ShadowRay, wanted: B) -> U {
    shadow_rays += count_rays(wanted);
    return any_slot(Rays(ray.light, ray.direction), F(0.0), select(F(NEVER), ray.distance, wanted));
}

//! if shadows is from_light and planes is none
// Of which rays a primitive stands in the way, as traversal would find it.
fn occluded_by(slot: u32, ray: ShadowRay) -> B {
    if COUNT { primitives_tested += 1u; }
    let rays = Rays(ray.light, ray.direction);
    let found = intersect(primitive_at(slot), rays, scales_of(rays), F(0.0));
    return found.hit & (found.t >= F(0.0)) & (found.t <= ray.distance);
}

//! if shadows is from_light and planes is some
fn occluded_by(slot: u32, ray: ShadowRay) -> B {
    if COUNT { primitives_tested += 1u; }
    let found = met_at(slot, Rays(ray.light, ray.direction));
    return found.hit & (found.t >= F(0.0)) & (found.t <= ray.distance);
}

//! if shadows is from_surface
// From the surface to the light, one after the other: for lights so far off that from there f32 tells the scene's
// points no longer apart.

const OFFSET_BY_LIGHT: f32 = 0.0;

var<private> shadow_rays: u32;

fn occluders_of(ray: ShadowRay, wanted: B) -> U {
    shadow_rays += count_rays(wanted);
    var occluders = U(MISS);
    var index = 0u;
    loop {
        let one = wanted & (RAY_INDEX == U(index));
        if any_ray(one) {
            let back = Rays(of_ray3(ray.end, index), all3(-of_ray3(ray.direction, index)));
            occluders = select(occluders, any_slot(back, F(0.0), select(F(NEVER), ray.distance, one)), one);
        }
        index += 1u;
        if index >= RAYS { break; }
    }
    return occluders;
}

//! if shadows is none
// As with shadows, so that what is lit is lit to the same bit.
const OFFSET_BY_LIGHT: f32 = 1.0 / 1048576.0;
const shadow_rays: u32 = 0u;

fn occluders_of(ray: ShadowRay, wanted: B) -> U {
    return U(MISS);
}

//! if shadows is from_surface or none
// Rays from far off round in another way than those from the surface: nothing is known without one.
fn occluded_by(slot: u32, ray: ShadowRay) -> B {
    return B(false);
}

//! end
// Whether it stands in the way of one of them.
fn is_occluded_by(slot: u32, ray: ShadowRay, index: u32) -> bool {
    return of_ray_b(occluded_by(slot, ray), index);
}
