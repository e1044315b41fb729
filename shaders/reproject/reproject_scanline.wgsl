// Pass 2 of 3 of `EsIsler`: one thread sweeps each row from its far side to its near side, as in Adelson & Hodges 1993
// (DESIGN, section 4). For a target on the right, the sweep goes from left to right. A later sample is nearer and
// overwrites. Columns in a gap between two neighbouring samples were not seen and are cleared.
//
// launch  one thread per current row
// reads   source  [height * width]
// writes  view    [height * width]  marks: key of the sample, or EMPTY; cleared by the host

//! use camera, frame, marks, pixels

var<storage, read> source: array<Pixel>;
var<storage, read_write> view: array<Pixel>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn reproject_scanline(@builtin(global_invocation_id) id: vec3u) {
    let row = frame.band.row_begin + id.y * WORKGROUP + id.x;
    if id.x >= WORKGROUP || row >= frame.band.row_end { return; }
    let first = i32(row * frame.band.size.x);
    let end = first + i32(frame.band.size.x);
    // The pixel where the previous sample landed.
    var before = landed_on(0u, first);
    // The loop runs over pixel indices, not columns: Mesa's software driver recompiles a loop whose end is a uniform
    // for each width.
    // Where the picture shows a full turn, its first half follows the last column. Those samples land there if they are
    // near.
    let round = i32(columns_before());
    let last = end + round / 2;
    for (var at = first; at < last; at += 1) {
        let turned = select(0, round, at >= end);
        let column = in_sweep(u32(at - turned - first));
        let here = landed_on(column, first) + turned;
        clear_between(before, here, first, end);
        if here >= first && here < end {
            view[here].marks = key_of(column, u32(here - first));
        }
        before = here;
    }
    if round == 0 { clear_between(before, select(end, first - 1, is_mirrored()), first, end); }
}

fn landed_on(column: u32, first: i32) -> i32 {
    let pixel = vec2u(column, u32(first) / frame.band.size.x);
    return first + landing(pixel, source[first + i32(column)].depth);
}

// Clears the pixels of [first, end) that lie between two others, in the order of the sweep.
fn clear_between(after: i32, before: i32, first: i32, end: i32) {
    let low = select(after, before, is_mirrored());
    let high = select(before, after, is_mirrored());
    for (var pixel = max(low + 1, first); pixel < min(high, end); pixel += 1) {
        view[pixel].marks = EMPTY;
    }
}
