// Surfaces at the hits of a lane's rays.

//! use fetch, lane, light, materials, pixels, planes, primitives, rays, reflectance, table, textures

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
            let material = material_at(surface.material);
            let factor = texture_factor(rays, hits, surface, material.texture, ray);
            found.albedo = with_ray3(found.albedo, ray, material.albedo * factor.xyz);
            found = with_look(found, rays, hits, surface, material, factor, ray);
            found = with_sends(found, ray, surface.material);
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    found.point = add3(all3(rays.origin), times3(rays.direction, hits.t));
    return found;
}

//! if textures is none
fn texture_factor(rays: Rays, hits: Hits, surface: Surface, texture: u32, ray: u32) -> vec4f {
    return vec4f(1.0);
}

//! if textures is some and planes is none
// Returns the factor of the albedo at a hit, texture times vertex colour, and the texture's alpha.
fn texture_factor(rays: Rays, hits: Hits, surface: Surface, texture: u32, ray: u32) -> vec4f {
    let painted = vec4f(vertex_color(rays, hits, surface, ray), 1.0);
    if texture == 0u { return painted; }
    return painted * texture_color(table_texel(TEXTURES).w + texture - 1u, lookup_at(rays, hits, surface, ray));
}

//! if textures is some and planes is some
fn texture_factor(rays: Rays, hits: Hits, surface: Surface, texture: u32, ray: u32) -> vec4f {
    let painted = vec4f(vertex_color(rays, hits, surface, ray), 1.0);
    if texture == 0u { return painted; }
    let head_at = table_texel(TEXTURES).w + texture - 1u;
    if of_ray_u(hits.slot, ray) < PLANES { return plane_color(rays, hits, ray, head_at); }
    return painted * texture_color(head_at, lookup_at(rays, hits, surface, ray));
}
