// Runs for `Auto` between two steps of `bracket`. It decides whether a band of the target view is cheaper by `bracket`
// or by ray tracing. The cost model is in src/methods/auto.rs.
//
// launch  one workgroup
// reads   source_counters  [rows * COUNTERS]  SHADOW_RAYS and OWN_SHADOW_RAYS
// updates counters         [rows * COUNTERS]  reads GAP_PIXELS, writes CHOSEN of the band's first row
// updates lists            heads TO_SEARCH and ALL_TRACED: the rejected one launches nothing

//! use counters, frame, lists, pixels

var<storage, read> source_counters: array<u32>;
var<storage, read_write> counters: array<u32>;
var<storage, read_write> lists: Lists;

const BRACKET_CHOSEN: u32 = 1u;

var<workgroup> shadow_sums: array<f32, LIST_WORKGROUP>;
var<workgroup> gap_sums: array<f32, LIST_WORKGROUP>;

@compute @workgroup_size(LIST_WORKGROUP)
fn choose(@builtin(local_invocation_index) thread: u32) {
    var shadow = 0.0;
    var gaps = 0.0;
    for (var row = frame.band.row_begin + thread; row < frame.band.row_end; row += LIST_WORKGROUP) {
        // Neither method reuses shadow rays from mirrored surfaces, so they are subtracted.
        let words = row * COUNTERS;
        shadow += f32(source_counters[words + SHADOW_RAYS] - source_counters[words + OWN_SHADOW_RAYS]);
        gaps += f32(counters[row * COUNTERS + GAP_PIXELS]);
    }
    shadow_sums[thread] = shadow;
    gap_sums[thread] = gaps;
    workgroupBarrier();
    if thread > 0u { return; }
    for (var other = 1u; other < LIST_WORKGROUP; other += 1u) {
        shadow += shadow_sums[other];
        gaps += gap_sums[other];
    }
    let pixels = f32(frame.band.size.x) * f32(frame.band.row_end - frame.band.row_begin);
    let asked_anew = min(frame.costs.listed * gaps / pixels + frame.costs.disagreed, frame.costs.listed);
    let asked = max(shadow / pixels, frame.costs.asked);
    let bracket = asked * (1.0 - asked_anew) > frame.costs.least_spared;
    counters[frame.band.row_begin * COUNTERS + CHOSEN] = select(0u, BRACKET_CHOSEN, bracket);
    atomicStore(&lists.heads[select(TO_SEARCH, ALL_TRACED, bracket)].workgroups_y, 0u);
}
