// Shading (DESIGN, section 3): c = albedo (ambient + sum of I max(0, n.l) V) + emission + sum of I V of highlights. The
// result is linear. Exposure and clamping are applied when pictures are written.

//! use bvh, lane, light, lights, pixels, planes, rays, shadow_buffer, sky, soft, surfaces, visibility

// Traces and shades primary rays from an eye. Unwanted rays get the sky's colour.
fn trace_pixels(rays: Rays, wanted: B) -> Samples {
    let hits = closest_hit(rays, F(0.0), select(F(NEVER), F(FAR), wanted));
    return shade(rays, hits, surfaces_at(rays, hits));
}

fn shade(rays: Rays, hits: Hits, surfaces: Surfaces) -> Samples {
    let color = radiance(rays, hits, surfaces);
    let depth = select(F(FAR), hits.t, surfaces.there);
    let slots = select(U(MISS), hits.slot, surfaces.there);
    return Samples(color, depth, slots, surfaces.component, light_bits());
}

// Returns the light along rays from their hits, in linear colour without an upper limit.
fn radiance(rays: Rays, hits: Hits, surfaces: Surfaces) -> F3 {
    return radiance_in(rays, surfaces, light_from(rays.origin, surfaces));
}

// Returns the direct light at surfaces that are seen from a point.
fn light_from(eye: vec3f, surfaces: Surfaces) -> Light {
    ask_tables(surfaces);
    return direct_light(surfaces, eye);
}

// Returns the light along rays to surfaces in this direct light, like `radiance`.
fn radiance_in(rays: Rays, surfaces: Surfaces, light: Light) -> F3 {
    var color = product3(surfaces.albedo, add3(all3(ambient_light()), light.diffuse));
    if SHINE { color = add3(color, add3(surfaces.emission, light.shine)); }
    return select3(sky(rays.direction), color, surfaces.there);
}

//! if light is direct
fn ambient_light() -> vec3f { return open_ambient(); }

//! if light is paths
// Paths bring the light that ambient light stands for.
fn ambient_light() -> vec3f { return vec3f(0.0); }
