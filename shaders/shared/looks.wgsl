// The look of surfaces to paths: their lobes, with textures.

//! use facets, fetch, lane, materials, octahedral, planes, rays, table, textures, triangle

//! if light is paths
struct Look {
    normal: vec3f,      // unit, for shading
    emission: vec3f,
    left: vec3f,        // share of light per world unit that the inside lets pass, if the viewer is inside
    lobes: Lobes,
}

//! if light is paths and principled is none
// `factor` is the colour of the material's texture and of the corners, and the texture's alpha.
fn look_at(rays: Rays, hits: Hits, surface: Surface, material: Material, factor: vec4f, ray: u32) -> Look {
    return plain_look(rays, surface, material, factor, ray);
}

//! if light is paths
fn plain_look(rays: Rays, surface: Surface, material: Material, factor: vec4f, ray: u32) -> Look {
    let facing = -dot(surface.shading_normal, normalize(of_ray3(rays.direction, ray)));
    var lobes = lobes_of(material, material.albedo * factor.xyz, facing);
    if material.blends { lobes.opacity = opacity_of(material, factor.w); }
    return Look(surface.shading_normal, material.emission, vec3f(1.0), lobes);
}

//! if light is paths and principled is some
fn look_at(rays: Rays, hits: Hits, surface: Surface, material: Material, factor: vec4f, ray: u32) -> Look {
    let principled = principled_at(surface.material);
    if !principled.is_there { return plain_look(rays, surface, material, factor, ray); }
    let to_viewer = -normalize(of_ray3(rays.direction, ray));
    let base = principled.base * factor.xyz;
    var shape = map_color(rays, hits, surface, principled.roughness_texture, ray);
    let roughness = principled.roughness * shape.y;
    if principled.metallic_texture != principled.roughness_texture {
        shape = map_color(rays, hits, surface, principled.metallic_texture, ray);
    }
    let metallic = principled.metallic * shape.z;
    var look = Look(surface.shading_normal, principled.emission, vec3f(1.0), Lobes());
    if principled.normal_texture != 0u {
        look.normal = mapped_normal(rays, hits, surface, principled, to_viewer, ray);
    }
    look.emission *= map_color(rays, hits, surface, principled.emission_texture, ray);
    let transmission = principled.transmission * map_color(rays, hits, surface, principled.transmission_texture, ray).x;
    let clear = transmission * (1.0 - metallic);
    look.lobes.opacity = opacity_of(material, factor.w);
    look.lobes.diffuse = base * ((1.0 - metallic) * (1.0 - transmission));
    let facing = clamp(dot(look.normal, to_viewer), 0.0, 1.0);
    let alpha = roughness * roughness;
    if clear > 0.0 {
        look.lobes.opacity = 1.0;
        look.lobes.is_glass = true;
        look.lobes.is_fresnel = true;
        look.lobes.is_thin = principled.is_thin;
        look.lobes.reflectance = principled.specular;
        look.lobes.alpha = alpha;
        look.lobes.transmission = base * clear;
        look.lobes.index = principled.index;
        let enters = surface.from_outside || principled.is_thin;
        let eta = select(principled.index, 1.0 / principled.index, enters);
        look.lobes.diffuse *= 1.0 - principled.specular * glass_share(eta, facing);
        look.lobes.glossy = 1.0;
        if !surface.from_outside && !principled.is_thin { look.left = exp(-principled.absorption); }
    } else {
        let at_normal = (principled.index - 1.0) / (principled.index + 1.0);
        let dielectric = at_normal * at_normal * principled.specular;
        look.lobes = with_highlights(look.lobes, dielectric, principled.grazing, base, metallic, alpha, facing);
    }
    return coated(look, rays, hits, surface, to_viewer, ray);
}

//! if light is paths and principled is some and coats is none
fn coated(look: Look, rays: Rays, hits: Hits, surface: Surface, to_viewer: vec3f, ray: u32) -> Look { return look; }

//! if light is paths and principled is some and coats is some
// Adds a surface's clear coat, which also covers what emits light.
fn coated(bare: Look, rays: Rays, hits: Hits, surface: Surface, to_viewer: vec3f, ray: u32) -> Look {
    let coat = coat_at(surface.material);
    if coat.share <= 0.0 { return bare; }
    let share = coat.share * map_color(rays, hits, surface, coat.texture, ray).x;
    let roughness = coat.roughness * map_color(rays, hits, surface, coat.roughness_texture, ray).y;
    var look = bare;
    look.lobes = with_coat(bare.lobes, share, roughness * roughness, surface.shading_normal, to_viewer);
    look.emission *= 1.0 - look.lobes.coat_chance * look.lobes.glossy;
    return look;
}

//! if light is paths and principled is some and textures is none
fn map_color(rays: Rays, hits: Hits, surface: Surface, texture: u32, ray: u32) -> vec3f { return vec3f(1.0); }

