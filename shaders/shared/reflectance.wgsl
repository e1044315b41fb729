// Reflectance: highlights that surfaces send to the eye, and rays that mirrors and glass send on. Diffuse reflection is
// the albedo, which shade.wgsl applies to the sum of all light.

//! use aims, facets, lane, light, looks, materials, rays

//! if shine is none
fn with_look(surfaces: Surfaces, rays: Rays, hits: Hits, surface: Surface, material: Material, factor: vec4f, ray: u32)
    -> Surfaces {
    return surfaces;
}

fn highlight(surfaces: Surfaces, from_light: F3, eye: vec3f) -> F3 {
    return all3(vec3f(0.0));
}

fn four_highlights(rays: Four, aim: Aim, surfaces: Surfaces, eye: vec3f, ray: u32) -> FourShine {
    return FourShine(vec4f(0.0), vec4f(0.0), vec4f(0.0));
}

//! if shine is some
// Phong's lobe as MTL defines it. `cosine` is the cosine of the angle between the mirrored light and the eye, `facing`
// that between the normal and the light.
fn lobe_scale(exponent: f32) -> f32 { return 1.0; }

// pow(0, 0) is undefined, so the cosine has a lower limit.
fn lobe(exponent: F, cosine: F, facing: F) -> F { return pow(max(cosine, F(1e-30)), exponent); }

fn lobe_of_four(exponent: f32, cosine: vec4f, facing: vec4f) -> vec4f {
    return pow(max(cosine, vec4f(1e-30)), vec4f(exponent));
}

//! if shine is normalised
// As above, for scenes in which some highlights are normalised: those with a negative exponent. Their colour is scaled
// so that the whole lobe reflects its share of the incoming light (Lafortune & Willems 1994).
fn lobe_scale(exponent: f32) -> f32 {
    return select(1.0, 0.5 * (phong_exponent(exponent) + 2.0), exponent < 0.0);
}

fn lobe(exponent: F, cosine: F, facing: F) -> F {
    let normalised = exponent < F(0.0);
    let plain = pow(max(cosine, F(1e-30)), select(exponent, -1.0 - exponent, normalised));
    return select(plain, plain * max(facing, F(0.0)), normalised);
}

fn lobe_of_four(exponent: f32, cosine: vec4f, facing: vec4f) -> vec4f {
    let plain = pow(max(cosine, vec4f(1e-30)), vec4f(phong_exponent(exponent)));
    return select(plain, plain * facing, exponent < 0.0);
}

//! if shine is some or normalised
// Adds the highlights' colour and exponent, and the emission, to a surface.
fn with_look(surfaces: Surfaces, rays: Rays, hits: Hits, surface: Surface, material: Material, factor: vec4f, ray: u32)
    -> Surfaces {
    var shining = surfaces;
    shining.specular = with_ray3(surfaces.specular, ray, material.specular * lobe_scale(material.exponent));
    shining.exponent = with_ray(surfaces.exponent, ray, material.exponent);
    shining.emission = with_ray3(surfaces.emission, ray, material.emission);
    return shining;
}

// Returns the highlight of a light of intensity 1. Directions from the light are unit vectors.
fn highlight(surfaces: Surfaces, from_light: F3, eye: vec3f) -> F3 {
    let to_eye = minus3(all3(eye), surfaces.point);
    let facing = -dot3(surfaces.shading_normal, from_light);
    let mirrored = add3(from_light, times3(surfaces.shading_normal, 2.0 * facing));
    let cosine = dot3(mirrored, to_eye) / sqrt(dot3(to_eye, to_eye));
    let seen = lobe(surfaces.exponent, cosine, facing);
    return times3(surfaces.specular, select(F(0.0), seen, cosine > F(0.0)));
}

// Returns the highlights of light along four rays, without the surface's colour.
fn four_highlights(rays: Four, aim: Aim, surfaces: Surfaces, eye: vec3f, ray: u32) -> FourShine {
    let to_eye = normalize(eye - of_ray3(surfaces.point, ray));
    let n = aim.shading_normal;
    // Mirrors the direction to the light about the normal. The cosine is the same as in `highlight`.
    let facing = rays.x * n.x + rays.y * n.y + rays.z * n.z;
    let back = rays.x * to_eye.x + rays.y * to_eye.y + rays.z * to_eye.z;
    let cosine = 2.0 * facing * dot(n, to_eye) - back;
    let seen = lobe_of_four(of_ray(surfaces.exponent, ray), cosine, facing);
    return FourShine(select(vec4f(0.0), seen, rays.wanted & (cosine > vec4f(0.0))), vec4f(0.0), vec4f(0.0));
}

