// Infinite planes. They are few, and the tree's boxes do not contain them. Planes have the first slots. Every ray tests
// all planes before traversal, and their nearest hit limits the traversal. Planes have the largest ids, so at equal t a
// primitive of the tree wins.

//! use bvh, camera, counters, double_float, fetch, in_steps, lane, pixels, primitive, primitives, ray_queries, rays
//! use textures, tiles

//! if planes is none
// There are no planes.

fn nearest_plane(rays: Rays, t_min: F, t_max: F) -> Hits {
    return Hits(t_max, U(MISS), U(0u));
}

fn meets_planes(tile: Tile) -> bool {
    return false;
}

// Intersects rays with a primitive of any kind.
fn met_at(slot: u32, rays: Rays) -> Found {
    return intersect(primitive_at(slot), rays, scales_of(rays), F(0.0));
}

//! if planes is some
// Texels of a plane. The first has a point and the id, the second the unit normal and the component. The third has an
// axis and the material. The dot product of the axis and an offset is the texture coordinate u.

// Maximum distance of a plane's hit from the ray's origin. Rays that start at farther hits could not be tested against
// the tree's boxes.
const PLANE_REACH: f32 = 1e8;

// Returns the signed distance from a point to a plane, along the plane's normal. It is computed in sums of two f32,
// since the plane's own point may be far from the hit.
fn plane_above(slot: u32, origin: vec3f) -> f32 {
    let point = bitcast<vec3f>(primitive_texel(slot, 0u).xyz);
    let normal = bitcast<vec3f>(primitive_texel(slot, 1u).xyz);
    return dot_two3(Two3(normal, vec3f(0.0)), difference3(point, origin)).hi;
}

// Intersects rays with a plane. Rays that begin in the plane or run along it miss it. t is negative for rays that point
// away from the plane.
fn intersect_plane(slot: u32, rays: Rays) -> Found {
    let above = plane_above(slot, rays.origin);
    let across = along(rays.direction, bitcast<vec3f>(primitive_texel(slot, 1u).xyz));
    let length = sqrt(dot3(rays.direction, rays.direction));
    let hit = B(above != 0.0) & (abs(across) * PLANE_REACH >= abs(above) * length);
    return Found(hit, F(above) / select(F(1.0), across, hit), B(false));
}

// Returns the nearest hits of planes with t in [t_min, t_max], like closest_hit.
fn nearest_plane(rays: Rays, t_min: F, t_max: F) -> Hits {
    var hits = Hits(t_max, U(MISS), U(0u));
    var slot = 0u;
    loop {
        let found = intersect_plane(slot, rays);
        let id = primitive_texel(slot, 0u).w;
        let hit = found.hit & is_nearer(hits, found.t, t_min, id);
        hits.t = select(hits.t, found.t, hit);
        hits.primitive = select(hits.primitive, U(id), hit);
        hits.slot = select(hits.slot, U(slot), hit);
        slot += 1u;
        if slot >= PLANES { break; }
    }
    cut_short |= slot < PLANES;
    if COUNT { primitives_tested += PLANES; }
    return hits;
}

// Returns whether each ray hits anything with t in [t_min, t_max].
fn any_hit(rays: Rays, t_min: F, t_max: F) -> B {
    return any_slot(rays, t_min, t_max) != U(MISS);
}

fn plane_surface(rays: Rays, hits: Hits, ray: u32) -> Surface {
    let slot = of_ray_u(hits.slot, ray);
    let second = primitive_texel(slot, 1u);
    let material = primitive_texel(slot, 2u).w;
    let direction = of_ray3(rays.direction, ray);
    let outward = bitcast<vec3f>(second.xyz);
    let normal = towards_viewer(outward, direction);
    return Surface(normal, normal, material, second.w, 0.0, vec3f(0.0), 0.0, dot(outward, direction) < 0.0);
}

