// Rays from surface points to light sources, in groups of four.

//! use dice, fetch, frame, lane, light, pixels, table

//! if soft is masked or asked or followed
// A bundle of rays from a surface point to one light source. A ray's direction is base + p along + q up. The pair (p,
// q) lies in a disc, or in a square for a rectangular light. Rays of ambient light follow a cosine distribution around
// base.
struct Aim {
    kind: u32,
    light: u32,
    count: u32,       // number of rays to the source
    start: vec3f,     // ray origin, moved off the surface
    base: vec3f,
    along: vec3f,
    up: vec3f,
    geometric_normal: vec3f,
    shading_normal: vec3f,
    spin: vec2f,
}

// A group of four rays.
struct Four {
    x: vec4f,         // unit directions
    y: vec4f,
    z: vec4f,
    far: vec4f,       // maximum length of the ray, world units
    weight: vec4f,    // cosine times `fade`; 1 for ambient light, 0 for an unwanted ray
    fade: vec4f,      // share of the light's intensity, by distance and direction
    wanted: vec4<bool>,
}

fn bits_of_four(four: vec4<bool>) -> u32 {
    let n = select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), four);
    return (n.x | n.y) | (n.z | n.w);
}

fn four_of_bits(bits: u32) -> vec4<bool> {
    return (vec4u(bits) & vec4u(1u, 2u, 4u, 8u)) != vec4u(0u);
}

fn sum_of_four(four: vec4f) -> f32 {
    return (four.x + four.y) + (four.z + four.w);
}

//! end
// Kind of a light, stored in w of the light's first texel. The light's size is stored in w of its second texel.
const POINT: u32 = 0u;
const SPHERE: u32 = 1u;        // its size is the radius
const RECTANGLE: u32 = 2u;     // third and fourth texel: vectors from its centre to the centres of two sides
const SUN: u32 = 3u;           // its position is a unit direction; its size is the tangent of its angular radius
const SURROUNDINGS: u32 = 4u;  // ambient light, indexed after the last light; its rays end after occlusion_radius

