// Shadow rays from the surface to the light, one after the other: for lights so far off that from there f32 tells the
// scene's points no longer apart.

const OFFSET_BY_LIGHT: f32 = 0.0;

var<private> shadow_rays: u32;

fn shadowed(light: vec3f, end: F3, direction: F3, distance: F, wanted: B) -> B {
    shadow_rays += count_rays(wanted);
    var dark = wanted & !wanted;
    var ray = 0u;
    loop {
        let one = wanted & (RAY_INDEX == U(ray));
        if any_ray(one) {
            let back = Rays(of_ray3(end, ray), all3(-of_ray3(direction, ray)));
            dark |= any_hit(back, F(0.0), select(F(NEVER), distance, one));
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return dark;
}
