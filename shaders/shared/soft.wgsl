// Soft light: extended lights, and ambient light that nearby surfaces occlude. Each source is sampled by several rays
// per point. The rays are spread evenly (Hammersley points) and shifted by random numbers of the pixel. So no pattern
// is visible, and a frame is reproducible bit for bit.

//! use aims, bvh, camera, counters, dice, display, fetch, frame, lane, light, pixels, planes, rays, reflectance
//! use sky_light, surfaces, table, view, visibility

//! if soft is none
fn first_slot() -> u32 { return 0u; }

fn slot_of(light: u32, next: u32) -> u32 { return next; }

fn open_ambient() -> vec3f { return shading_vector(AMBIENT); }

fn soft_light(surfaces: Surfaces, eye: vec3f, light: u32, slot: u32) -> Light { return no_light(); }

//! if soft is skipped or masked or asked or followed
// Each source has a slot. Ambient light has the first slot if it is sampled, and the lights follow in their order.
fn first_slot() -> u32 { return select(0u, 1u, OCCLUSION_RAYS > 0u); }

fn slot_of(light: u32, next: u32) -> u32 { return select(next, 0u, light >= table_texel(AMBIENT).w); }

// Returns ambient light without occlusion. The result is 0 if ambient light is sampled as a source.
fn open_ambient() -> vec3f { return select(shading_vector(AMBIENT), vec3f(0.0), OCCLUSION_RAYS > 0u); }

//! if soft is skipped
fn soft_light(surfaces: Surfaces, eye: vec3f, light: u32, slot: u32) -> Light { return no_light(); }

//! if soft is masked or asked
// Returns the index of a pixel's mask for a source. The mask has one bit for each ray, set if the ray reaches the
// source. Masks are stored in `counters`, after the counters and the cost map, since another buffer would exceed a
// kernel's limit.
fn mask_place(slot: u32, ray: u32) -> u32 {
    let pixels = frame.band.size.x * frame.band.size.y;
    let first = frame.band.size.y * COUNTERS + select(0u, pixels, COST_MAP);
    return first + pixel_index(pixel_of_ray(dice, ray)) * frame.lighting.sources + slot;
}

//! if soft is masked or asked or followed
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

// Returns the light of a source of uniform radiance at one point.
fn arrived_evenly(surfaces: Surfaces, eye: vec3f, light: u32, slot: u32, ray: u32) -> Arrived {
    let aim = aim_at(surfaces, eye, light, ray);
    var known = known_share(light, slot, aim.count, ray);
    if is_never_hidden(aim.kind) { known = 1.0; }
    var mask = 0u;
    if known < 0.0 { mask = mask_of(aim, slot, ray); }
    var sums: Shares;
    var group = 0u;
    loop {
        let rays = four_rays(aim, group);
        let open = four_of_bits(mask >> (4u * group));
        sums.all += rays.weight;
        sums.open += select(vec4f(0.0), rays.weight, open);
        if SHINE && aim.kind != SURROUNDINGS {
            let shine = four_highlights(rays, aim, surfaces, eye, ray);
            let plain = shine.plain * rays.fade;
            sums.all_shine += plain;
            sums.open_shine += select(vec4f(0.0), plain, open);
            if FACETS {
                let grazing = shine.grazing * rays.fade;
                sums.all_grazing += grazing;
                sums.open_grazing += select(vec4f(0.0), grazing, open);
            }
            if COATS {
                let coat = shine.coat * rays.fade;
                sums.all_coat += coat;
                sums.open_coat += select(vec4f(0.0), coat, open);
            }
        }
        group += 1u;
        if 4u * group >= aim.count { break; }
    }
    let all = sum_of_four(sums.all);
    var diffuse = sum_of_four(sums.open);
    var shine = sum_of_four(sums.open_shine);
    var grazing = sum_of_four(sums.open_grazing);
    var coat = sum_of_four(sums.open_coat);
    if known >= 0.0 {
        diffuse = all * known;
        shine = sum_of_four(sums.all_shine) * known;
        grazing = sum_of_four(sums.all_grazing) * known;
        coat = sum_of_four(sums.all_coat) * known;
    } else {
        keep_share(light, slot, ray, diffuse, all);
    }
    var intensity = shading_vector(AMBIENT);
    if aim.kind != SURROUNDINGS { intensity = shading_vector(LIGHTS + LIGHT_TEXELS * light + 1u); }
    var arrived = Arrived(intensity * (diffuse / f32(aim.count)), vec3f(0.0));
    if SHINE {
        arrived.shine = shine_color(surfaces, intensity, vec3f(shine, grazing, coat) / f32(aim.count), ray);
    }
    return arrived;
}

