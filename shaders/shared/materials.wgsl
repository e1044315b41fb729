// Materials, stored in the shading table after the lights.

//! use aims, fetch, lane, light, table

// Texels of a material. The first has the albedo; its w has the texture's number plus one in the lower 24 bits and the
// finish above. The second has the specular colour and Phong's exponent n, or -1 - n for normalised highlights. The
// third has emission and opacity, the fourth transmission and the index of refraction. If all materials are dull, only
// the first texel exists.
const MATERIAL_ALBEDO: u32 = 0u;
const MATERIAL_SPECULAR: u32 = 1u;
const MATERIAL_EMISSION: u32 = 2u;
const MATERIAL_TRANSMISSION: u32 = 3u;
const MATERIAL_TEXTURE: u32 = 0x00ffffffu;

fn material_texel(material: u32, texel: u32) -> vec4u {
    return table_texel(LIGHTS + LIGHT_TEXELS * table_texel(AMBIENT).w + MATERIAL_TEXELS * material + texel);
}

//! if shine is none
fn with_shine(surfaces: Surfaces, ray: u32, material: u32) -> Surfaces {
    return surfaces;
}

fn highlight(surfaces: Surfaces, from_light: F3, eye: vec3f) -> F3 {
    return all3(vec3f(0.0));
}

//! if shine is some
// Adds specular colour, exponent and emission to a surface.
fn with_shine(surfaces: Surfaces, ray: u32, material: u32) -> Surfaces {
    let specular = material_texel(material, MATERIAL_SPECULAR);
    let emission = material_texel(material, MATERIAL_EMISSION);
    var shining = surfaces;
    shining.specular = with_ray3(surfaces.specular, ray, bitcast<vec3f>(specular.xyz));
    shining.exponent = with_ray(surfaces.exponent, ray, bitcast<f32>(specular.w));
    shining.emission = with_ray3(surfaces.emission, ray, bitcast<vec3f>(emission.xyz));
    return shining;
}

// Returns Phong's highlight of a light, as MTL defines it. Directions from the light are unit vectors.
fn highlight(surfaces: Surfaces, from_light: F3, eye: vec3f) -> F3 {
    let to_eye = minus3(all3(eye), surfaces.point);
    let mirrored = minus3(from_light, times3(surfaces.shading_normal, 2.0 * dot3(surfaces.shading_normal, from_light)));
    let cosine = dot3(mirrored, to_eye) / sqrt(dot3(to_eye, to_eye));
    // pow(0, 0) is undefined.
    return times3(surfaces.specular, select(F(0.0), pow(max(cosine, F(1e-30)), surfaces.exponent), cosine > F(0.0)));
}

//! if shine is none or some
// Returns the highlights of light along four rays, like `highlight`.
fn four_highlights(rays: Four, aim: Aim, surfaces: Surfaces, eye: vec3f, ray: u32) -> vec4f {
    let to_eye = normalize(eye - of_ray3(surfaces.point, ray));
    let n = aim.shading_normal;
    // Mirrors the direction to the light about the normal. The cosine is the same as in `highlight`.
    let cosine = rays.x * n.x + rays.y * n.y + rays.z * n.z;
    let back = rays.x * to_eye.x + rays.y * to_eye.y + rays.z * to_eye.z;
    let mirrored = 2.0 * cosine * dot(n, to_eye) - back;
    let lit = rays.wanted & (mirrored > vec4f(0.0));
    return select(vec4f(0.0), pow(max(mirrored, vec4f(1e-30)), vec4f(of_ray(surfaces.exponent, ray))), lit);
}

//! if shine is normalised
// As above, for scenes in which some highlights are normalised: those with a negative exponent. Their colour is scaled
// so that the whole lobe reflects its share of the incoming light (Lafortune & Willems 1994).
fn with_shine(surfaces: Surfaces, ray: u32, material: u32) -> Surfaces {
    let specular = material_texel(material, MATERIAL_SPECULAR);
    let emission = material_texel(material, MATERIAL_EMISSION);
    let exponent = bitcast<f32>(specular.w);
    let scale = select(1.0, 0.5 * (phong_exponent(exponent) + 2.0), exponent < 0.0);
    var shining = surfaces;
    shining.specular = with_ray3(surfaces.specular, ray, bitcast<vec3f>(specular.xyz) * scale);
    shining.exponent = with_ray(surfaces.exponent, ray, exponent);
    shining.emission = with_ray3(surfaces.emission, ray, bitcast<vec3f>(emission.xyz));
    return shining;
}

