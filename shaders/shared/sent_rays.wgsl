// Rays that mirrors, glass and veils (partly transparent surfaces) send on. The ray that was sent last is followed
// first.

//! use bounced, frame, lane, light, materials, pixels, planes, primitives, rays, reflectance, shade, surfaces, textures

// Minimum weight of a ray. Rays of a smaller weight do not affect an 8-bit picture.
const FAINT: f32 = 1.0 / 4096.0;

fn send(origin: vec3f, direction: vec3f, weight: vec3f, travelled: f32, depth: u32) {
    if max(max(weight.x, weight.y), weight.z) < FAINT || depth > frame.lighting.bounces || waiting >= MOST_WAITING {
        return;
    }
    hold(SentRay(origin, travelled, direction, depth, weight, 0.0));
}

// Sends on the rays that a surface reflects and transmits.
fn send_on(ray: SentRay, t: f32, material: Material, opacity: f32, surface: Surface, surfaces: Surfaces) {
    let direction = normalize(ray.direction);
    let behind = offset_from(surfaces, ray.origin, -1.0);
    let travelled = ray.travelled + t;
    send(behind, direction, ray.weight * (1.0 - opacity), travelled, ray.depth + 1u);
    let sent = sent_on(material, surface, direction, ray.weight * opacity);
    send(behind, sent.refracted, sent.refracted_weight, travelled, ray.depth + 1u);
    send_mirrored(ray, surfaces, sent.reflected, sent.reflected_weight, travelled);
}

fn send_mirrored(ray: SentRay, surfaces: Surfaces, mirrored: vec3f, weight: vec3f, travelled: f32) {
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

fn rays_of_sent(ray: SentRay) -> Rays {
    return Rays(ray.origin, all3(ray.direction));
}

// Returns the surface that a ray hits.
fn surfaces_met(ray: SentRay, hits: Hits) -> Surfaces {
    travelled_before = F(ray.travelled);
    return surfaces_at(rays_of_sent(ray), hits);
}

// Returns the light that a ray brings to its pixel, and sends on the rays of its surface, given the direct light there.
fn brought_by(ray: SentRay, hits: Hits, surfaces: Surfaces, light: Light) -> vec3f {
    let rays = rays_of_sent(ray);
    let seen = ray.weight * of_ray3(radiance_in(rays, surfaces, light), 0u);
    if hits.primitive == U(MISS) { return seen; }
    let surface = surface_at(rays, hits, 0u);
    let material = material_at(surface.material);
    var opacity = material.opacity;
    if material.blends {
        opacity = opacity_of(material, texture_factor(rays, hits, surface, material.texture, 0u).w);
    }
    send_on(ray, of_ray(hits.t, 0u), material, opacity, surface, surfaces);
    return seen * opacity;
}

// The two parts of shading the hit of the current pixel's last ray. Each reads its state from the buffer. If they kept
// it in registers between them, a GPU would have too few of them.
fn light_last_hit() {
    let ray = last_ray();
    keep_light(light_from(ray.origin, surfaces_met(ray, kept_hit(ray))));
}

// Removes the ray that waits last and sends on the rays of its surface. Returns the pixel's colour so far.
fn send_from_last_hit() -> vec3f {
    let ray = last_ray();
    let hits = kept_hit(ray);
    waiting -= 1u;
    let brought = brought_by(ray, hits, surfaces_met(ray, hits), kept_light());
    return bounced.each[bounced_index].color + brought;
}