//! if shine is facets
// Highlights by facets, for light that paths complete. They leave less light for diffuse reflection.
fn with_look(surfaces: Surfaces, rays: Rays, hits: Hits, surface: Surface, material: Material, factor: vec4f, ray: u32)
    -> Surfaces {
    let look = look_at(rays, hits, surface, material, factor, ray);
    let lobes = look.lobes;
    var shining = surfaces;
    shining.shading_normal = with_ray3(surfaces.shading_normal, ray, look.normal);
    shining.albedo = with_ray3(surfaces.albedo, ray, lobes.diffuse);
    shining.specular = with_ray3(surfaces.specular, ray, lobes.reflectance);
    shining.grazing = with_ray3(surfaces.grazing, ray, lobes.grazing);
    shining.exponent = with_ray(surfaces.exponent, ray, select(lobes.alpha, 0.0, lobes.is_glass));
    shining.emission = with_ray3(surfaces.emission, ray, look.emission);
    if COATS {
        shining.coat = with_ray(surfaces.coat, ray, lobes.coat);
        shining.coat_alpha = with_ray(surfaces.coat_alpha, ray, lobes.coat_alpha);
        shining.coat_normal = with_ray3(surfaces.coat_normal, ray, lobes.coat_normal);
    }
    return shining;
}

// Returns the highlight of a light of intensity 1, whose irradiance is pi.
fn highlight(surfaces: Surfaces, from_light: F3, eye: vec3f) -> F3 {
    let normal = surfaces.shading_normal;
    let back = minus3(all3(eye), surfaces.point);
    let to_eye = times3(back, 1.0 / sqrt(dot3(back, back)));
    let sum = minus3(to_eye, from_light);
    let half_way = times3(sum, 1.0 / sqrt(max(dot3(sum, sum), F(1e-30))));
    let facing = -dot3(normal, from_light);
    let seen = max(dot3(normal, to_eye), F(1e-4));
    let upright = clamp(dot3(normal, half_way), F(0.0), F(1.0));
    let grazing = pow(clamp(1.0 + dot3(from_light, half_way), F(0.0), F(1.0)), F(5.0));
    let color = add3(surfaces.specular, times3(surfaces.grazing, grazing));
    var shine = times3(color, facet_share(surfaces.exponent, upright, facing, seen));
    if COATS {
        let top = surfaces.coat_normal;
        let top_upright = clamp(dot3(top, half_way), F(0.0), F(1.0));
        let top_seen = max(dot3(top, to_eye), F(1e-4));
        let share = surfaces.coat * facet_share(surfaces.coat_alpha, top_upright, -dot3(top, from_light), top_seen);
        let above = share * (COAT_REFLECTANCE + (1.0 - COAT_REFLECTANCE) * grazing);
        shine = add3(shine, F3(above, above, above));
    }
    return shine;
}

// Returns the share of light that facets of reflectance 1 send to the eye, for the cosines of the angles between the
// normal and the facet, the light and the eye.
fn facet_share(alpha: F, upright: F, facing: F, seen: F) -> F {
    let squared = alpha * alpha;
    let d = upright * upright * (squared - 1.0) + 1.0;
    let a = facing * sqrt(seen * seen * (1.0 - squared) + squared);
    let b = seen * sqrt(facing * facing * (1.0 - squared) + squared);
    let share = squared * facing * 0.5 / max(d * d * (a + b), F(1e-30));
    return select(F(0.0), share, (facing > F(0.0)) & (alpha > F(LEAST_ALPHA)));
}

fn four_facet_shares(alpha: f32, upright: vec4f, facing: vec4f, seen: f32) -> vec4f {
    let squared = alpha * alpha;
    let d = upright * upright * (squared - 1.0) + 1.0;
    let a = facing * sqrt(seen * seen * (1.0 - squared) + squared);
    let b = seen * sqrt(facing * facing * (1.0 - squared) + squared);
    let share = squared * facing * 0.5 / max(d * d * (a + b), vec4f(1e-30));
    return select(vec4f(0.0), share, (facing > vec4f(0.0)) & vec4<bool>(alpha > LEAST_ALPHA));
}

