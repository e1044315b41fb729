// Traces and shades one view like trace_left.wgsl, in as many dispatches as necessary (shared/in_steps.wgsl).
//
// launch  one thread per block of 1x1 or 2x2 pixels of the current rows, until all have finished
// updates steps     one lane per thread of the launch
// writes  view      [height * width]
// adds    counters  [height * COUNTERS], and the cost map after them, if requested

//! use bvh, camera, counters, dice, frame, in_steps, lane, pixels, planes, rays, shade, stack, surfaces, view, wanted

var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

// Returns a thread's lane. Lanes follow the launch row by row, in whole workgroups.
fn lane_of(id: vec3u) -> u32 {
    let workgroups = (frame.band.size.x + WORKGROUP * BLOCK.x - 1u) / (WORKGROUP * BLOCK.x);
    return launched_row(id) * workgroups * WORKGROUP + id.x;
}

fn seen_by(rays: Rays, wanted: B) -> Hits {
    if steps.lanes[lane].stage != 0u { return steps.lanes[lane].seen; }
    let seen = closest_hit(rays, F(0.0), select(F(NEVER), F(FAR), wanted));
    if !paused {
        steps.lanes[lane].seen = seen;
        steps.lanes[lane].stage = 1u;
    }
    return seen;
}

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn trace_in_steps(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let pixels = block_pixels(id);
    let wanted = inside_rows(pixels);
    if !any_ray(wanted) || !begin_step(lane_of(id)) { return; }
    let rays = rays_of(pixels);
    let seen = seen_by(rays, wanted);
    if !paused {
        let samples = shade(rays, seen, surfaces_at(rays, seen));
        if !paused { keep_view(pixels, wanted, samples); }
    }
    end_step();
    let first = pixel_of_ray(pixels, 0u);
    count_pixel(first);
    count_view(first.y, rays_asked() - to_count_again, nodes_visited, primitives_tested);
}