fn phong_exponent(exponent: f32) -> f32 { return select(exponent, -1.0 - exponent, exponent < 0.0); }

fn highlight(surfaces: Surfaces, from_light: F3, eye: vec3f) -> F3 {
    let to_eye = minus3(all3(eye), surfaces.point);
    let facing = -dot3(surfaces.shading_normal, from_light);
    let mirrored = add3(from_light, times3(surfaces.shading_normal, 2.0 * facing));
    let cosine = dot3(mirrored, to_eye) / sqrt(dot3(to_eye, to_eye));
    let normalised = surfaces.exponent < F(0.0);
    let lobe = pow(max(cosine, F(1e-30)), select(surfaces.exponent, -1.0 - surfaces.exponent, normalised));
    let seen = select(lobe, lobe * max(facing, F(0.0)), normalised);
    return times3(surfaces.specular, select(F(0.0), seen, cosine > F(0.0)));
}

// Returns the highlights of light along four rays, like `highlight`.
fn four_highlights(rays: Four, aim: Aim, surfaces: Surfaces, eye: vec3f, ray: u32) -> vec4f {
    let to_eye = normalize(eye - of_ray3(surfaces.point, ray));
    let n = aim.shading_normal;
    // Mirrors the direction to the light about the normal. The cosine is the same as in `highlight`.
    let cosine = rays.x * n.x + rays.y * n.y + rays.z * n.z;
    let back = rays.x * to_eye.x + rays.y * to_eye.y + rays.z * to_eye.z;
    let mirrored = 2.0 * cosine * dot(n, to_eye) - back;
    let lit = rays.wanted & (mirrored > vec4f(0.0));
    let exponent = of_ray(surfaces.exponent, ray);
    let lobe = pow(max(mirrored, vec4f(1e-30)), vec4f(phong_exponent(exponent)));
    return select(vec4f(0.0), select(lobe, lobe * cosine, exponent < 0.0), lit);
}

//! if mirrors is none
fn with_sends(surfaces: Surfaces, ray: u32, material: u32) -> Surfaces {
    return surfaces;
}

//! if mirrors is listed
fn with_sends(surfaces: Surfaces, ray: u32, material: u32) -> Surfaces {
    var sending = surfaces;
    sending.sends = with_ray_u(surfaces.sends, ray, select(0u, 1u, sends_rays(material)));
    return sending;
}

//! if mirrors is followed
fn with_sends(surfaces: Surfaces, ray: u32, material: u32) -> Surfaces {
    return surfaces;
}

//! if mirrors is none or followed
// Returns whether this kernel computes the light of these surfaces.
fn is_lit_here(surfaces: Surfaces) -> B {
    return surfaces.there;
}

//! if mirrors is listed
// trace_mirrored computes the light of mirrors, glass and veils (partly transparent surfaces).
fn is_lit_here(surfaces: Surfaces) -> B {
    return surfaces.there & (surfaces.sends == U(0u));
}

//! if mirrors is listed or followed
// Returns whether the material sends rays on, by reflection or transmission.
fn sends_rays(material: u32) -> bool {
    return material_texel(material, MATERIAL_ALBEDO).w > MATERIAL_TEXTURE;
}

const MIRROR: u32 = 1u;
const GLASS: u32 = 2u;

// How a surface reflects and transmits rays.
struct Finish {
    kind: u32,            // MIRROR, GLASS, or 0 if only the opacity matters
    fresnel: bool,
    opacity: f32,         // share of the background that it hides
    reflected: vec3f,
    transmission: vec3f,
    index: f32,           // index of refraction
}

fn finish_of(material: u32) -> Finish {
    let word = material_texel(material, MATERIAL_ALBEDO).w >> 24u;
    let through = material_texel(material, MATERIAL_TRANSMISSION);
    return Finish(
        word & 3u,
        (word & 4u) != 0u,
        bitcast<f32>(material_texel(material, MATERIAL_EMISSION).w),
        bitcast<vec3f>(material_texel(material, MATERIAL_SPECULAR).xyz),
        bitcast<vec3f>(through.xyz),
        bitcast<f32>(through.w),
    );
}
