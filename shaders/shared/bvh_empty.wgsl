// A scene without primitives: no traversal in the kernel, nothing is ever hit.

struct Rays { origin: vec3f, direction: F3 }
struct Hits { t: F, primitive: U, slot: U }
alias Stack = array<u32, STACK_SIZE>;
struct Surface { geometric_normal: vec3f, shading_normal: vec3f, material: u32, component: u32, reach: f32 }

const NEVER: f32 = -3.402e38;
override COUNT: bool = false;
const nodes_visited: u32 = 0u;
const primitives_tested: u32 = 0u;
var<private> cut_short: bool;

fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return Surface(vec3f(0.0), vec3f(0.0), 0u, 0u, 0.0);
}

fn closest_hit(rays: Rays, t_min: F, t_max: F) -> Hits {
    return Hits(t_max, U(MISS), U(0u));
}

fn any_hit(rays: Rays, t_min: F, t_max: F) -> B {
    return t_max < t_max;
}
