// Pass 2 of 3 of `bracket` if shadow bits are reused, second part: marks busy lights (docs/BRACKET.md). A light is busy
// where its shadows are very narrow. There the two samples beside a point do not determine the visibility between them.
//
// A sample is busy for a light if its bit differs from samples on both sides of it in its row. The sample then lies in
// a shadow, or in a strip of light, about as narrow as the distance between samples. Samples of other rows may miss
// that strip. So if the sample is on a flat surface, tiles around its landing position reuse no bit of that light. Busy
// samples on other surfaces lie in narrow shadows of their own.
//
// launch  one thread per run of BUSY_RUN pixels of a row of the source
// reads   source_samples  texture
// adds    bounds          [tiles, BOUND_WORDS]  one bit per busy light, and from bit 16 on one per busy share

//! use busy, camera, frame, pixels, source_samples, tiles

var<storage, read_write> bounds: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn mark_busy(@builtin(global_invocation_id) id: vec3u) {
    let row = launched_row(id) + frame.band.row_begin;
    let begin = id.x * BUSY_RUN;
    if begin >= frame.band.size.x || row >= frame.band.row_end { return; }
    let end = min(begin + BUSY_RUN, frame.band.size.x);
    // One bit for each column whose sample is busy for some light. Few samples are busy.
    var busy_columns = 0u;
    var samples = samples_around(row, begin);
    var column = begin;
    loop {
        if busy_lights(samples).all != 0u { busy_columns |= 1u << (column - begin); }
        column += 1u;
        if column >= end { break; }
        samples = moved_on(samples, sample_in_row(row, column, 2));
    }
    loop {
        if busy_columns == 0u { break; }
        mark(row, begin + firstTrailingBit(busy_columns));
        busy_columns &= busy_columns - 1u;
    }
}

fn samples_around(row: u32, column: u32) -> Neighbourhood {
    return Neighbourhood(
        sample_in_row(row, column, -2),
        sample_in_row(row, column, -1),
        sample_in_row(row, column, 0),
        sample_in_row(row, column, 1),
        sample_in_row(row, column, 2),
    );
}

// Marks the tiles around the landing position of a sample.
fn mark(row: u32, column: u32) {
    let samples = samples_around(row, column);
    if !is_flat(samples.before, samples.here, samples.after, width_of(1.0)) { return; }
    let busy = busy_lights(samples);
    let x = landing_x(vec2u(column, row), samples.here.depth);
    mark_tiles(row, x, REACH_OF_LIGHT, busy.all);
    if is_flat(samples.far_before, samples.here, samples.far_after, width_of(2.0)) {
        mark_tiles(row, x, REACH_OF_SHADOW, busy.dark);
    }
}

// Returns the sample `offset` columns away. Outside the picture the sample has no known bits.
fn sample_in_row(row: u32, column: u32, offset: i32) -> SourceSample {
    let place = i32(column) + offset;
    let inside = (place >= 0) & (place < i32(frame.band.size.x));
    let sample = source_sample(vec2u(u32(select(0, place, inside)), row));
    let component = select(MISS, sample.component, inside);
    return SourceSample(sample.depth, sample.other, component, select(0u, sample.bits, inside));
}

fn mark_tiles(row: u32, x: f32, reach: f32, busy: u32) {
    mark_within(row, x, reach, busy);
    if columns_before() > 0u { mark_within(row, x + f32(columns_before()), reach, busy); }
}

fn mark_within(row: u32, x: f32, reach: f32, busy: u32) {
    let low = max(x - reach, 0.0);
    let high = min(x + reach, f32(frame.band.size.x) - 0.5);
    if busy == 0u || !(low <= high) { return; }
    let first = row / TILE * tiles_across();
    var tile = u32(low) / TILE;
    loop {
        atomicOr(&bounds[BOUND_WORDS * (first + tile) + 1u], busy);
        tile += 1u;
        if tile > u32(high) / TILE { break; }
    }
}
