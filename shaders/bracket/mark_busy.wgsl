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

//! use bits, camera, frame, pixels, source_samples, tiles

var<storage, read_write> bounds: array<atomic<u32>>;

// Distances on both sides within which tiles are marked, in pixels. REACH_OF_SHADOW is for a shadowed sample whose
// surface is flat for two samples on both sides. REACH_OF_LIGHT is for any busy sample whose surface is flat for one
// sample on both sides.
const REACH_OF_SHADOW: f32 = 32.0;
const REACH_OF_LIGHT: f32 = 12.0;
// A surface is flat if a sample deviates from the line between its neighbours by less than this share of their
// distance.
const FLAT: f32 = 1.0 / 32.0;

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
        let next = sample_in_row(row, column, 2);
        samples = Samples(samples.before, samples.here, samples.after, samples.far_after, next);
    }
    loop {
        if busy_columns == 0u { break; }
        mark(row, begin + firstTrailingBit(busy_columns));
        busy_columns &= busy_columns - 1u;
    }
}

// A sample, and two on each side of it in its row.
struct Samples {
    far_before: SourceSample,
    before: SourceSample,
    here: SourceSample,
    after: SourceSample,
    far_after: SourceSample,
}

fn samples_around(row: u32, column: u32) -> Samples {
    return Samples(
        sample_in_row(row, column, -2),
        sample_in_row(row, column, -1),
        sample_in_row(row, column, 0),
        sample_in_row(row, column, 1),
        sample_in_row(row, column, 2),
    );
}

// The lights for which a sample is busy, and the subset whose shadow contains the sample.
struct Busy {
    all: u32,
    dark: u32,
}

fn busy_lights(s: Samples) -> Busy {
    let unlike_before = unlike(s.here, s.before) | unlike(s.here, s.far_before);
    let all = unlike_before & (unlike(s.here, s.after) | unlike(s.here, s.far_after));
    let dark = all & ~s.here.bits;
    if !KEEP_SHARES { return Busy(all, dark); }
    let dark_shares = busy_shares(s, false);
    return Busy(all | dark_shares | busy_shares(s, true), dark | dark_shares);
}

// Marks the tiles around the landing position of a sample.
fn mark(row: u32, column: u32) {
    let samples = samples_around(row, column);
    if !is_flat(samples.before, samples.here, samples.after, 1.0) { return; }
    let busy = busy_lights(samples);
    let x = landing_x(column, samples.here.depth);
    mark_tiles(row, x, REACH_OF_LIGHT, busy.all);
    if is_flat(samples.far_before, samples.here, samples.far_after, 2.0) {
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

// Returns the lights whose bits differ between two samples of one component.
fn unlike(a: SourceSample, b: SourceSample) -> u32 {
    let asked = (a.bits & b.bits) >> 16u;
    return select(0u, asked & (a.bits ^ b.bits), a.component == b.component);
}

// Returns whether three samples, `apart` pixels from one to the next, show a flat surface. On a flat surface the
// reciprocals of the depths lie on a line.
fn is_flat(a: SourceSample, b: SourceSample, c: SourceSample, apart: f32) -> bool {
    let off = abs(b.depth / a.depth + b.depth / c.depth - 2.0);
    return a.component == b.component && c.component == b.component && off < FLAT * apart * column_step();
}

fn mark_tiles(row: u32, x: f32, reach: f32, busy: u32) {
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

// Returns one bit, from 16 on, for each busy share. Without `lit`, a share of at most half is busy between samples that
// see all of the source. With `lit`, a share of at least half is busy between samples that see none of it.
fn busy_shares(s: Samples, lit: bool) -> u32 {
    let beside = select(ALL_OPEN, 0u, lit);
    var busy = 0u;
    var slot = 0u;
    loop {
        let share = share_in(s.here, slot);
        let half = select(share <= ALL_OPEN / 2u, share >= ALL_OPEN / 2u && share != UNASKED, lit);
        let one = is_share(s.here, s.before, slot, beside) || is_share(s.here, s.far_before, slot, beside);
        let other = is_share(s.here, s.after, slot, beside) || is_share(s.here, s.far_after, slot, beside);
        busy |= select(0u, 1u << (16u + slot), half && one && other);
        slot += 1u;
        if slot >= SHARES { break; }
    }
    return busy;
}

fn share_in(sample: SourceSample, slot: u32) -> u32 {
    return (sample.other >> (SHARE_BITS * slot)) & UNASKED;
}

// Returns whether a sample has the same component as another one, and this share.
fn is_share(here: SourceSample, sample: SourceSample, slot: u32, share: u32) -> bool {
    return sample.component == here.component && share_in(sample, slot) == share;
}
