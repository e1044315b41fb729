// Noisy light of a strip of a picture, and the surfaces that its pixels show, for denoising.

//! use display, frame, octahedral

struct Noisy {
    diffuse: vec3f,
    diffuse_variance: f32,
    glossy: vec3f,
    glossy_variance: f32,
}

struct Guide {
    point: vec3f,   // in the scene's frame
    normal: u32,    // octahedral, or NO_NORMAL where the pixel shows no surface
    lobe_width: f32,
    _pad: array<u32, 3>,
}

var<storage, read> guides: array<Guide>;
var<storage, read> noisy_light: array<Noisy>;
var<storage, read_write> smooth_light: array<Noisy>;

// Exponents of the cosine between two pixels' normals. Highlights depend more on them.
const DIFFUSE_NORMALS: f32 = 64.0;
const GLOSSY_NORMALS: f32 = 128.0;
// Slope between two pixels' points and the plane of one of them at which their weight falls to 1/e.
const SLOPE: f32 = 0.1;

// Alpha from which a highlight is as smooth as diffuse light.
const SMOOTH_WIDTH: f32 = 0.25;

// Returned for places outside the strip.
const NOWHERE: u32 = 0xffffffffu;

// Returns the index of the pixel at an offset from another, or NOWHERE.
fn index_beside(pixel: vec2u, offset: vec2i) -> u32 {
    let place = vec2i(pixel) + offset;
    if any(place < vec2i(0)) || any(place >= vec2i(frame.band.size)) { return NOWHERE; }
    return u32(place.y) * frame.band.size.x + u32(place.x);
}

// Pairs below are of diffuse and of glossy light.

fn brightness_of(light: Noisy) -> vec2f { return vec2f(luminance(light.diffuse), luminance(light.glossy)); }

// Returns the variances, 0 for light that the surface does not reflect.
fn variances_of(light: Noisy) -> vec2f {
    return max(vec2f(light.diffuse_variance, light.glossy_variance), vec2f(0.0));
}

// Returns 1 for the kinds of light, diffuse and glossy, that a pixel's surface reflects, and 0 for the others.
fn reflected_kinds(light: Noisy) -> vec2f {
    return select(vec2f(0.0), vec2f(1.0), vec2f(light.diffuse_variance, light.glossy_variance) >= vec2f(0.0));
}

// Returns how far a pixel's surface goes on in another pixel, for diffuse and for glossy light: 0 to 1.
fn alike(guide: Guide, normal: vec3f, other: Guide) -> vec2f {
    if other.normal == NO_NORMAL { return vec2f(0.0); }
    let way = other.point - guide.point;
    let distance = length(way);
    let others = from_octahedral(other.normal);
    let off = max(abs(dot(way, normal)), abs(dot(way, others)));
    let slope = select(0.0, off / distance, distance > 0.0) / SLOPE;
    let cosine = max(dot(normal, others), 0.0);
    return exp(-slope * slope) * pow(vec2f(cosine), vec2f(DIFFUSE_NORMALS, GLOSSY_NORMALS));
}