fn four_highlights(rays: Four, aim: Aim, surfaces: Surfaces, eye: vec3f, ray: u32) -> FourShine {
    let to_eye = normalize(eye - of_ray3(surfaces.point, ray));
    let n = aim.shading_normal;
    let x = rays.x + to_eye.x;
    let y = rays.y + to_eye.y;
    let z = rays.z + to_eye.z;
    let scale = inverseSqrt(max(x * x + y * y + z * z, vec4f(1e-30)));
    let facing = rays.x * n.x + rays.y * n.y + rays.z * n.z;
    let upright = clamp((x * n.x + y * n.y + z * n.z) * scale, vec4f(0.0), vec4f(1.0));
    let aside = clamp((x * to_eye.x + y * to_eye.y + z * to_eye.z) * scale, vec4f(0.0), vec4f(1.0));
    let seen = max(dot(n, to_eye), 1e-4);
    let grazing = pow(1.0 - aside, vec4f(5.0));
    let shares = four_facet_shares(of_ray(surfaces.exponent, ray), upright, facing, seen);
    let plain = select(vec4f(0.0), shares, rays.wanted);
    var shine = FourShine(plain, plain * grazing, vec4f(0.0));
    if COATS {
        let top = of_ray3(surfaces.coat_normal, ray);
        let top_upright = clamp((x * top.x + y * top.y + z * top.z) * scale, vec4f(0.0), vec4f(1.0));
        let top_facing = rays.x * top.x + rays.y * top.y + rays.z * top.z;
        let top_seen = max(dot(top, to_eye), 1e-4);
        let coat = four_facet_shares(of_ray(surfaces.coat_alpha, ray), top_upright, top_facing, top_seen);
        let above = COAT_REFLECTANCE + (1.0 - COAT_REFLECTANCE) * grazing;
        shine.coat = select(vec4f(0.0), of_ray(surfaces.coat, ray) * coat * above, rays.wanted);
    }
    return shine;
}

//! if shine is none or some or normalised
// Returns the highlight's colour under light of an intensity, from the means of `FourShine`.
fn shine_color(surfaces: Surfaces, intensity: vec3f, sums: vec3f, ray: u32) -> vec3f {
    let color = of_ray3(surfaces.specular, ray) * intensity;
    return color * sums.x;
}

//! if shine is facets
fn shine_color(surfaces: Surfaces, intensity: vec3f, sums: vec3f, ray: u32) -> vec3f {
    return intensity * (of_ray3(surfaces.specular, ray) * sums.x + of_ray3(surfaces.grazing, ray) * sums.y + sums.z);
}

//! end
// If a smooth normal would reflect a ray below the surface, the ray is sent along the surface instead.
fn kept_above(mirrored: vec3f, geometric_normal: vec3f) -> vec3f {
    return mirrored + geometric_normal * max(0.0, 1e-4 - dot(mirrored, geometric_normal));
}

// Highlights along four rays: factors of a surface's `specular` and of its `grazing`, and the highlight of its coat.
struct FourShine {
    plain: vec4f,
    grazing: vec4f,
    coat: vec4f,
}

//! if mirrors is none or followed
// This kernel computes the light of all surfaces.
fn with_sends(surfaces: Surfaces, ray: u32, material: u32) -> Surfaces {
    return surfaces;
}

fn is_lit_here(surfaces: Surfaces) -> B {
    return surfaces.there;
}

//! if mirrors is listed
// Later steps compute the light of mirrors, glass and veils.
fn with_sends(surfaces: Surfaces, ray: u32, material: u32) -> Surfaces {
    var sending = surfaces;
    sending.sends = with_ray_u(surfaces.sends, ray, select(0u, 1u, sends_rays(material)));
    return sending;
}

fn is_lit_here(surfaces: Surfaces) -> B {
    return surfaces.there & (surfaces.sends == U(0u));
}

//! if mirrors is followed
// Rays that a mirror or glass sends on: unit directions, and weights that multiply what the rays see. The weight of a
// ray that does not exist is 0.
struct SentOn {
    reflected: vec3f,
    reflected_weight: vec3f,
    refracted: vec3f,
    refracted_weight: vec3f,
}

// Returns the rays that a surface sends on. The arriving ray has a unit direction and a weight.
fn sent_on(material: Material, surface: Surface, direction: vec3f, weight: vec3f) -> SentOn {
    let normal = surface.shading_normal;
    let cosine = clamp(-dot(normal, direction), 0.0, 1.0);
    var sent: SentOn;
    sent.reflected = direction + normal * (2.0 * cosine);
    if material.kind == GLASS {
        // Snell's law: eta is the index on the ray's side over the index on the other side.
        let eta = select(material.index, 1.0 / material.index, surface.from_outside);
        let squared = 1.0 - eta * eta * (1.0 - cosine * cosine);
        let inner = sqrt(max(squared, 0.0));
        var reflected = material.specular;
        var passed = 1.0 - reflected;
        if material.fresnel {
            let back = fresnel(cosine, inner, eta);
            reflected = material.specular * back;
            passed = vec3f(1.0 - back);
        }
        if squared <= 0.0 {
            reflected = vec3f(1.0);
        } else {
            sent.refracted = normalize(direction * eta + normal * (eta * cosine - inner));
            sent.refracted_weight = weight * material.transmission * passed;
        }
        sent.reflected_weight = weight * reflected;
    } else if material.kind == MIRROR {
        // Schlick's approximation, from the reflectance at normal incidence.
        let grazing = pow(1.0 - cosine, 5.0);
        let reflected = select(material.specular, mix(material.specular, vec3f(1.0), grazing), material.fresnel);
        sent.reflected_weight = weight * reflected;
    }
    return sent;
}
