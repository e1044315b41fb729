// Light of pixels in parts, which are read back for denoising.

//! use facets, octahedral, paths, scattering

// Variance of light of a kind that a surface does not reflect.
const NO_LIGHT: f32 = -1.0;

//! if parts is kept
struct LightParts {
    diffuse: vec3f,            // mean of what paths brought for diffuse reflection, before the albedo
    diffuse_variance: f32,     // variance of that mean's brightness, or NO_LIGHT
    glossy: vec3f,             // mean of what paths brought by highlights, mirrors and glass
    glossy_variance: f32,
    albedo: vec3f,             // of diffuse reflection
    normal: u32,               // octahedral, or NO_NORMAL
    rest: vec3f,               // light that paths did not bring
    point_x: f32,              // point on the surface, in the scene's frame
    point_y: f32,
    point_z: f32,
    coverage: f32,             // share of the pixel that shows a surface
    lobe_width: f32,           // alpha of the highlight, 0 for mirrors and glass
    reflectance: vec3f,        // of highlights and mirrors at normal incidence; 1 for glass
    _pad: u32,
}

var<storage, read_write> light_parts: array<LightParts>;

fn keep_parts(index: u32, vertex: Vertex, sum: Brought, rest: vec3f) {
    let variances = mean_variances(sum);
    let lobes = vertex.lobes;
    let is_matte = lobes.glossy == 0.0 && lobes.opacity == 1.0;
    light_parts[index] = LightParts(
        mean_diffuse(sum),
        select(variances.x, NO_LIGHT, all(lobes.diffuse == vec3f(0.0))),
        mean_glossy(sum),
        select(variances.y, NO_LIGHT, is_matte),
        lobes.diffuse,
        octahedral(vertex.normal),
        rest,
        vertex.point.x,
        vertex.point.y,
        vertex.point.z,
        1.0,
        lobe_width(lobes),
        select(lobes.reflectance + lobes.coat * COAT_REFLECTANCE, vec3f(1.0), lobes.is_glass),
        0u,
    );
}

fn keep_no_parts(index: u32, rest: vec3f) {
    var parts: LightParts;
    parts.normal = NO_NORMAL;
    parts.rest = rest;
    light_parts[index] = parts;
}

//! if parts is none
fn keep_parts(index: u32, vertex: Vertex, sum: Brought, rest: vec3f) {}

fn keep_no_parts(index: u32, rest: vec3f) {}
