// Pass 3 of 3 of `bracket`, second part: intersects target rays with the primitives that search_tiles listed for them,
// by the same function as traversal. A nearest hit within the bound is exact, since all nearer primitives are listed
// too. A wrong bound affects the cost only. Pixels without a bound, or with a deeper hit, are listed to be traced.
//
// launch  one thread per block of 1x1 or 2x2 pixels of each listed tile, dispatched indirectly
// reads   lists        [tiles of the current rows, TILE_WORDS] after the lists
// writes  view         [height * width]      all fields except color; of unfinished pixels depth, where the ray begins
// adds    counters     [height * COUNTERS]
// appends lists        TO_TRACE; reads TO_RESOLVE

//! use boxes, bvh, camera, counters, lane, lists, marks, pixels, planes, primitive, primitives, rays, view

var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;
var<storage, read_write> lists: Lists;

// Because of rounding, unfinished pixels are traced from slightly before the bound.
const BEFORE: f32 = 0.9999;

@compute @workgroup_size(LIST_WORKGROUP)
fn resolve_tiles(@builtin(global_invocation_id) id: vec3u) {
    let block = listed_tile_pixels(TO_RESOLVE, listed_thread(id));
    let pixels = block.pixels;
    let inside = block.wanted;
    if !any_ray(inside) { return; }
    let first = pixel_of_ray(pixels, 0u);
    let tile = found_in_tile(first);
    let list = block_list(tile, block_of(first));
    let listed = lists.entries[list];
    // Pixels whose list overflowed are traced, like pixels without a bound.
    let fits = listed <= LIST_MOST;
    let bound = select(0.0, bitcast<f32>(lists.entries[tile]), fits);
    let rays = rays_of(pixels);
    var nearest = nearest_listed(rays, list + 1u, select(0u, listed, fits), pixels);
    let finished = (nearest.t <= F(bound)) | (F(bound) >= F(FAR));
    nearest.primitive = select(U(MISS), nearest.primitive, finished);
    nearest.t = select(F(bound * BEFORE), nearest.t, finished);
    keep_hits(pixels, inside, nearest);
    let mark = select(BAD, MISSED, bound == 0.0);
    let to_trace = inside & !finished;
    var place = reserve(TO_TRACE, count_rays(to_trace));
    var ray = 0u;
    loop {
        if of_ray_b(inside, ray) {
            let index = pixel_index(pixel_of_ray(pixels, ray));
            view[index].marks = select(mark, 0u, of_ray_b(finished, ray));
            if of_ray_b(to_trace, ray) {
                append(TO_TRACE, place, index);
                place += 1u;
            }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    if any_ray(to_trace) {
        atomicAdd(
            &counters[first.y * COUNTERS + select(BAD_PIXELS, MISSED_PIXELS, bound == 0.0)],
            count_rays(to_trace),
        );
    }
    count_pixel(first);
    count_view(first.y, 0u, nodes_visited, primitives_tested);
}

// Returns the nearest hits among the planes and `count` listed primitives.
fn nearest_listed(rays: Rays, first: u32, count: u32, pixels: Pixels) -> Hits {
    let scales = scales_of(rays);
    let bits = U(1u) << (FIRST_PIXEL_BIT + (pixels.x & U(1u)) + 2u * (pixels.y & U(1u)));
    var nearest = nearest_plane(rays, F(0.0), F(FAR));
    var put_off = PutOff();
    var place = 0u;
    loop {
        loop {
            if place >= count { break; }
            let entry = lists.entries[first + place];
            var waiting = false;
            // The four rays of a block need nearly all primitives of its list.
            if RAYS > 1u || any_ray((U(entry) & bits) != U(0u)) {
                if COUNT { primitives_tested += 1u; }
                let slot = entry & FIRST_SLOT;
                let primitive = primitive_at(slot);
                let test = intersect(primitive, rays, scales, F(0.0));
                let hit = test.hit & is_nearer(nearest, test.t, F(0.0), primitive.id);
                nearest.t = select(nearest.t, test.t, hit);
                nearest.primitive = select(nearest.primitive, U(primitive.id), hit);
                nearest.slot = select(nearest.slot, U(slot), hit);
                let doubted = bits_of(test.doubtful);
                waiting = is_too_many(put_off, doubted);
                if !waiting { put_off = put_off_also(put_off, slot, doubted); }
            }
            if waiting { break; }
            place += 1u;
        }
        nearest = settled(nearest, rays, F(0.0), put_off, false);
        put_off = PutOff();
        if place >= count { break; }
        // The repeated test is not counted.
        if COUNT { primitives_tested -= 1u; }
    }
    return nearest;
}
