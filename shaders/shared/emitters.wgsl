// Light that reaches a path's vertex directly. A place on a light, a place on an emitting primitive, and a direction of
// a sky map are chosen by chance.

//! use aims, bvh, display, facets, fetch, lane, pixels, planes, projectors, rays, scattering, sky, sky_light, sobol
//! use table

//! if light is paths
// Number of pairs of random numbers per vertex, and what they choose.
const PAIRS: u32 = 8u;
const PAIR_DIRECTION: u32 = 0u;
const PAIR_LOBE: u32 = 1u;       // lobe; whether the path ends
const PAIR_LIGHT: u32 = 2u;      // light
const PAIR_PLACE: u32 = 3u;      // place on the light
const PAIR_SKY: u32 = 4u;
const PAIR_EMITTER: u32 = 5u;    // emitting primitive
const PAIR_SPOT: u32 = 6u;       // place on the emitting primitive

// Rays to lights, and through veils and glass in front of them.
var<private> light_rays: u32;

// Light that a vertex sends to the viewer: irradiance over pi, for diffuse reflection, and reflected radiance.
struct Sent {
    diffuse: vec3f,
    glossy: vec3f,
}

fn plus(a: Sent, b: Sent) -> Sent { return Sent(a.diffuse + b.diffuse, a.glossy + b.glossy); }

// Light that a vertex may receive along a ray. Light that arrives is a share of `scale`.
struct LightRay {
    direction: vec3f,    // unit, to the light
    far: f32,            // length; 0: there is no light
    scale: vec3f,
    diffuse: f32,        // factor of light that arrives, for diffuse reflection
    glossy: vec3f,       // and for reflected radiance
    _pad: u32,
}

// Returns the light of all lights, of emitting surfaces and of a sky map. `pair` is the vertex's first pair of random
// numbers. Other kernels shade lights that the first vertex sees unhidden.
fn sent_from_emitters(vertex: Vertex, pair: u32, is_first: bool) -> Sent {
    let start = leaving(vertex, 1.0);
    let bright = plus(arrived(start, ray_to_emitting(vertex, pair)), arrived(start, ray_to_sky(vertex, pair)));
    return plus(passed(start, ray_to_light(vertex, pair, is_first), is_first), bright);
}

// Returns the light that a ray brings, if nothing is in its way.
fn arrived(start: vec3f, ray: LightRay) -> Sent {
    if ray.far <= 0.0 { return Sent(vec3f(0.0), vec3f(0.0)); }
    light_rays += 1u;
    if any_slot(Rays(start, all3(ray.direction)), 0.0, ray.far) != MISS { return Sent(vec3f(0.0), vec3f(0.0)); }
    return Sent(ray.scale * ray.diffuse, ray.scale * ray.glossy);
}

// Returns the light that a ray brings through what is in its way.
fn passed(start: vec3f, ray: LightRay, is_first: bool) -> Sent {
    if ray.far <= 0.0 { return Sent(vec3f(0.0), vec3f(0.0)); }
    let light = ray.scale * passing(start, ray.direction, ray.far, is_first);
    return Sent(light * ray.diffuse, light * ray.glossy);
}

fn ray_to_light(vertex: Vertex, pair: u32, is_first: bool) -> LightRay {
    let none = LightRay();
    let count = table_texel(AMBIENT).w;
    if count == 0u || (is_first && !SEES_THROUGH) { return none; }
    let light = min(u32(random_point(pair + PAIR_LIGHT).x * f32(count)), count - 1u);
    let first = LIGHTS + LIGHT_TEXELS * light;
    let head = table_texel(first);
    let at = random_point(pair + PAIR_PLACE);
    let size = bitcast<f32>(table_texel(first + 1u).w);
    let start = leaving(vertex, 1.0);
    var base = bitcast<vec3f>(head.xyz);
    if head.w != SUN { base -= start; }
    let to_middle = base;
    if head.w == RECTANGLE {
        base += shading_vector(first + 2u) * (2.0 * at.x - 1.0) + shading_vector(first + 3u) * (2.0 * at.y - 1.0);
    } else if head.w != POINT {
        let sides = across(normalize(base));
        let turn = TWO_PI * at.y;
        base += (sides[0] * cos(turn) + sides[1] * sin(turn)) * (disc_of(light, head.w, size, to_middle) * sqrt(at.x));
    }
    let far = length(base);
    if far <= 0.0 { return none; }
    let to_light = base / far;
    let there = reflectance_of(vertex, to_light);
    if there.diffuse <= 0.0 { return none; }
    // A light's intensity is the radiance of a white surface that faces it, so its irradiance is pi times as large.
    let fade = faded(light, head.w, base, to_middle);
    let intensity = intensity_along(light, shading_vector(first + 1u), base);
    let scale = intensity * (f32(count) * fade * vertex.lobes.opacity / INVERSE_PI);
    return LightRay(to_light, select(far, FAR, head.w == SUN), scale, there.diffuse, there.glossy, 0u);
}

