// Finds the nearest and farthest depth in each row of a view. Lemma 1 determines the size of the 3D buffer from them
// (DESIGN, section 2).
//
// launch  one thread per current row
// reads   view      [height * width]
// writes  counters  [height * COUNTERS]   NEAREST_DEPTH and FARTHEST_DEPTH, as bits of f32

//! use counters, frame, pixels

var<storage, read> view: array<Pixel>;
var<storage, read_write> counters: array<u32>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn depth_range(@builtin(global_invocation_id) id: vec3u) {
    let row = frame.band.row_begin + id.y * WORKGROUP + id.x;
    if id.x >= WORKGROUP || row >= frame.band.row_end { return; }
    var nearest = FAR;
    var farthest = 0.0;
    // The loop's end must not be a uniform alone: Mesa's software driver would recompile the kernel for each width.
    let end = (row + 1u) * frame.band.size.x;
    for (var pixel = row * frame.band.size.x; pixel < end; pixel += 1u) {
        let depth = view[pixel].depth;
        nearest = min(nearest, depth);
        farthest = max(farthest, depth);
    }
    counters[row * COUNTERS + NEAREST_DEPTH] = bitcast<u32>(nearest);
    counters[row * COUNTERS + FARTHEST_DEPTH] = bitcast<u32>(farthest);
}
