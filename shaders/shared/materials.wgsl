// Materials, stored in the shading table after the lights.

//! use fetch, table

// A material. If all materials of a scene are dull, only the first texel exists and the other fields are 0.
struct Material {
    albedo: vec3f,          // first texel
    texture: u32,           // the texture's number plus one, or 0; lower 24 bits of the first texel's w
    kind: u32,              // MIRROR, GLASS, or 0 if only the opacity matters; above the texture
    fresnel: bool,
    is_chosen: bool,        // whether emitting primitives of this material are chosen as light sources
    blends: bool,           // whether the texture's alpha multiplies the opacity
    specular: vec3f,        // second texel: colour of highlights, or of reflections
    exponent: f32,          // Phong's exponent n, or -1 - n for normalised highlights
    emission: vec3f,        // third texel
    opacity: f32,           // share of the background that it hides
    transmission: vec3f,    // fourth texel
    index: f32,             // index of refraction
}

const MIRROR: u32 = 1u;
const GLASS: u32 = 2u;

const MATERIAL_TEXTURE: u32 = 0x00ffffffu;

fn first_texel(material: u32) -> u32 {
    return LIGHTS + LIGHT_TEXELS * table_texel(AMBIENT).w + MATERIAL_TEXELS * material;
}

fn material_at(material: u32) -> Material {
    let first = first_texel(material);
    let albedo = table_texel(first);
    var found: Material;
    found.albedo = bitcast<vec3f>(albedo.xyz);
    found.texture = albedo.w & MATERIAL_TEXTURE;
    if MATERIAL_TEXELS > 1u {
        let specular = table_texel(first + 1u);
        let emission = table_texel(first + 2u);
        let transmission = table_texel(first + 3u);
        found.kind = (albedo.w >> 24u) & 3u;
        found.fresnel = (albedo.w & 0x04000000u) != 0u;
        found.is_chosen = (albedo.w & 0x10000000u) != 0u;
        found.blends = (albedo.w & 0x20000000u) != 0u;
        found.specular = bitcast<vec3f>(specular.xyz);
        found.exponent = bitcast<f32>(specular.w);
        found.emission = bitcast<vec3f>(emission.xyz);
        found.opacity = bitcast<f32>(emission.w);
        found.transmission = bitcast<vec3f>(transmission.xyz);
        found.index = bitcast<f32>(transmission.w);
    }
    return found;
}

// Returns the share of the background that a surface hides. `alpha` is its texture's.
fn opacity_of(material: Material, alpha: f32) -> f32 {
    return material.opacity * select(1.0, alpha, material.blends);
}

// Returns the exponent of a highlight, normalised or not.
fn phong_exponent(exponent: f32) -> f32 { return select(exponent, -1.0 - exponent, exponent < 0.0); }

//! if mirrors is listed or followed
// Returns whether the material sends rays on: it is a mirror, glass or a veil (partly transparent).
fn sends_rays(material: u32) -> bool {
    return (table_texel(first_texel(material)).w & 0x0f000000u) != 0u;
}

//! if principled is some
// A physically based surface, which has six more texels, or seven if some material of the scene has a clear coat.
// Textures are numbers plus one, or 0.
struct Principled {
    base: vec3f,                  // fifth texel
    is_there: bool,
    is_thin: bool,
    emission: vec3f,              // sixth texel
    emission_texture: u32,
    metallic: f32,                // seventh texel
    roughness: f32,
    index: f32,
    roughness_texture: u32,       // its green
    metallic_texture: u32,        // its blue; above the flags of the fifth texel
    grazing: f32,                 // eighth texel: reflectance of a dielectric at grazing angles
    normal_texture: u32,
    transmission_texture: u32,    // its red
    absorption: vec3f,            // ninth texel
    normal_scale: f32,
    transmission: f32,            // tenth texel
    specular: vec3f,
}

fn principled_at(material: u32) -> Principled {
    let first = first_texel(material) + 4u;
    let base = table_texel(first);
    let emission = table_texel(first + 1u);
    let shape = table_texel(first + 2u);
    let edge = table_texel(first + 3u);
    let absorption = table_texel(first + 4u);
    let specular = table_texel(first + 5u);
    var found: Principled;
    found.base = bitcast<vec3f>(base.xyz);
    found.is_there = (base.w & 1u) != 0u;
    found.is_thin = (base.w & 2u) != 0u;
    found.emission = bitcast<vec3f>(emission.xyz);
    found.emission_texture = emission.w;
    found.metallic = bitcast<f32>(shape.x);
    found.roughness = bitcast<f32>(shape.y);
    found.index = bitcast<f32>(shape.z);
    found.roughness_texture = shape.w;
    found.metallic_texture = base.w >> 8u;
    found.grazing = bitcast<f32>(edge.x);
    found.transmission_texture = edge.y;
    found.normal_texture = edge.w;
    found.absorption = bitcast<vec3f>(absorption.xyz);
    found.normal_scale = bitcast<f32>(absorption.w);
    found.specular = bitcast<vec3f>(specular.xyz);
    found.transmission = bitcast<f32>(specular.w);
    return found;
}

//! if coats is some
// A clear coat: the eleventh texel.
struct Coat {
    share: f32,
    roughness: f32,
    texture: u32,              // its red multiplies the share
    roughness_texture: u32,    // its green
}

fn coat_at(material: u32) -> Coat {
    let found = table_texel(first_texel(material) + 10u);
    return Coat(bitcast<f32>(found.x), bitcast<f32>(found.y), found.z, found.w);
}
