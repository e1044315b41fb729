// Marks busy lights by the samples of an earlier frame, as mark_busy.wgsl does by those of a source view. A sample is
// compared with those beside it in its row and in its column. Tiles on both sides of its place in the view are marked
// along the same direction.
//
// launch  one thread per run of WORKGROUP samples of a row; threads of rows below the picture take part too
// reads   history         [height + 1, width]
// adds    history_bounds  [tiles, BOUND_WORDS]  one bit per busy light, and from bit 16 on one per busy share

//! use busy, history, pixels, source_samples, tiles

var<storage, read_write> history_bounds: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn mark_busy_by_history(@builtin(global_invocation_id) id: vec3u) {
    let begin = vec2u(id.x * WORKGROUP, launched_row(id));
    mark_run(begin, vec2u(1u, 0u));
    // The threads of WORKGROUP rows take the columns of a square, one each.
    let row = begin.y % WORKGROUP;
    mark_run(begin + vec2u(row, 0u) - vec2u(0u, row), vec2u(0u, 1u));
}

// Marks tiles by the busy samples of a run in this direction.
fn mark_run(begin: vec2u, step: vec2u) {
    if any(begin >= history_size()) { return; }
    // One bit for each busy sample. Few samples are busy.
    var busy = 0u;
    var samples = samples_around(begin, step);
    var index = 0u;
    loop {
        if busy_lights(samples).all != 0u { busy |= 1u << index; }
        index += 1u;
        if index >= WORKGROUP { break; }
        samples = moved_on(samples, earlier_sample(vec2i(begin + (index + 2u) * step)));
    }
    loop {
        if busy == 0u { break; }
        mark(begin + firstTrailingBit(busy) * step, step);
        busy &= busy - 1u;
    }
}

fn samples_around(pixel: vec2u, step: vec2u) -> Neighbourhood {
    let at = vec2i(pixel);
    let along = vec2i(step);
    return Neighbourhood(
        earlier_sample(at - 2 * along),
        earlier_sample(at - along),
        earlier_sample(at),
        earlier_sample(at + along),
        earlier_sample(at + 2 * along),
    );
}

// Marks the tiles around the place of a busy sample in the view.
fn mark(pixel: vec2u, step: vec2u) {
    let samples = samples_around(pixel, step);
    let eye = earlier_eye();
    let apart = length(select(eye.step_x, eye.step_y, step.y != 0u));
    if !is_flat(samples.before, samples.here, samples.after, apart) { return; }
    let landed = landed_of(eye, pixel);
    if landed.depth <= 0.0 { return; }
    // The step's direction in the view.
    let ahead = landed_of(eye, min(pixel + step, history_size() - 1u));
    let along = select(vec2f(step), normalize(ahead.place - landed.place), distance(ahead.place, landed.place) > 1e-3);
    let busy = busy_lights(samples);
    mark_tiles(landed.place, along * REACH_OF_LIGHT, busy.all);
    if is_flat(samples.far_before, samples.here, samples.far_after, 2.0 * apart) {
        mark_tiles(landed.place, along * REACH_OF_SHADOW, busy.dark);
    }
}

// Returns the sample at a place. Outside the picture the sample has no known bits.
fn earlier_sample(place: vec2i) -> SourceSample {
    let inside = all(place >= vec2i(0)) && all(place < vec2i(history_size()));
    let texel = textureLoad(history, vec2u(select(vec2i(0), place, inside)), 0);
    return SourceSample(
        bitcast<f32>(texel.x),
        texel.y,
        select(MISS, texel.z, inside),
        select(0u, texel.w, inside),
    );
}

// Marks the tiles in the box around a line through a place, to this distance on both sides.
fn mark_tiles(place: vec2f, reach: vec2f, busy: u32) {
    let limit = vec2f(history_size());
    let low = place - abs(reach);
    let high = place + abs(reach);
    if busy == 0u || !(all(high > vec2f(0.0)) && all(low < limit)) { return; }
    let first = vec2u(max(low, vec2f(0.0))) / TILE;
    let last = vec2u(min(high, limit - 0.5)) / TILE;
    var at = first;
    loop {
        atomicOr(&history_bounds[BOUND_WORDS * (at.y * tiles_across() + at.x) + 1u], busy);
        at.x += 1u;
        if at.x > last.x {
            at = vec2u(first.x, at.y + 1u);
            if at.y > last.y { break; }
        }
    }
}
