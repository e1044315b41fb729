// A scene without lights: ambient light only.

struct ShadowRay { light: vec3f, end: F3, direction: F3, distance: F }

fn direct_light(surfaces: Surfaces, eye: vec3f) -> F3 {
    return all3(vec3f(0.0));
}
