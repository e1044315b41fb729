// A scene without primitives: no traversal in the kernel, nothing is ever hit.

struct Bvh { grid_origin: vec3f, extent: f32, grid_cell: vec3f, _pad: u32 }
struct Ray { origin: vec3f, direction: vec3f }
struct Hit { t: f32, primitive: u32, slot: u32 }
struct ShearedRay { origin: vec3f, direction: vec3f }
struct Surface { point: vec3f, geometric_normal: vec3f, shading_normal: vec3f, material: u32 }

override COUNT: bool = false;
const nodes_visited: u32 = 0u;
const primitives_tested: u32 = 0u;
var<private> cut_short: bool;

fn shear(ray: Ray) -> ShearedRay {
    return ShearedRay(ray.origin, ray.direction);
}

fn surface_at(ray: ShearedRay, hit: Hit) -> Surface {
    return Surface(ray.origin, vec3f(0.0), vec3f(0.0), 0u);
}

fn closest_hit(ray: Ray, t_min: f32, t_max: f32) -> Hit {
    return Hit(t_max, MISS, 0u);
}

fn any_hit(ray: Ray, t_min: f32, t_max: f32) -> bool {
    return false;
}
