// Omnidirectional point lights, each with a shadow ray (DESIGN, section 3).

// A shadow ray starts off the surface by these shares of its point's distance from the eye and from the world's origin:
// what the point's rounding grows with. So they hold for tiny scenes and far from the origin; docs/ARCHITECTURE.md has
// the measurement.
const OFFSET_BY_DISTANCE: f32 = 1.0 / 131072.0;
const OFFSET_BY_PLACE: f32 = 1.0 / 2097152.0;

var<private> shadow_rays: u32;

fn direct_light(surface: Surface, eye: vec3f) -> vec3f {
    let reach = abs(surface.point) * OFFSET_BY_PLACE + abs(surface.point - eye) * OFFSET_BY_DISTANCE;
    let offset = max(max(reach.x, reach.y), reach.z);
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
    cut_short |= light < shading.light_count;
    return sum;
}
