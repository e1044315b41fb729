// Soft light: extended lights, and ambient light that surroundings occlude. A surface samples each source by several
// rays. They are spread evenly (Hammersley's points) and shifted by random numbers of the pixel. So no pattern shows,
// and a frame repeats to the bit.

// Kind of a light, in w of its first texel. Its size is in w of the second one.
const POINT: u32 = 0u;
// 1 is a ball; its size is the radius.
const RECTANGLE: u32 = 2u;     // third and fourth texel: from its middle to the middles of two sides
const SUN: u32 = 3u;           // its position is a unit direction; size: tangent of the radius
const SURROUNDINGS: u32 = 4u;  // behind the last light: ambient light; its rays end after frame.lighting.occlusion_radius

//! if soft is none
fn light_kind(light: u32) -> u32 { return POINT; }

fn sources_of(lights: u32) -> u32 { return lights; }

fn first_slot() -> u32 { return 0u; }

fn slot_of(light: u32, next: u32) -> u32 { return next; }

fn open_ambient() -> vec3f { return shading_vector(AMBIENT); }

fn soft_light(surfaces: Surfaces, eye: vec3f, light: u32, slot: u32) -> Light { return no_light(); }

fn throw_dice(pixels: Pixels, salt: u32) {}

fn rays_asked() -> u32 { return shadow_rays; }

//! if soft is skipped
// Other kernels handle the lights, points too.
fn light_kind(light: u32) -> u32 { return SURROUNDINGS; }

//! if soft is masked or asked or followed
fn light_kind(light: u32) -> u32 {
    if light >= table_texel(AMBIENT).w { return SURROUNDINGS; }
    return table_texel(LIGHTS + LIGHT_TEXELS * light).w;
}

//! if soft is skipped or masked or asked or followed
fn sources_of(lights: u32) -> u32 { return lights + select(0u, 1u, OCCLUSION_RAYS > 0u); }

// Sources have slots: ambient light the first one, if it is sampled, then lights in their order.
fn first_slot() -> u32 { return select(0u, 1u, OCCLUSION_RAYS > 0u); }

fn slot_of(light: u32, next: u32) -> u32 { return select(next, 0u, light >= table_texel(AMBIENT).w); }

// Returns ambient light without occlusion. It is 0 if ambient light is sampled as a source.
fn open_ambient() -> vec3f { return select(shading_vector(AMBIENT), vec3f(0.0), OCCLUSION_RAYS > 0u); }

// The pixels whose random numbers are drawn, in buffer coordinates.
var<private> dice: Pixels;
var<private> dice_salt: u32;
var<private> soft_rays: u32;

fn throw_dice(pixels: Pixels, salt: u32) {
    dice = pixels;
    dice_salt = salt;
}

fn rays_asked() -> u32 { return shadow_rays + soft_rays; }

//! if soft is skipped
fn soft_light(surfaces: Surfaces, eye: vec3f, light: u32, slot: u32) -> Light { return no_light(); }

//! if soft is masked or asked
// Returns the index of a mask, which has one bit for each of a pixel's rays to a source that arrives. Masks are stored
// in `counters`, behind the counters and the cost map, since a further buffer would exceed a kernel's limit.
fn mask_place(slot: u32, ray: u32) -> u32 {
    let pixels = frame.band.size.x * frame.band.size.y;
    let first = frame.band.size.y * COUNTERS + select(0u, pixels, COST_MAP);
    return first + pixel_index(pixel_of_ray(dice, ray)) * frame.lighting.sources + slot;
}

//! if soft is masked or asked or followed
// How rays leave a point for a source: along base + p along + q up, with (p, q) in a disc, or in a square for a
// rectangle. Rays to surroundings are distributed by the cosine of their angle with base.
struct Aim {
    kind: u32,
    count: u32,       // number of rays to the source
    start: vec3f,     // off the surface
    base: vec3f,
    along: vec3f,
    up: vec3f,
    geometric_normal: vec3f,
    shading_normal: vec3f,
    spin: vec2f,
}

// Four rays.
struct Four {
    x: vec4f,         // unit directions
    y: vec4f,
    z: vec4f,
    far: vec4f,       // length
    weight: vec4f,    // of the light along it: its cosine with the surface's normal
    wanted: vec4<bool>,
}

// Weights of all rays, and of those that arrive.
struct Shares {
    all: vec4f,
    open: vec4f,
    all_shine: vec4f,
    open_shine: vec4f,
}

// Hashes three words to three (Jarzynski & Olano 2020, "Hash Functions for GPU Rendering": pcg3d).
fn scrambled(words: vec3u) -> vec3u {
    var v = words * 1664525u + 1013904223u;
    v += v.yzx * v.zxy;
    v ^= v >> vec3u(16u);
    return v + v.yzx * v.zxy;
}