//! if light is paths and principled is some and textures is some and planes is none
// Returns a texture's colour, or 1 without one.
fn map_color(rays: Rays, hits: Hits, surface: Surface, texture: u32, ray: u32) -> vec3f {
    if texture == 0u { return vec3f(1.0); }
    return texture_color(table_texel(TEXTURES).w + texture - 1u, lookup_at(rays, hits, surface, ray)).xyz;
}

//! if light is paths and principled is some and textures is some and planes is some
fn map_color(rays: Rays, hits: Hits, surface: Surface, texture: u32, ray: u32) -> vec3f {
    if texture == 0u { return vec3f(1.0); }
    let head_at = table_texel(TEXTURES).w + texture - 1u;
    if of_ray_u(hits.slot, ray) < PLANES { return plane_color(rays, hits, ray, head_at).xyz; }
    return texture_color(head_at, lookup_at(rays, hits, surface, ray)).xyz;
}

//! if light is paths and principled is some and textures is none
fn mapped_normal(rays: Rays, hits: Hits, surface: Surface, of_map: Principled, to_viewer: vec3f, ray: u32) -> vec3f {
    return surface.shading_normal;
}

//! if light is paths and principled is some and textures is some
// Returns a normal from a texture in tangent space.
fn mapped_normal(rays: Rays, hits: Hits, surface: Surface, of_map: Principled, to_viewer: vec3f, ray: u32) -> vec3f {
    if surface.reach == 0.0 { return surface.shading_normal; }
    let side = select(-1.0, 1.0, surface.from_outside);
    let normal = surface.shading_normal * side;
    let sides = tangents_at(rays, of_ray_u(hits.slot, ray), normal, ray);
    if !sides.are_there { return surface.shading_normal; }
    let texel = map_color(rays, hits, surface, of_map.normal_texture, ray) * 2.0 - 1.0;
    let slope = texel.xy * of_map.normal_scale;
    var mapped = normalize(sides.along_u * slope.x + sides.along_v * slope.y + normal * max(texel.z, 1e-3)) * side;
    // A normal that faces away from the viewer is turned just towards it.
    let facing = dot(mapped, to_viewer);
    if facing < 1e-2 { mapped = normalize(mapped + to_viewer * (1e-2 - facing)); }
    return mapped;
}

// Unit vectors across a normal, towards growing u and v.
struct TangentPair {
    along_u: vec3f,
    along_v: vec3f,
    are_there: bool,
}

fn tangents_at(rays: Rays, slot: u32, normal: vec3f, ray: u32) -> TangentPair {
    let corners = triangle_corners(slot);
    let words = corner_tangents(slot);
    var pair: TangentPair;
    var tangent = vec3f(0.0);
    var sign_of_v = 1.0;
    if words.y != 0u {
        let weights = corner_weights(rays, corners, ray);
        let a = corner_tangent(words.x, words.x >> 10u);
        let b = corner_tangent(words.x >> 20u, words.y);
        let c = corner_tangent(words.y >> 10u, words.y >> 20u);
        tangent = a * weights.x + b * weights.y + c * weights.z;
        sign_of_v = select(1.0, -1.0, (words.x & 0x40000000u) != 0u);
    } else {
        // The tangents of the triangle's texture coordinates.
        let uv = triangle_uv(slot);
        let e = largest_one(corners[1] - corners[0]);
        let f = (corners[2] - corners[0]) * (length(e) / max(length(corners[1] - corners[0]), 1e-30));
        let a = uv[1] - uv[0];
        let b = uv[2] - uv[0];
        let turned = sign(a.x * b.y - b.x * a.y);
        tangent = (e * b.y - f * a.y) * turned;
        sign_of_v = sign(dot(cross(normal, tangent), (f * a.x - e * b.x) * turned));
    }
    tangent -= normal * dot(normal, tangent);
    let squared = dot(tangent, tangent);
    if !(squared > 0.0) { return pair; }
    pair.along_u = tangent * inverseSqrt(squared);
    pair.along_v = cross(normal, pair.along_u) * sign_of_v;
    pair.are_there = true;
    return pair;
}

// Unpacks a corner's tangent from the lower 10 bits of two words (pack_tangents in src/accel/bvh/primitive.rs).
fn corner_tangent(x: u32, y: u32) -> vec3f {
    return from_octahedron(vec2f(vec2u(x, y) & vec2u(1023u)) / 511.0 - 1.0);
}

//! if light is paths and principled is some and textures is some and uv is none
fn corner_tangents(slot: u32) -> vec2u { return vec2u(0u); }

//! if light is paths and principled is some and textures is some and uv is some
fn corner_tangents(slot: u32) -> vec2u { return primitive_texel(slot, UV_TEXEL + 1u).zw; }
