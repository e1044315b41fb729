// Omnidirectional point lights, each with a shadow ray (DESIGN, section 3).

// A shadow ray starts this share of its point's size and depth off the surface. The point's rounding grows with both,
// so the share holds for tiny scenes and for those far from the origin; docs/ARCHITECTURE.md has the measurement.
const SHADOW_OFFSET: f32 = 1.0 / 65536.0;

var<private> shadow_rays: u32;

fn direct_light(surface: Surface, eye: vec3f) -> vec3f {
    let reach = abs(surface.point) + abs(surface.point - eye);
    let offset = SHADOW_OFFSET * max(max(reach.x, reach.y), reach.z);
    let origin = surface.point + surface.geometric_normal * offset;
    var sum = vec3f(0.0);
    var light = 0u;
    loop {
        let position = shading_texel(2u * light).xyz;
        let intensity = shading_texel(2u * light + 1u).xyz;
        let to_light = position - origin;
        let distance = length(to_light);
        let cosine = dot(surface.shading_normal, to_light) / distance;
        // Behind the triangle itself there is no light, whatever a smooth normal says.
        if cosine > 0.0 && dot(surface.geometric_normal, to_light) > 0.0 {
            shadow_rays += 1u;
            if !any_hit(Ray(origin, to_light), 0.0, 1.0) {
                sum += intensity * cosine;
            }
        }
        light += 1u;
        if light >= shading.light_count { break; }
    }
    return sum;
}