// Returns two unit vectors orthogonal to a unit vector and to each other (Duff et al. 2017, "Building an Orthonormal
// Basis, Revisited").
fn across(n: vec3f) -> array<vec3f, 2> {
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    return array<vec3f, 2>(
        vec3f(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        vec3f(b, sign + n.y * n.y * a, -n.y),
    );
}

//! if fading is none
// Returns the share of a light's intensity that arrives from a place on the light. `to_light` leads to that place and
// `to_middle` to the light's centre.
fn faded(light: u32, kind: u32, to_light: vec3f, to_middle: vec3f) -> f32 { return 1.0; }

// Returns the radius of the disc that stands for a sphere.
fn disc_of(light: u32, kind: u32, size: f32, to_middle: vec3f) -> f32 { return size; }

//! if fading is some
// Least share of a squared distance from a sphere's centre that is outside the sphere.
const LEAST_OUTSIDE: f32 = 1e-4;

// Returns the share of a squared distance that is outside a sphere.
fn outside_share(size: f32, to_middle: vec3f) -> f32 {
    return max(1.0 - size * size / max(dot(to_middle, to_middle), 1e-30), LEAST_OUTSIDE);
}

// The w of the third and fourth texels hold the scale of the cone and the range, which is 0 without falloff. Both
// factors are those of `KHR_lights_punctual`.
fn faded(light: u32, kind: u32, to_light: vec3f, to_middle: vec3f) -> f32 {
    let first = LIGHTS + LIGHT_TEXELS * light;
    let third = table_texel(first + 2u);
    let fourth = table_texel(first + 3u);
    let range = bitcast<f32>(fourth.w);
    let squared = max(dot(to_light, to_light), 1e-30);
    var share = 1.0;
    if range > 0.0 {
        let ranges = squared / (range * range);
        share = clamp(1.0 - ranges * ranges, 0.0, 1.0) / squared;
        if kind == SPHERE {
            let size = bitcast<f32>(table_texel(first + 1u).w);
            share *= length(to_middle) * inverseSqrt(squared) / outside_share(size, to_middle);
        }
        if kind == RECTANGLE {
            let normal = normalize(cross(bitcast<vec3f>(third.xyz), bitcast<vec3f>(fourth.xyz)));
            share *= max(-dot(normal, to_light) * inverseSqrt(squared), 0.0);
        }
    }
    if kind != RECTANGLE {
        let cosine = -dot(bitcast<vec3f>(third.xyz), to_light) * inverseSqrt(squared);
        let root = clamp(cosine * bitcast<f32>(third.w) + bitcast<f32>(fourth.x), 0.0, 1.0);
        share *= root * root;
    }
    return share;
}

// A sphere with falloff is a disc of the same solid angle at its centre, so its irradiance is exact.
fn disc_of(light: u32, kind: u32, size: f32, to_middle: vec3f) -> f32 {
    if kind != SPHERE || bitcast<f32>(table_texel(LIGHTS + LIGHT_TEXELS * light + 3u).w) <= 0.0 { return size; }
    return size * inverseSqrt(outside_share(size, to_middle));
}

//! if soft is none
fn light_kind(light: u32) -> u32 { return POINT; }

fn sources_of(lights: u32) -> u32 { return lights; }

//! if soft is skipped
// This kernel skips all lights, point lights included. Other kernels compute them.
fn light_kind(light: u32) -> u32 { return SURROUNDINGS; }

//! if soft is masked or asked or followed
fn light_kind(light: u32) -> u32 {
    if light >= table_texel(AMBIENT).w { return SURROUNDINGS; }
    return table_texel(LIGHTS + LIGHT_TEXELS * light).w;
}

//! if soft is skipped or masked or asked or followed
fn sources_of(lights: u32) -> u32 { return lights + select(0u, 1u, OCCLUSION_RAYS > 0u); }

//! if soft is masked or asked or followed
fn spin_of(light: u32, ray: u32) -> vec2f {
    let pixel = pixel_of_ray(dice, ray);
    let which = (light + 1u) * 0x9e3779b9u + dice_salt * 0x85ebca6bu + frame.lighting.seed;
    let random = scrambled(vec3u(pixel.x, pixel.y + frame.band.first_row, which));
    return vec2f(random.xy >> vec2u(8u)) / 16777216.0;
}

fn aim_at(surfaces: Surfaces, eye: vec3f, light: u32, ray: u32) -> Aim {
    let point = of_ray3(surfaces.point, ray);
    let from_eye = abs(point - eye);
    var reach = of_ray(surfaces.reach, ray);
    if CLOSE { reach = min(reach, max(max(from_eye.x, from_eye.y), from_eye.z) * LARGE); }
    let geometric_normal = of_ray3(surfaces.geometric_normal, ray);
    let start = point + geometric_normal * off_surface(point, eye, reach);
    return aim_from(start, geometric_normal, of_ray3(surfaces.shading_normal, ray), light, ray);
}

fn aim_from(start: vec3f, geometric_normal: vec3f, shading_normal: vec3f, light: u32, ray: u32) -> Aim {
    let kind = light_kind(light);
    var aim: Aim;
    aim.kind = kind;
    aim.light = light;
    aim.geometric_normal = geometric_normal;
    aim.shading_normal = shading_normal;
    aim.start = start;
    aim.spin = spin_of(light, ray);
    aim.count = select(LIGHT_RAYS, OCCLUSION_RAYS, kind == SURROUNDINGS);
    aim.base = aim.shading_normal;
    var size = 1.0;
    if kind != SURROUNDINGS {
        let first = LIGHTS + LIGHT_TEXELS * light;
        let middle = shading_vector(first);
        size = bitcast<f32>(table_texel(first + 1u).w);
        aim.base = select(middle - aim.start, middle, kind == SUN);
        size = disc_of(light, kind, size, aim.base);
        // A sun of size 0 needs only one ray.
        if size == 0.0 && kind == SUN { aim.count = 1u; }
        aim.along = shading_vector(first + 2u);
        aim.up = shading_vector(first + 3u);
    }
    if kind != RECTANGLE {
        let sides = across(normalize(aim.base));
        aim.along = sides[0] * size;
        aim.up = sides[1] * size;
    }
    return aim;
}

fn indices_of(group: u32) -> vec4u { return vec4u(0u, 1u, 2u, 3u) + vec4u(4u * group); }

// Returns the rays of these indices, distributed over the shape of the light source.
fn spread_four(aim: Aim, index: vec4u) -> Four {
    let u = fract((vec4f(index) + 0.5) / f32(aim.count) + aim.spin.x);
    let v = fract(vec4f(reverseBits(index) >> vec4u(8u)) / 16777216.0 + aim.spin.y);
    var p = 2.0 * u - 1.0;
    var q = 2.0 * v - 1.0;
    var straight = vec4f(1.0);
    if aim.kind != RECTANGLE {
        let turn = 6.2831853 * v;
        p = sqrt(u) * cos(turn);
        q = sqrt(u) * sin(turn);
        if aim.kind == SURROUNDINGS { straight = sqrt(max(1.0 - u, vec4f(0.0))); }
    }
    let x = aim.base.x * straight + aim.along.x * p + aim.up.x * q;
    let y = aim.base.y * straight + aim.along.y * p + aim.up.y * q;
    let z = aim.base.z * straight + aim.along.z * p + aim.up.z * q;
    return facing_four(aim, index, x, y, z);
}

// Returns rays in four directions. Rays that point below the surface are marked as not wanted.
fn facing_four(aim: Aim, index: vec4u, x: vec4f, y: vec4f, z: vec4f) -> Four {
    let far = sqrt(x * x + y * y + z * z);
    var rays = Four(x / far, y / far, z / far, far, vec4f(1.0), vec4f(1.0), index < vec4u(aim.count));
    if aim.kind == SUN { rays.far = vec4f(FAR); }
    let above = rays.x * aim.geometric_normal.x + rays.y * aim.geometric_normal.y + rays.z * aim.geometric_normal.z;
    let cosine = rays.x * aim.shading_normal.x + rays.y * aim.shading_normal.y + rays.z * aim.shading_normal.z;
    rays.wanted &= (above > vec4f(0.0)) & (cosine > vec4f(0.0)) & (far > vec4f(0.0));
    if aim.kind == SURROUNDINGS {
        rays.far = vec4f(frame.lighting.occlusion_radius);
    } else {
        rays.fade = faded_four(aim, x, y, z);
        rays.weight = cosine * rays.fade;
    }
    rays.weight = select(vec4f(0.0), rays.weight, rays.wanted);
    return rays;
}

//! if fading is none and soft is masked or asked or followed
fn faded_four(aim: Aim, x: vec4f, y: vec4f, z: vec4f) -> vec4f { return vec4f(1.0); }

//! if fading is some and soft is masked or asked or followed
fn faded_four(aim: Aim, x: vec4f, y: vec4f, z: vec4f) -> vec4f {
    var shares = vec4f(1.0);
    var index = 0u;
    loop {
        shares[index] = faded(aim.light, aim.kind, vec3f(x[index], y[index], z[index]), aim.base);
        index += 1u;
        if index >= 4u { break; }
    }
    return shares;
}

//! if soft is masked or asked or followed
// Returns whether a source is always visible. This holds for lights if shadows are disabled, but never for ambient
// light.
fn is_never_hidden(kind: u32) -> bool {
    return !CASTS && kind != SURROUNDINGS;
}

// Light that arrives at one point.
struct Arrived {
    diffuse: vec3f,
    shine: vec3f,
}