fn spin_of(light: u32, ray: u32) -> vec2f {
    let pixel = pixel_of_ray(dice, ray);
    let which = (light + 1u) * 0x9e3779b9u + dice_salt * 0x85ebca6bu + frame.lighting.seed;
    let random = scrambled(vec3u(pixel.x, pixel.y + frame.band.first_row, which));
    return vec2f(random.xy >> vec2u(8u)) / 16777216.0;
}

// Returns two unit vectors orthogonal to a unit vector and to each other (Duff et al. 2017, "Building an Orthonormal
// Basis, Revisited").
fn across(n: vec3f) -> array<vec3f, 2> {
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    return array<vec3f, 2>(vec3f(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), vec3f(b, sign + n.y * n.y * a, -n.y));
}

fn aim_at(surfaces: Surfaces, eye: vec3f, light: u32, ray: u32) -> Aim {
    let kind = light_kind(light);
    let point = of_ray3(surfaces.point, ray);
    let from_eye = abs(point - eye);
    var reach = of_ray(surfaces.reach, ray);
    if CLOSE { reach = min(reach, max(max(from_eye.x, from_eye.y), from_eye.z) * LARGE); }
    var aim: Aim;
    aim.kind = kind;
    aim.geometric_normal = of_ray3(surfaces.geometric_normal, ray);
    aim.shading_normal = of_ray3(surfaces.shading_normal, ray);
    aim.start = point + aim.geometric_normal * off_surface(point, eye, reach);
    aim.spin = spin_of(light, ray);
    aim.count = select(LIGHT_RAYS, OCCLUSION_RAYS, kind == SURROUNDINGS);
    aim.base = aim.shading_normal;
    var size = 1.0;
    if kind != SURROUNDINGS {
        let first = LIGHTS + LIGHT_TEXELS * light;
        let middle = shading_vector(first);
        size = bitcast<f32>(table_texel(first + 1u).w);
        aim.base = select(middle - aim.start, middle, kind == SUN);
        // A sun without a size takes one ray.
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

// Returns four rays, distributed by the shape of the source.
fn spread_four(aim: Aim, group: u32) -> Four {
    let index = vec4u(0u, 1u, 2u, 3u) + vec4u(4u * group);
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

// Returns rays in four directions, without those that lead below the surface.
fn facing_four(aim: Aim, index: vec4u, x: vec4f, y: vec4f, z: vec4f) -> Four {
    let far = sqrt(x * x + y * y + z * z);
    var rays = Four(x / far, y / far, z / far, far, vec4f(1.0), index < vec4u(aim.count));
    if aim.kind == SUN { rays.far = vec4f(FAR); }
    let above = rays.x * aim.geometric_normal.x + rays.y * aim.geometric_normal.y + rays.z * aim.geometric_normal.z;
    let cosine = rays.x * aim.shading_normal.x + rays.y * aim.shading_normal.y + rays.z * aim.shading_normal.z;
    rays.wanted &= (above > vec4f(0.0)) & (cosine > vec4f(0.0)) & (far > vec4f(0.0));
    if aim.kind == SURROUNDINGS {
        rays.far = vec4f(frame.lighting.occlusion_radius);
    } else {
        rays.weight = cosine;
    }
    rays.weight = select(vec4f(0.0), rays.weight, rays.wanted);
    return rays;
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

// Returns whether a source is always visible: if lights cast no shadows and it is not ambient light.
fn is_never_hidden(kind: u32) -> bool {
    return !CASTS && kind != SURROUNDINGS;
}

// Returns the light of a source at the points that a lane's rays hit.
fn soft_light(surfaces: Surfaces, eye: vec3f, light: u32, slot: u32) -> Light {
    var result = no_light();
    let lit = is_lit_here(surfaces);
    var ray = 0u;
    loop {
        if of_ray_b(lit, ray) {
            let arrived = arrived_from(surfaces, eye, light, slot, ray);
            result.diffuse = with_ray3(result.diffuse, ray, arrived.diffuse);
            if SHINE { result.shine = with_ray3(result.shine, ray, arrived.shine); }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return result;
}

// Light that arrives at one point.
struct Arrived {
    diffuse: vec3f,
    shine: vec3f,
}

// Returns the light of a source of uniform radiance at one point.
fn arrived_evenly(surfaces: Surfaces, eye: vec3f, light: u32, slot: u32, ray: u32) -> Arrived {
    let aim = aim_at(surfaces, eye, light, ray);
    var known = known_share(light, slot, aim.count, ray);
    if is_never_hidden(aim.kind) { known = 1.0; }
    var mask = 0u;
    if known < 0.0 { mask = mask_of(aim, slot, ray); }
    var sums = Shares(vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0));
    var group = 0u;
    loop {
        let rays = four_rays(aim, group);
        let open = four_of_bits(mask >> (4u * group));
        sums.all += rays.weight;
        sums.open += select(vec4f(0.0), rays.weight, open);
        if SHINE && aim.kind != SURROUNDINGS {
            let shine = four_highlights(rays, aim, surfaces, eye, ray);
            sums.all_shine += shine;
            sums.open_shine += select(vec4f(0.0), shine, open);
        }
        group += 1u;
        if 4u * group >= aim.count { break; }
    }
    let all = sum_of_four(sums.all);
    var diffuse = sum_of_four(sums.open);
    var shine = sum_of_four(sums.open_shine);
    if known >= 0.0 {
        diffuse = all * known;
        shine = sum_of_four(sums.all_shine) * known;
    } else {
        keep_share(light, slot, ray, diffuse, all);
    }
    var intensity = shading_vector(AMBIENT);
    if aim.kind != SURROUNDINGS { intensity = shading_vector(LIGHTS + LIGHT_TEXELS * light + 1u); }
    var arrived = Arrived(intensity * (diffuse / f32(aim.count)), vec3f(0.0));
    if SHINE {
        let color = of_ray3(surfaces.specular, ray) * intensity;
        arrived.shine = color * (shine / f32(aim.count));
    }
    return arrived;
}

//! if soft is masked
// Reads the mask that trace_soft stored.
fn mask_of(aim: Aim, slot: u32, ray: u32) -> u32 {
    return atomicLoad(&counters[mask_place(slot, ray)]);
}

//! if soft is followed
// Behind mirrors there are few points, so all rays are traced at once.
fn mask_of(aim: Aim, slot: u32, ray: u32) -> u32 {
    var mask = 0u;
    var group = 0u;
    loop {
        mask |= traced_four(aim, group) << (4u * group);
        group += 1u;
        if 4u * group >= aim.count { break; }
    }
    return mask;
}

//! if soft is asked
// Groups of four rays per dispatch and source. This bounds a thread's work for any number of sources.
const ASKED_GROUPS: u32 = 4u;

// Traces rays to frame.lighting.light, beginning with ray frame.lighting.first_ray, from the hits of target pixels.
fn ask_light(pixels: Pixels, wanted: B) {
    let found = target_hits(pixels, wanted);
    let rays = rays_of(pixels);
    let surfaces = surfaces_at(rays, found);
    throw_dice(pixels, 0u);
    ask_source(pixels, found, surfaces);
    let lit = wanted & is_lit_here(surfaces);
    var ray = 0u;
    loop {
        if of_ray_b(lit, ray) {
            let aim = aim_at(surfaces, rays.origin, frame.lighting.light, ray);
            if known_share(frame.lighting.light, frame.lighting.slot, aim.count, ray) < 0.0 {
                var mask = 0u;
                var group = 0u;
                loop {
                    let at = frame.lighting.first_ray / 4u + group;
                    mask |= traced_four(aim, at) << (4u * at);
                    group += 1u;
                    if group >= ASKED_GROUPS { break; }
                }
                atomicOr(&counters[mask_place(frame.lighting.slot, ray)], mask);
            }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let first = pixel_of_ray(pixels, 0u);
    count_pixel(first);
    count_view(first.y, rays_asked(), nodes_visited, primitives_tested);
}

//! if rays is one
// Returns which of four rays arrive, one bit each.
fn traced_four(aim: Aim, group: u32) -> u32 {
    let rays = four_rays(aim, group);
    var mask = 0u;
    var index = 0u;
    loop {
        if rays.wanted[index] {
            soft_rays += 1u;
            let direction = F3(rays.x[index], rays.y[index], rays.z[index]);
            if any_slot(Rays(aim.start, direction), 0.0, rays.far[index]) == MISS { mask |= 1u << index; }
        }
        index += 1u;
        if index >= 4u { break; }
    }
    return mask;
}

//! if rays is four
// Returns which of four rays arrive, one bit each. They have one origin, so they share a lane.
fn traced_four(aim: Aim, group: u32) -> u32 {
    let rays = four_rays(aim, group);
    if !any(rays.wanted) { return 0u; }
    soft_rays += count_rays(rays.wanted);
    let met = any_slot(Rays(aim.start, F3(rays.x, rays.y, rays.z)), vec4f(0.0), select(vec4f(NEVER), rays.far, rays.wanted));
    return bits_of_four(rays.wanted & (met == vec4u(MISS)));
}
//! end
