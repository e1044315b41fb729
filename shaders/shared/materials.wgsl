// What a surface is made of: its texels of the shading table, behind the lights'.

// Texels of a material: albedo, and one more than its texture's number; then specular colour and Phong's exponent; then what it gives
// off, and its finish; then what it lets through, and its index of refraction. Where all are dull and untextured, the first alone.
const MATERIAL_ALBEDO: u32 = 0u;
const MATERIAL_SPECULAR: u32 = 1u;
const MATERIAL_EMISSION: u32 = 2u;

fn material_texel(material: u32, texel: u32) -> vec4u {
    return table_texel(LIGHTS + 2u * table_texel(AMBIENT).w + MATERIAL_TEXELS * material + texel);
}

//! if shine is none
fn with_shine(surfaces: Surfaces, ray: u32, material: u32) -> Surfaces {
    return surfaces;
}

fn highlight(surfaces: Surfaces, from_light: F3, eye: vec3f) -> F3 {
    return all3(vec3f(0.0));
}

//! if shine is some
// The same with what it shines and gives off.
fn with_shine(surfaces: Surfaces, ray: u32, material: u32) -> Surfaces {
    let specular = material_texel(material, MATERIAL_SPECULAR);
    let emission = material_texel(material, MATERIAL_EMISSION);
    var shining = surfaces;
    shining.specular = with_ray3(surfaces.specular, ray, bitcast<vec3f>(specular.xyz));
    shining.exponent = with_ray(surfaces.exponent, ray, bitcast<f32>(specular.w));
    shining.emission = with_ray3(surfaces.emission, ray, bitcast<vec3f>(emission.xyz));
    return shining;
}

// Phong's highlight of a light, as MTL has it: what its mirrored ray sends to the eye. Directions from the light are of length 1.
fn highlight(surfaces: Surfaces, from_light: F3, eye: vec3f) -> F3 {
    let to_eye = minus3(all3(eye), surfaces.point);
    let mirrored = minus3(from_light, times3(surfaces.shading_normal, 2.0 * dot3(surfaces.shading_normal, from_light)));
    let cosine = dot3(mirrored, to_eye) / sqrt(dot3(to_eye, to_eye));
    // pow of 0 is left open where the exponent is 0 too.
    return times3(surfaces.specular, select(F(0.0), pow(max(cosine, F(1e-30)), surfaces.exponent), cosine > F(0.0)));
}
