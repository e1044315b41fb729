// A scene without lights: ambient light only.
const shadow_rays: u32 = 0u;

fn direct_light(surface: Surface, eye: vec3f) -> vec3f {
    return vec3f(0.0);
}
