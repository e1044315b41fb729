// Shades pixels that show mirrors, glass or veils (partly transparent surfaces). Their light comes from the first hits
// in the view and from the rays that these surfaces reflect and transmit. These rays are traced for each eye and are
// not reused.
//
// launch  one thread per list entry, dispatched indirectly
// reads   lists      TO_TRACE
// updates view       [height * width]      color
// adds    counters   [height * COUNTERS]

//! use bvh, camera, counters, dice, frame, lane, light, lists, materials, pixels, planes, primitives, rays, stack
//! use reflectance, shade, surfaces, textures, view

var<storage, read_write> lists: Lists;
var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

// A reflected or refracted ray that waits to be traced.
struct Pending {
    origin: vec3f,
    direction: vec3f,
    weight: vec3f,      // multiplies what the ray sees
    travelled: f32,     // depth of the first hit, plus the path length from there
    depth: u32,         // number of surfaces hit so far
}

// A surface sends on at most two rays, one of which is followed at once. So the number of waiting rays exceeds the
// number of surfaces hit along a ray by at most one.
const MOST_PENDING: u32 = 9u;
var<private> pending: array<Pending, MOST_PENDING>;
var<private> waiting: u32;

// Minimum weight of a ray. Rays of a smaller weight do not affect an 8-bit picture.
const FAINT: f32 = 1.0 / 4096.0;

fn send(origin: vec3f, direction: vec3f, weight: vec3f, travelled: f32, depth: u32) {
    if max(max(weight.x, weight.y), weight.z) < FAINT || depth > frame.lighting.bounces || waiting >= MOST_PENDING {
        return;
    }
    pending[waiting] = Pending(origin, direction, weight, travelled, depth);
    waiting += 1u;
}

// Sends on the rays that a surface reflects and transmits.
fn send_on(ray: Pending, t: f32, material: Material, opacity: f32, surface: Surface, surfaces: Surfaces) {
    let direction = normalize(ray.direction);
    let behind = offset_from(surfaces, ray.origin, -1.0);
    let travelled = ray.travelled + t;
    send(behind, direction, ray.weight * (1.0 - opacity), travelled, ray.depth + 1u);
    let sent = sent_on(material, surface, direction, ray.weight * opacity);
    send(behind, sent.refracted, sent.refracted_weight, travelled, ray.depth + 1u);
    send_mirrored(ray, surfaces, sent.reflected, sent.reflected_weight, travelled);
}

fn send_mirrored(ray: Pending, surfaces: Surfaces, mirrored: vec3f, weight: vec3f, travelled: f32) {
    let above = kept_above(mirrored, of_ray3(surfaces.geometric_normal, 0u));
    send(offset_from(surfaces, ray.origin, 1.0), normalize(above), weight, travelled, ray.depth + 1u);
}

// Returns the origin of a ray that leaves a hit point. It is moved off the surface, to the ray's side, by the same
// distance as for shadow rays.
fn offset_from(surfaces: Surfaces, origin: vec3f, side: f32) -> vec3f {
    let point = of_ray3(surfaces.point, 0u);
    let offset = off_surface(point, origin, of_ray(surfaces.reach, 0u));
    return point + of_ray3(surfaces.geometric_normal, 0u) * (side * offset);
}

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_mirrored(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let listed = listed_pixels(TO_TRACE, listed_thread(id));
    if !any_ray(listed.wanted) { return; }
    let first = pixel_of_ray(listed.pixels, 0u);
    let own = rays_of(listed.pixels);
    // The first ray's direction is scaled so that t is depth. All other directions are unit vectors.
    var ray = Pending(own.origin, of_ray3(own.direction, 0u), vec3f(1.0), 0.0, 0u);
    var hits = target_hits(listed.pixels, listed.wanted);
    // A hit may be reused from another view's sample. If this pixel's own ray hits the same primitive, that t replaces
    // the sample's. Without this, reflected rays would begin beside the pixel.
    if COUNT { primitives_tested += 1u; }
    let met = met_at(hits.slot, own);
    hits.t = select(hits.t, met.t, met.hit & (met.t >= F(0.0)));
    var color = vec3f(0.0);
    var sent_rays = 0u;
    loop {
        let rays = Rays(ray.origin, all3(ray.direction));
        travelled_before = F(ray.travelled);
        throw_dice(listed.pixels, sent_rays);
        let surfaces = surfaces_at(rays, hits);
        let seen = ray.weight * of_ray3(radiance(rays, hits, surfaces), 0u);
        if hits.primitive == U(MISS) {
            color += seen;
        } else {
            let surface = surface_at(rays, hits, 0u);
            let material = material_at(surface.material);
            var opacity = material.opacity;
            if material.blends {
                opacity = opacity_of(material, texture_factor(rays, hits, surface, material.texture, 0u).w);
            }
            color += seen * opacity;
            send_on(ray, of_ray(hits.t, 0u), material, opacity, surface, surfaces);
        }
        if waiting == 0u { break; }
        waiting -= 1u;
        ray = pending[waiting];
        hits = closest_hit(Rays(ray.origin, all3(ray.direction)), F(0.0), F(FAR));
        sent_rays += 1u;
        if cut_short { break; }
    }
    cut_short |= waiting > 0u;
    keep_colors(listed.pixels, listed.wanted, all3(color));
    count_pixel(first);
    count_view(first.y, rays_asked(), nodes_visited, primitives_tested);
    atomicAdd(&counters[first.y * COUNTERS + SENT_RAYS], sent_rays);
    atomicAdd(&counters[first.y * COUNTERS + OWN_SHADOW_RAYS], rays_asked());
}