//! if light is paths and mirrors is none
const SEES_THROUGH: bool = false;

// Returns the share of a light that arrives along a ray.
fn passing(start: vec3f, to_light: vec3f, far: f32, is_first: bool) -> vec3f {
    if !CASTS { return vec3f(1.0); }
    light_rays += 1u;
    return vec3f(select(0.0, 1.0, any_slot(Rays(start, all3(to_light)), 0.0, far) == MISS));
}

//! if light is paths and mirrors is followed
const SEES_THROUGH: bool = true;

// Maximum number of veils and panes that light passes through.
const MOST_PANES: u32 = 8u;

// Returns the share of a light that arrives along a ray, through veils and glass. Glass does not bend these rays. For
// the first vertex the result is 0 if nothing is in the ray's way.
fn passing(start: vec3f, to_light: vec3f, far: f32, is_first: bool) -> vec3f {
    if !CASTS { return vec3f(select(1.0, 0.0, is_first)); }
    var share = vec3f(1.0);
    var from_point = start;
    var left = far;
    var panes = 0u;
    loop {
        light_rays += 1u;
        let rays = Rays(from_point, all3(to_light));
        let hits = closest_hit(rays, 0.0, left);
        if hits.primitive == MISS { break; }
        let pane = vertex_at(rays, hits);
        let lobes = pane.lobes;
        var clear = vec3f(1.0 - lobes.opacity);
        if lobes.is_glass { clear = split_by_glass(pane, pane.normal, pane.to_viewer, pane.from_outside).passed; }
        clear *= pow(pane.left, vec3f(hits.t));
        share *= clear;
        panes += 1u;
        if all(share <= vec3f(0.0)) || panes > MOST_PANES { return vec3f(0.0); }
        left -= hits.t + pane.offset;
        from_point = leaving(pane, -1.0);
        if left <= 0.0 { break; }
    }
    return select(share, vec3f(0.0), is_first && panes == 0u);
}

//! if light is paths
// An emitting triangle or sphere is chosen by its share of the total power, brightness times area, and a place on it
// evenly: on a triangle, or in the cone of directions to a sphere. It has four texels: first corner and the cumulative
// share of power; two sides, the first with a kind; and emitted radiance. A sphere has its centre for the corner, and
// its radius in place of the first side.
const EMITTER_TEXELS: u32 = 4u;
const EMITTING_SPHERE: u32 = 1u;

// Returns 1 minus the cosine of the angle with this sine, without cancellation for small angles.
fn cap_of(sine: f32) -> f32 { return sine * sine / (1.0 + sqrt(max(1.0 - sine * sine, 0.0))); }

// The share of a ray in front of an emitting surface that must be free.
const NEARLY: f32 = 0.9999;

