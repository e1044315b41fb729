// Shadow rays from the light to the surface: a lane's have one origin, which is what its traversal wants.

// A shadow ray ends off the surface by this share of its length besides: the rounding of a direction so long.
const OFFSET_BY_LIGHT: f32 = 1.0 / 1048576.0;

var<private> shadow_rays: u32;

// What stands in the way, by its place among the primitives; MISS where nothing does.
fn occluders_of(ray: ShadowRay, wanted: B) -> U {
    shadow_rays += count_rays(wanted);
    return any_slot(Rays(ray.light, ray.direction), F(0.0), select(F(NEVER), ray.distance, wanted));
}

// Whether a primitive stands in the way of one of the rays, as traversal would find it.
fn is_occluded_by(slot: u32, ray: ShadowRay, index: u32) -> bool {
    if COUNT { primitives_tested += 1u; }
    let rays = Rays(ray.light, ray.direction);
    let found = intersect(primitive_at(slot), rays, scales_of(rays), F(0.0));
    return of_ray_b(found.hit & (found.t >= F(0.0)) & (found.t <= ray.distance), index);
}
