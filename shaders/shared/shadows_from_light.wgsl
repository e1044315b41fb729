// Shadow rays from the light to the surface: a lane's have one origin, which is what its traversal wants.

// A shadow ray ends off the surface by this share of its length besides: the rounding of a direction so long.
const OFFSET_BY_LIGHT: f32 = 1.0 / 1048576.0;

var<private> shadow_rays: u32;

fn shadowed(ray: ShadowRay, wanted: B) -> B {
    shadow_rays += count_rays(wanted);
    return any_hit(Rays(ray.light, ray.direction), F(0.0), select(F(NEVER), ray.distance, wanted));
}
