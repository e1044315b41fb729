// Cut-outs: triangles whose surface is there only where a mask says so.
//
// What hits such a triangle is put off, as what is doubtful is, and the second look, one ray at a time, asks the mask. So the first test costs what
// it costs without masks, which are read for hits alone, and there is one place that says where a surface is: whatever ray asks for
// it, of either eye, gets one answer.

//! if cutouts is some
struct Bvh {
    grid_origin: vec3f,
    extent: f32,
    grid_cell: vec3f,
    zero: u32,
    cutouts: u32,         // texel of the first material's mask head: src/cutouts.rs
}

// As without cut-outs (bvh.wgsl), but for the masks.
fn settled_by_one(before: Hits, rays: Rays, t_min: F, doubtful: u32, any_is_enough: bool) -> Hits {
    var hits = before;
    var left = with_bits(doubtful);
    let slot = doubtful >> RAY_BITS;
    let primitive = primitive_at(slot);
    loop {
        let ray = first_ray(left);
        let direction = of_ray3(rays.direction, ray);
        var t = look_again(primitive, rays.origin, direction, of_ray(t_min, ray));
        if is_cut_out(primitive) && !has_surface(slot, rays.origin, direction) { t = -1.0; }
        let chosen = RAY_INDEX == U(ray);
        let hit = chosen & left & is_nearer(hits, F(t), t_min, primitive.id);
        hits.t = select(hits.t, select(F(t), F(NEVER), any_is_enough), hit);
        hits.primitive = select(hits.primitive, U(primitive.id), hit & B(!any_is_enough));
        hits.slot = select(hits.slot, U(slot), hit);
        left &= !chosen;
        if !any_ray(left) { break; }
    }
    return hits;
}

//! if tests is cut_triangles
fn intersect(primitive: Primitive, rays: Rays, scales: Scales, t_min: F) -> Found {
    return put_off_if_cut_out(primitive, intersect_triangle(rays, scales, primitive));
}

//! if tests is cut_mixed
fn intersect(primitive: Primitive, rays: Rays, scales: Scales, t_min: F) -> Found {
    let sphere = intersect_sphere(rays, scales, primitive, t_min);
    let triangle = put_off_if_cut_out(primitive, intersect_triangle(rays, scales, primitive));
    let round = B(is_sphere(primitive));
    return Found(
        select(triangle.hit, sphere.hit, round),
        select(triangle.t, sphere.t, round),
        select(triangle.doubtful, sphere.doubtful, round),
    );
}

//! if fetch is buffer
fn geometry_texel(index: u32) -> vec4u {
    return geometry[index];
}

//! if fetch is texture
fn geometry_texel(index: u32) -> vec4u {
    return textureLoad(geometry, texel_position(index));
}

//! end
// Highest bit of a component: of a triangle that is cut out. So its component is not that of a neighbour that is whole.
const IS_CUT_OUT: u32 = 0x80000000u;

fn is_cut_out(primitive: Primitive) -> bool {
    return (primitive.component & IS_CUT_OUT) != 0u;
}

fn put_off_if_cut_out(primitive: Primitive, found: Found) -> Found {
    let cut_out = B(is_cut_out(primitive));
    return Found(found.hit & !cut_out, found.t, found.doubtful | (found.hit & cut_out));
}

// Pixels of a mask that a texel holds, a bit each.
const MASK_PIXELS: u32 = 128u;

// Whether a triangle that a ray meets has a surface there: the pixel says in which it lies. A mask's head has its first texel, counted
// from the first head on, its width, height and wrap. Rows are counted from below, as v is.
fn has_surface(slot: u32, origin: vec3f, direction: vec3f) -> bool {
    let weights = corner_weights(Rays(origin, all3(direction)), triangle_corners(slot), 0u);
    let corners = triangle_uv(slot);
    let uv = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
    let head = geometry_texel(bvh.cutouts + (primitive_texel(slot, 2u).w & MATERIAL));
    let size = vec2i(head.yz);
    let place = vec2i(floor(vec2f(near_unit(uv.x, head.w), near_unit(uv.y, head.w)) * vec2f(size)));
    let pixel = u32(wrapped(place.y, size.y, head.w) * size.x + wrapped(place.x, size.x, head.w));
    let words = geometry_texel(bvh.cutouts + head.x + pixel / MASK_PIXELS);
    return (words[(pixel / 32u) % 4u] & (1u << (pixel % 32u))) != 0u;
}
