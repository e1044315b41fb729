// Pass 2 of 4 of `EsIsler`: each row from left to right as Adelson & Hodges 1993 do it, a thread a row (DESIGN, section 4). A
// later sample overwrites: it is nearer. The columns that a gap opens between two neighbours nobody saw: they are cleared.
//
// launch  one thread per row of the rows at work
// reads   hits          [2 * height * width]  left half
// writes  right_source  [height * width]      left column + 1, or EMPTY; cleared by the host

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> hits: array<PixelHit>;
@group(1) @binding(2) var<storage, read_write> right_source: array<u32>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn reproject_scanline(@builtin(global_invocation_id) id: vec3u) {
    let row = frame.row_begin + id.y * WORKGROUP + id.x;
    if id.x >= WORKGROUP || row >= frame.row_end { return; }
    // Pixel indices, not columns: a loop whose end is a uniform is compiled anew for each width by Mesa's software driver.
    let first = i32(row * frame.image_size.x);
    let end = first + i32(frame.image_size.x);
    var before = first + landing(0u, hits[first].depth);
    for (var left = first; left < end; left += 1) {
        let here = first + landing(u32(left - first), hits[left].depth);
        clear_pixels(max(before + 1, first), min(here, end));
        if here >= first && here < end {
            right_source[here] = u32(left - first) + 1u;
        }
        before = here;
    }
    clear_pixels(max(before + 1, first), end);
}

fn clear_pixels(begin: i32, end: i32) {
    for (var pixel = begin; pixel < end; pixel += 1) {
        right_source[pixel] = EMPTY;
    }
}
