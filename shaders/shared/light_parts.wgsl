// Light of pixels in parts, which are read back for denoising.

//! use paths, scattering

// Marks a pixel that shows no surface.
const NO_NORMAL: u32 = 0x80008000u;
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
    _pad: u32,
}

var<storage, read_write> light_parts: array<LightParts>;

// Returns a unit vector, folded onto a square (Meyer et al. 2010, "On Floating-Point Normal Vectors").
fn octahedral(normal: vec3f) -> u32 {
    let flat = normal.xy / (abs(normal.x) + abs(normal.y) + abs(normal.z));
    let folded = (1.0 - abs(flat.yx)) * select(vec2f(-1.0), vec2f(1.0), flat >= vec2f(0.0));
    return pack2x16snorm(select(flat, folded, normal.z < 0.0));
}

fn keep_parts(index: u32, vertex: Vertex, sum: Brought, rest: vec3f) {
    let share = 1.0 / f32(max(sum.paths, 1u));
    let is_known = sum.is_known == 1u;
    let variances = mean_variances(sum);
    let lobes = vertex.lobes;
    let is_matte = lobes.glossy == 0.0 && lobes.opacity == 1.0;
    light_parts[index] = LightParts(
        select(sum.diffuse * share, sum.diffuse, is_known),
        select(select(variances.x, sum.newest.x, is_known), NO_LIGHT, all(lobes.diffuse == vec3f(0.0))),
        sum.glossy * share,
        select(variances.y, NO_LIGHT, is_matte),
        lobes.diffuse,
        octahedral(vertex.normal),
        rest,
        vertex.point.x,
        vertex.point.y,
        vertex.point.z,
        1.0,
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
