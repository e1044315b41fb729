// Pass 2 of 3 of `EsIsler`: each row from its far side to its near one as Adelson & Hodges 1993 do it, a thread a row
// (DESIGN, section 4): to a target on the right, from left to right. A later sample overwrites: it is nearer. The
// columns that a gap opens between two neighbours nobody saw: they are cleared.
//
// launch  one thread per row of the rows at work
// reads   source  [height * width]
// writes  view    [height * width]  marks: key of the sample, or EMPTY; cleared by the host

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> source: array<Pixel>;
@group(1) @binding(2) var<storage, read_write> view: array<Pixel>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn reproject_scanline(@builtin(global_invocation_id) id: vec3u) {
    let row = frame.row_begin + id.y * WORKGROUP + id.x;
    if id.x >= WORKGROUP || row >= frame.row_end { return; }
    let first = i32(row * frame.image_size.x);
    let end = first + i32(frame.image_size.x);
    // The pixel that the sample before landed on.
    var before = landed_on(0u, first);
    // Pixel indices, not columns: a loop whose end is a uniform is compiled anew for each width by Mesa's software
    // driver.
    for (var at = first; at < end; at += 1) {
        let column = in_sweep(u32(at - first));
        let here = landed_on(column, first);
        clear_between(before, here, first, end);
        if here >= first && here < end {
            view[here].marks = key_of(column);
        }
        before = here;
    }
    clear_between(before, select(end, first - 1, is_mirrored()), first, end);
}

fn landed_on(column: u32, first: i32) -> i32 {
    return first + landing(column, source[first + i32(column)].depth);
}

// Of the pixels [first, end), those after one and before another, in the order of the sweep.
fn clear_between(after: i32, before: i32, first: i32, end: i32) {
    let low = select(after, before, is_mirrored());
    let high = select(before, after, is_mirrored());
    for (var pixel = max(low + 1, first); pixel < min(high, end); pixel += 1) {
        view[pixel].marks = EMPTY;
    }
}
