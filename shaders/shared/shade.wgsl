// Diffuse shading (DESIGN, section 3): c = albedo (ambient + sum of I max(0, n.l) V), linear, clamped to 0..1.

struct Sample {
    color: vec4f,
    hit: PixelHit,
}

// One primary ray from an eye, shaded. The shading table holds the lights (position, intensity), then the albedos.
fn trace_pixel(eye: vec3f, direction: vec3f) -> Sample {
    let ray = Ray(eye, direction);
    let hit = closest_hit(ray, 0.0, FAR);
    var color = vec3f(0.0);
    if hit.primitive == MISS {
        color = sky(direction);
    } else {
        let surface = surface_at(shear(ray), hit);
        let albedo = shading_texel(2u * shading.light_count + surface.material).xyz;
        color = albedo * (shading.ambient + direct_light(surface, eye));
    }
    return Sample(vec4f(clamp(color, vec3f(0.0), vec3f(1.0)), 1.0), PixelHit(hit.t, hit.primitive));
}