fn ray_to_emitting(vertex: Vertex, pair: u32) -> LightRay {
    let none = LightRay();
    if MATERIAL_TEXELS == 1u { return none; }
    let head = table_texel(table_texel(FOR_PATHS).w);
    if head.z == 0u { return none; }
    let over = texel_over(random_point(pair + PAIR_EMITTER).x, head.y, EMITTER_TEXELS, head.z);
    let first = head.y + EMITTER_TEXELS * over.index;
    let side = table_texel(first + 1u);
    let along = bitcast<vec3f>(side.xyz);
    let up = shading_vector(first + 2u);
    let emission = shading_vector(first + 3u);
    let at = random_point(pair + PAIR_SPOT);
    let start = leaving(vertex, 1.0);
    var way = shading_vector(first) - start;
    // Density per steradian, but for the share of power.
    var density = 0.0;
    if side.w == EMITTING_SPHERE {
        let radius = along.x;
        let distance = length(way);
        if distance <= radius { return none; }
        let cap = cap_of(radius / distance);
        let cosine = 1.0 - at.x * cap;
        let sides = across(way / distance);
        let turn = TWO_PI * at.y;
        let aside = sqrt(at.x * cap * (2.0 - at.x * cap));
        let direction = way * (cosine / distance) + (sides[0] * cos(turn) + sides[1] * sin(turn)) * aside;
        let nearest = distance * cosine - sqrt(max(radius * radius - distance * distance * aside * aside, 0.0));
        way = direction * nearest;
        density = luminance(emission) * 2.0 * radius * radius / cap;
    } else {
        let root = sqrt(at.x);
        way += along * (1.0 - root) + up * (at.y * root);
        let normal = cross(along, up);
        let squared = dot(way, way);
        density = luminance(emission) * squared * sqrt(squared) * length(normal) / max(abs(dot(normal, way)), 1e-30);
    }
    let far = length(way);
    if far <= 0.0 { return none; }
    let to_light = way / far;
    let there = reflectance_of(vertex, to_light);
    if there.diffuse <= 0.0 { return none; }
    density /= bitcast<f32>(head.w);
    if !(density > 0.0) { return none; }
    return LightRay(
        to_light,
        far * NEARLY,
        emission * vertex.lobes.opacity,
        there.diffuse / (density + there.diffuse_density),
        there.glossy / (density + there.glossy_density),
        0u,
    );
}

// Returns the light that an emitting vertex sends along a path whose ray had this density and length.
fn emission_of_path(vertex: Vertex, density: f32, t: f32) -> vec3f {
    let emission = vertex.emission * vertex.lobes.opacity;
    if MATERIAL_TEXELS == 1u || density <= 0.0 || !vertex.is_chosen { return emission; }
    let power = bitcast<f32>(table_texel(table_texel(FOR_PATHS).w).w);
    var other = t * t / max(abs(dot(vertex.geometric_normal, vertex.to_viewer)), 1e-6);
    if vertex.radius > 0.0 {
        let center = vertex.point - vertex.outward * vertex.radius;
        let sine = vertex.radius / distance(vertex.point + vertex.to_viewer * t, center);
        // The inside of a sphere is found by chance alone.
        if sine >= 1.0 { return emission; }
        other = 2.0 * vertex.radius * vertex.radius / max(cap_of(sine), 1e-30);
    }
    other *= luminance(emission) / max(power, 1e-30);
    return emission * (density / (density + other));
}

//! if light is paths and sky is constant or gradient
// Paths that leave the scene find the sky.
fn ray_to_sky(vertex: Vertex, pair: u32) -> LightRay { return LightRay(); }

fn sky_of_path(direction: vec3f, density: f32) -> vec3f { return of_ray3(sky(all3(direction)), 0u); }

//! if light is paths and sky is map
// A bright part of a sky map is found by its brightness, and by paths that leave the scene. Both are combined by the
// balance heuristic (Veach and Guibas 1995, "Optimally Combining Sampling Techniques").
fn ray_to_sky(vertex: Vertex, pair: u32) -> LightRay {
    let none = LightRay();
    let at = random_point(pair + PAIR_SKY);
    let to_light = towards_brightness(at.x, at.y);
    let there = reflectance_of(vertex, to_light);
    if there.diffuse <= 0.0 { return none; }
    let header = table_texel(SKY_NADIR);
    let seen = sky_seen(to_light, header, map_mean(header));
    let density = seen.density * INVERSE_PI;
    if density <= 0.0 { return none; }
    return LightRay(
        to_light,
        FAR,
        seen.color * vertex.lobes.opacity,
        there.diffuse / (density + there.diffuse_density),
        there.glossy / (density + there.glossy_density),
        0u,
    );
}

// Returns the sky's share in the light of a path that leaves the scene in a direction of this density.
fn sky_of_path(direction: vec3f, density: f32) -> vec3f {
    let header = table_texel(SKY_NADIR);
    let seen = sky_seen(direction, header, map_mean(header));
    if density <= 0.0 { return seen.color; }
    return seen.color * (density / (density + seen.density * INVERSE_PI));
}
