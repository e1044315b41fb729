// Shadow rays from the surface to the light, one after the other: for lights so far off that from there f32 tells the
// scene's points no longer apart.

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

// Rays from so far off round in another way than those from the surface: nothing is known without one.
fn is_occluded_by(slot: u32, ray: ShadowRay, index: u32) -> bool {
    return false;
}
