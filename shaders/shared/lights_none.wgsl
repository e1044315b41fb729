// A scene without lights: ambient light only.
const shadow_rays: u32 = 0u;

fn direct_light(surfaces: Surfaces, eye: vec3f) -> F3 {
    return all3(vec3f(0.0));
}
