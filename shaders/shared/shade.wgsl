// Shading (DESIGN, section 3): c = albedo (ambient + sum of I max(0, n.l) V) + emission + sum of I V of highlights. The
// result is linear. Pictures expose and clamp it.

// Layout of the shading table, in vectors with floats' bits in x, y and z. It is no uniform: Mesa's software driver
// compiles a kernel anew for each dispatch in which a loop's end is a uniform.
const AMBIENT: u32 = 0u;      // linear RGB; the number of lights in w
// Linear RGB straight down. For a map: first texel, width, height. In w the first of the textures' heads.
const SKY_NADIR: u32 = 1u;
const SKY_ZENITH: u32 = 2u;   // linear RGB straight up, or everywhere
// LIGHT_TEXELS each: position and kind, intensity and size, two sides for some kinds. The materials follow
// (materials.wgsl), then a map's pixels, then textures (textures.wgsl).
const LIGHTS: u32 = 3u;

fn shading_vector(index: u32) -> vec3f {
    return bitcast<vec3f>(table_texel(index).xyz);
}

// Colours and hits that a lane's primary rays found.
struct Samples {
    color: F3,
    depth: F,
    slot: U,
    component: U,
    bits: U,      // of lights (visibility.wgsl)
}

// Returns the stored pixel of one ray, without marks.
fn pixel_of(samples: Samples, packed: U, ray: u32) -> Pixel {
    return Pixel(of_ray(samples.depth, ray), of_ray_u(samples.slot, ray), 0u, of_ray_u(packed, ray));
}

// Surfaces at the hits of a lane's rays, as lighting needs them. Rays that miss have zeros.
struct Surfaces {
    there: B,
    point: F3,
    geometric_normal: F3,   // unit, towards the viewer
    shading_normal: F3,     // unit, on the geometric normal's side
    albedo: F3,
    component: U,
    reach: F,               // of triangles: at least the longest edge
    specular: F3,
    exponent: F,
    emission: F3,
    sends: U,               // 1 for mirrors, glass and veils, which are shaded later
}

// Traces and shades primary rays from an eye. Rays that are not wanted see the sky.
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
    ask_tables(surfaces);
    let light = direct_light(surfaces, rays.origin);
    var color = product3(surfaces.albedo, add3(all3(open_ambient()), light.diffuse));
    if SHINE { color = add3(color, add3(surfaces.emission, light.shine)); }
    return select3(sky(rays.direction), color, surfaces.there);
}

// Fetches normals and albedos, once per hit.
fn surfaces_at(rays: Rays, hits: Hits) -> Surfaces {
    let there = hits.primitive != U(MISS);
    var found: Surfaces;
    found.there = there;
    var ray = 0u;
    loop {
        if of_ray_b(there, ray) {
            let surface = surface_at(rays, hits, ray);
            found.geometric_normal = with_ray3(found.geometric_normal, ray, surface.geometric_normal);
            found.shading_normal = with_ray3(found.shading_normal, ray, surface.shading_normal);
            found.component = with_ray_u(found.component, ray, surface.component);
            found.reach = with_ray(found.reach, ray, surface.reach);
            let albedo = bitcast<vec3f>(material_texel(surface.material, MATERIAL_ALBEDO).xyz);
            found.albedo = with_ray3(found.albedo, ray, albedo * texture_factor(rays, hits, surface, ray));
            found = with_shine(found, ray, surface.material);
            found = with_sends(found, ray, surface.material);
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    found.point = add3(all3(rays.origin), times3(rays.direction, hits.t));
    return found;
}
