// Common functions for all kinds of primitives. In scenes with ellipsoids, spheres are stored as ellipsoids
// (ellipsoid.wgsl).

//! use cutouts, ellipsoid, fetch, lane, primitive, rays, sphere, triangle

//! if primitives is triangles
fn intersect(primitive: Primitive, rays: Rays, scales: Scales, t_min: F) -> Found {
    return at_first_look(primitive, intersect_triangle(rays, scales, primitive));
}

fn look_again(primitive: Primitive, origin: vec3f, direction: vec3f, t_min: f32) -> f32 {
    return look_again_triangle(origin, direction, primitive);
}

//! if primitives is triangles and planes is none
fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return triangle_surface(rays, hits, ray);
}

//! if primitives is triangles and planes is some
fn surface_in_tree(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return triangle_surface(rays, hits, ray);
}

//! if primitives is spheres
fn intersect(primitive: Primitive, rays: Rays, scales: Scales, t_min: F) -> Found {
    return intersect_sphere(rays, scales, primitive, t_min);
}

fn look_again(primitive: Primitive, origin: vec3f, direction: vec3f, t_min: f32) -> f32 {
    if CLOSE { return look_again_sphere(origin, direction, primitive, t_min); }
    return -1.0;
}

//! if primitives is spheres and planes is none
fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return sphere_surface(rays, hits, ray);
}

//! if primitives is spheres and planes is some
fn surface_in_tree(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return sphere_surface(rays, hits, ray);
}

//! if primitives is mixed
// The lowest bit of the second texel's w distinguishes spheres from triangles.

fn is_sphere(primitive: Primitive) -> bool {
    return (primitive.component & IS_SPHERE) != 0u;
}

// Runs both tests and selects a result. Software adapters always run both sides of a branch, and a select is cheaper.
fn intersect(primitive: Primitive, rays: Rays, scales: Scales, t_min: F) -> Found {
    let sphere = intersect_sphere(rays, scales, primitive, t_min);
    let triangle = at_first_look(primitive, intersect_triangle(rays, scales, primitive));
    let round = B(is_sphere(primitive));
    return Found(
        select(triangle.hit, sphere.hit, round),
        select(triangle.t, sphere.t, round),
        select(triangle.doubtful, sphere.doubtful, round),
    );
}

fn look_again(primitive: Primitive, origin: vec3f, direction: vec3f, t_min: f32) -> f32 {
    if CLOSE && is_sphere(primitive) { return look_again_sphere(origin, direction, primitive, t_min); }
    return look_again_triangle(origin, direction, primitive);
}

//! if primitives is mixed and planes is none
fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    if (primitive_texel(of_ray_u(hits.slot, ray), 1u).w & IS_SPHERE) != 0u {
        return sphere_surface(rays, hits, ray);
    }
    return triangle_surface(rays, hits, ray);
}

//! if primitives is mixed and planes is some
fn surface_in_tree(rays: Rays, hits: Hits, ray: u32) -> Surface {
    if (primitive_texel(of_ray_u(hits.slot, ray), 1u).w & IS_SPHERE) != 0u {
        return sphere_surface(rays, hits, ray);
    }
    return triangle_surface(rays, hits, ray);
}

//! if primitives is none and planes is none
fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return Surface(vec3f(0.0), vec3f(0.0), 0u, 0u, 0.0, vec3f(0.0), 0.0, true);
}