// Returns a texture's colour and alpha on a plane. For a picture the footprint is computed as in lookup_at, but without
// a limit on the angle. A checkerboard is integrated over a box that encloses the pixel's footprint, along the
// texture's axes.
// Near the horizon the footprint is far longer than wide. Along a unit vector e in the plane, the footprint of a disc
// extends to sqrt(1 + (e.d / n.d)^2) of its radius. Here d is the ray's direction.
fn plane_color(rays: Rays, hits: Hits, ray: u32, head_at: u32) -> vec4f {
    let slot = of_ray_u(hits.slot, ray);
    let point = bitcast<vec3f>(primitive_texel(slot, 0u).xyz);
    let normal = bitcast<vec3f>(primitive_texel(slot, 1u).xyz);
    let u = bitcast<vec3f>(primitive_texel(slot, 2u).xyz);
    let v = cross(normal, u);
    let direction = of_ray3(rays.direction, ray);
    let from_point = direction * of_ray(hits.t, ray) - (point - rays.origin);
    let uv = vec2f(dot(from_point, u), dot(from_point, v));
    let width = footprint(of_ray(hits.t, ray) + of_ray(travelled_before, ray), direction);
    let slope = max(abs(dot(normal, direction)), 1e-9);
    let head = table_texel(head_at);
    if (head.x & 15u) != CHECKERBOARD {
        return texture_color(head_at, Lookup(uv, width * inverseSqrt(slope) * length(u), false));
    }
    let slants = vec2f(dot(direction, u), dot(direction, v)) / slope;
    let widths = min(width * sqrt(dot(u, u) + slants * slants) * f32(head.z), vec2f(64.0));
    let wrap = head.x >> 4u;
    let place = vec2f(near_unit(uv.x, wrap), near_unit(uv.y, wrap)) * f32(head.z);
    let waves = wave_mean(place.x, widths.x, i32(head.z), wrap) * wave_mean(place.y, widths.y, i32(head.z), wrap);
    return mix(
        bitcast<vec4f>(table_texel(head.y)),
        bitcast<vec4f>(table_texel(head.y + 1u)),
        0.5 - 0.5 * waves,
    );
}

//! if planes is some and primitives is triangles or spheres or mixed
fn closest_hit(rays: Rays, t_min: F, t_max: F) -> Hits {
    let plane = nearest_plane(rays, t_min, t_max);
    let hits = traverse(rays, t_min, plane.t, false);
    forget_planes();
    let nearer = hits.primitive != U(MISS);
    return Hits(hits.t, select(plane.primitive, hits.primitive, nearer), select(plane.slot, hits.slot, nearer));
}

// A ray that hits a plane is not traced through the tree.
fn any_slot(rays: Rays, t_min: F, t_max: F) -> U {
    let plane = nearest_plane(rays, t_min, t_max);
    let open = plane.primitive == U(MISS);
    let hits = traverse(rays, t_min, select(F(NEVER), t_max, open), true);
    forget_planes();
    return select(plane.slot, hits.slot, open);
}

// A traversal that resumes in the next dispatch tests the planes again, so they are not counted now.
fn forget_planes() {
    if COUNT && paused { primitives_tested -= PLANES; }
}

fn met_at(slot: u32, rays: Rays) -> Found {
    if slot < PLANES { return intersect_plane(slot, rays); }
    return intersect(primitive_at(slot), rays, scales_of(rays), F(0.0));
}

fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    if of_ray_u(hits.slot, ray) < PLANES { return plane_surface(rays, hits, ray); }
    return surface_in_tree(rays, hits, ray);
}

//! if planes is some and primitives is none
fn closest_hit(rays: Rays, t_min: F, t_max: F) -> Hits {
    return nearest_plane(rays, t_min, t_max);
}

fn any_slot(rays: Rays, t_min: F, t_max: F) -> U {
    let plane = nearest_plane(rays, t_min, t_max);
    return select(plane.slot, U(MISS), plane.primitive == U(MISS));
}

fn met_at(slot: u32, rays: Rays) -> Found {
    return intersect_plane(slot, rays);
}

fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return plane_surface(rays, hits, ray);
}