//! if soft is masked
// Reads the mask that trace_soft stored.
fn mask_of(aim: Aim, slot: u32, ray: u32) -> u32 {
    return atomicLoad(&counters[mask_place(slot, ray)]);
}

//! if soft is followed
// Few points are visible in mirrors, so all their rays are traced at once.
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
// Number of groups of four rays per dispatch and source. It limits a thread's work per dispatch for any number of
// sources.
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
// Returns which of four rays reach the source, one bit each.
fn traced_four(aim: Aim, group: u32) -> u32 {
    var mask = 0u;
    var index = 0u;
    loop {
        // A ray that is computed when it is traced takes no registers before (docs/TRAVERSAL.md).
        let again = aim_from(aim.start, aim.geometric_normal, aim.shading_normal, aim.light, 0u);
        let rays = one_ray(again, 4u * group + index);
        if rays.wanted.x {
            soft_rays += 1u;
            if any_slot(Rays(aim.start, F3(rays.x.x, rays.y.x, rays.z.x)), 0.0, rays.far.x) == MISS {
                mask |= 1u << index;
            }
        }
        index += 1u;
        if index >= 4u { break; }
    }
    return mask;
}

//! if rays is four
// Returns which of four rays reach the source, one bit each. The rays have one origin, so they share a lane.
fn traced_four(aim: Aim, group: u32) -> u32 {
    let rays = four_rays(aim, group);
    if !any(rays.wanted) { return 0u; }
    soft_rays += count_rays(rays.wanted);
    let met = any_slot(
        Rays(aim.start, F3(rays.x, rays.y, rays.z)),
        vec4f(0.0),
        select(vec4f(NEVER), rays.far, rays.wanted),
    );
    return bits_of_four(rays.wanted & (met == vec4u(MISS)));
}

//! if soft is masked or asked or followed
// Sums of the weights of all rays, and of the rays that reach the source.
struct Shares {
    all: vec4f,
    open: vec4f,
    all_shine: vec4f,
    open_shine: vec4f,
    all_grazing: vec4f,
    open_grazing: vec4f,
    all_coat: vec4f,
    open_coat: vec4f,
}

//! if surroundings is ambient
fn arrived_from(surfaces: Surfaces, eye: vec3f, light: u32, slot: u32, ray: u32) -> Arrived {
    return arrived_evenly(surfaces, eye, light, slot, ray);
}

//! if surroundings is cosine or map
fn arrived_from(surfaces: Surfaces, eye: vec3f, light: u32, slot: u32, ray: u32) -> Arrived {
    if light_kind(light) == SURROUNDINGS { return arrived_from_sky(surfaces, eye, light, slot, ray); }
    return arrived_evenly(surfaces, eye, light, slot, ray);
}

// Returns the light of the sky at one point. Views reuse the visible share of this light, measured by luminance. Like
// ambient light, the sky causes no highlights.
fn arrived_from_sky(surfaces: Surfaces, eye: vec3f, light: u32, slot: u32, ray: u32) -> Arrived {
    let aim = aim_at(surfaces, eye, light, ray);
    let known = known_share(light, slot, aim.count, ray);
    var mask = 0u;
    if known < 0.0 { mask = mask_of(aim, slot, ray); }
    let none = vec4f(0.0);
    var all = FourColors(none, none, none);
    var open = FourColors(none, none, none);
    var group = 0u;
    loop {
        let four = sky_colors(aim, four_rays(aim, group));
        let arrives = four_of_bits(mask >> (4u * group));
        all = FourColors(all.r + four.r, all.g + four.g, all.b + four.b);
        open.r += select(none, four.r, arrives);
        open.g += select(none, four.g, arrives);
        open.b += select(none, four.b, arrives);
        group += 1u;
        if 4u * group >= aim.count { break; }
    }
    let unhidden = sum_of_colors(all);
    var diffuse = sum_of_colors(open);
    if known >= 0.0 {
        diffuse = unhidden * known;
    } else {
        keep_share(light, slot, ray, luminance(diffuse), luminance(unhidden));
    }
    return Arrived(diffuse / f32(aim.count), vec3f(0.0));
}
