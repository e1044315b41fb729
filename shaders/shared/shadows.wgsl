// Shadow rays.

//! use bvh, counters, lane, light, pixels, planes, primitive, primitives, rays

//! if shadows is from_light
// Shadow rays run from the light to the surface, so that a lane's rays have one origin.

// Offset of a shadow ray's end from the surface, as a share of the ray's length. It covers the rounding of the
// direction.
const OFFSET_BY_LIGHT: f32 = 1.0 / 1048576.0;

var<private> shadow_rays: u32;

// Returns the slot of each ray's occluder, or MISS.
fn occluders_of(ray: ShadowRay, wanted: B) -> U {
    shadow_rays += count_rays(wanted);
    return any_slot(Rays(ray.light, ray.direction), F(0.0), select(F(NEVER), ray.distance, wanted));
}

//! if shadows is from_light and planes is none
// Returns which rays a primitive occludes, by the same test as in traversal.
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
// Shadow rays run from the surface to the light, one ray after the other. This is for lights so far away that f32,
// relative to the light, cannot distinguish the scene's points.

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
// The offset equals that with shadows, so that lit points have the same bits.
const OFFSET_BY_LIGHT: f32 = 1.0 / 1048576.0;
const shadow_rays: u32 = 0u;

fn occluders_of(ray: ShadowRay, wanted: B) -> U {
    return U(MISS);
}

//! if shadows is from_surface or none
// Rays from the light are rounded differently from rays from the surface, so such a test proves no shadow.
fn occluded_by(slot: u32, ray: ShadowRay) -> B {
    return B(false);
}

//! end
// Returns whether a primitive occludes the ray with this index.
fn is_occluded_by(slot: u32, ray: ShadowRay, index: u32) -> bool {
    return of_ray_b(occluded_by(slot, ray), index);
}
