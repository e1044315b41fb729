// Pass 2 of 4 of `bracket`: how deep each tile of right pixels must be searched: as deep as any left sample that lands in it. A right
// ray passes between two neighbours, so each sample's depth counts from where the one before landed to a pixel behind it; where a
// gap opens between them, its two sides say how deep. Samples that hit nothing land too: their tiles have no bound.
//
// launch  one thread per run of TILE left pixels of a row
// reads   hits      [2 * height * width]  left half
// writes  bounds    [tiles]               bits of the largest depth; cleared by the host
// adds    counters  [height * COUNTERS]   right pixels in gaps

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> hits: array<PixelHit>;
@group(1) @binding(2) var<storage, read_write> bounds: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;

const NO_TILE: u32 = 0xffffffffu;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn bound_tiles(@builtin(global_invocation_id) id: vec3u) {
    let width = frame.image_size.x;
    let row = launched_row(id) + frame.row_begin;
    let begin = id.x * TILE;
    if begin >= width || row >= frame.row_end { return; }
    let end = min(begin + TILE, width);
    let first_tile = row / TILE * tiles_across();
    let first_pixel = row * width;
    // Before the first sample and behind the last one there are gaps too.
    let before = max(begin, 1u) - 1u;
    var depth_before = hits[first_pixel + before].depth;
    var x_before = select(landed_at(before, depth_before), 0.0, begin == 0u);
    // Neighbours mostly land in one tile: an atomic each would be eight times as many.
    var tile = NO_TILE;
    var deepest = 0.0;
    var unseen = 0u;
    var column = begin;
    loop {
        let depth = hits[first_pixel + column].depth;
        let x = landed_at(column, depth);
        let opens = x >= x_before;
        let low = max(select(x - 1.0, x_before - 1.0, opens), 0.0);
        let high = min(select(x + 1.0, f32(width), column + 1u == width), f32(width) - 0.5);
        let depth_between = select(depth, max(depth, depth_before), opens);
        unseen += select(0u, u32(max(high - low - 3.0, 0.0)), opens);
        var landed = u32(low) / TILE;
        loop {
            if low > high { break; }
            if landed != tile {
                if tile != NO_TILE { atomicMax(&bounds[first_tile + tile], bitcast<u32>(deepest)); }
                tile = landed;
                deepest = 0.0;
            }
            deepest = max(deepest, depth_between);
            landed += 1u;
            if landed > u32(high) / TILE { break; }
        }
        x_before = x;
        depth_before = depth;
        column += 1u;
        if column >= end { break; }
    }
    if tile != NO_TILE { atomicMax(&bounds[first_tile + tile], bitcast<u32>(deepest)); }
    if unseen > 0u { atomicAdd(&counters[row * COUNTERS + GAP_PIXELS], unseen); }
}

// Where a sample lands, bounded: near z = 0 the place does not fit an integer.
fn landed_at(column: u32, depth: f32) -> f32 {
    return clamp(landing_x(column, depth), -2.0, f32(frame.image_size.x) + 2.0);
}
