// Busy lights: lights whose shadows are so narrow that the samples beside a point do not determine the visibility
// between them (docs/BRACKET.md).

//! use bits, source_samples

// Distances on both sides within which tiles are marked, in pixels. REACH_OF_SHADOW is for a shadowed sample whose
// surface is flat for two samples on both sides. REACH_OF_LIGHT is for any busy sample whose surface is flat for one
// sample on both sides.
const REACH_OF_SHADOW: f32 = 32.0;
const REACH_OF_LIGHT: f32 = 12.0;
// A surface is flat if a sample deviates from the line between its neighbours by less than this share of their
// distance.
const FLAT: f32 = 1.0 / 32.0;

// A sample, and two on each side of it in its row or column.
struct Neighbourhood {
    far_before: SourceSample,
    before: SourceSample,
    here: SourceSample,
    after: SourceSample,
    far_after: SourceSample,
}

// Returns the neighbourhood of the sample after this one. `next` becomes its last sample.
fn moved_on(s: Neighbourhood, next: SourceSample) -> Neighbourhood {
    return Neighbourhood(s.before, s.here, s.after, s.far_after, next);
}

// The lights for which a sample is busy, and the subset whose shadow contains the sample.
struct Busy {
    all: u32,
    dark: u32,
}

fn busy_lights(s: Neighbourhood) -> Busy {
    let unlike_before = unlike(s.here, s.before) | unlike(s.here, s.far_before);
    let all = unlike_before & (unlike(s.here, s.after) | unlike(s.here, s.far_after));
    let dark = all & ~s.here.bits;
    if !KEEP_SHARES { return Busy(all, dark); }
    let dark_shares = busy_shares(s, false);
    return Busy(all | dark_shares | busy_shares(s, true), dark | dark_shares);
}

// Returns the lights whose bits differ between two samples of one component.
fn unlike(a: SourceSample, b: SourceSample) -> u32 {
    let asked = (a.bits & b.bits) >> 16u;
    return select(0u, asked & (a.bits ^ b.bits), a.component == b.component);
}

// Returns whether three samples show a flat surface. They are `apart` from one to the next, at depth 1. On a flat
// surface the reciprocals of the depths lie on a line.
fn is_flat(a: SourceSample, b: SourceSample, c: SourceSample, apart: f32) -> bool {
    let off = abs(b.depth / a.depth + b.depth / c.depth - 2.0);
    return a.component == b.component && c.component == b.component && off < FLAT * apart;
}

// Returns one bit, from 16 on, for each busy share. Without `lit`, a share of at most half is busy between samples that
// see all of the source. With `lit`, a share of at least half is busy between samples that see none of it.
fn busy_shares(s: Neighbourhood, lit: bool) -> u32 {
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
