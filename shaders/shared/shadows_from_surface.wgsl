// Shadow rays from the surface to the light, one after the other: for lights so far off that from there f32 tells the
// scene's points no longer apart.

const OFFSET_BY_LIGHT: f32 = 0.0;

var<private> shadow_rays: u32;

fn shadowed(ray: ShadowRay, wanted: B) -> B {
    shadow_rays += count_rays(wanted);
    var dark = wanted & !wanted;
    var index = 0u;
    loop {
        let one = wanted & (RAY_INDEX == U(index));
        if any_ray(one) {
            let back = Rays(of_ray3(ray.end, index), all3(-of_ray3(ray.direction, index)));
            dark |= any_hit(back, F(0.0), select(F(NEVER), ray.distance, one));
        }
        index += 1u;
        if index >= RAYS { break; }
    }
    return dark;
}
