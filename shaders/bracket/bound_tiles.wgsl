// Pass 2 of 3 of `bracket`: computes the depth bound of each tile of the target view by atomic maximum
// (docs/BRACKET.md, "The tile bound"). A target ray may pass between two neighbouring samples. So a sample's depth
// counts from one pixel before the previous sample's landing position to one pixel after its own. In a gap between the
// two, the larger depth counts. Samples that hit nothing land too, and their tiles have no bound.
//
// launch  one thread per run of TILE pixels of a row of the source, in the order of a sweep
// reads   source    [height * width]
// writes  bounds    [tiles, BOUND_WORDS]  bits of the largest depth; cleared by the host
// adds    counters  [height * COUNTERS]  GAP_PIXELS: pixels of the target in gaps

//! use camera, counters, frame, pixels, tiles, wanted

var<storage, read> source: array<Pixel>;
var<storage, read_write> bounds: array<atomic<u32>>;
var<storage, read_write> counters: array<atomic<u32>>;

const NO_TILE: u32 = 0xffffffffu;
// Landing position of a sample that was left out. No gap opens after it.
const NOWHERE: f32 = 3.0e38;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn bound_tiles(@builtin(global_invocation_id) id: vec3u) {
    let width = frame.band.size.x;
    let row = launched_row(id) + frame.band.row_begin;
    let begin = id.x * TILE;
    if begin >= width || row >= frame.band.row_end { return; }
    let end = min(begin + TILE, width);
    let first_tile = row / TILE * tiles_across();
    let first_pixel = row * width;
    // There are gaps before the first sample and after the last one too. Where the picture shows a full turn, the first
    // sample follows the last one.
    let round = columns_before();
    let before = in_sweep(select(max(begin, 1u), width, begin == 0u && round > 0u) - 1u);
    var depth_before = source[first_pixel + before].depth;
    var x_before = landed_at(vec2u(before, row), depth_before);
    if begin == 0u { x_before = select(0.0, x_before - f32(round), round > 0u); }
    if is_left_out(depth_before) { x_before = NOWHERE; }
    // Neighbours usually land in one tile. One atomic operation per sample would be eight times as many.
    var tile = NO_TILE;
    var deepest = 0.0;
    var unseen = 0u;
    var place = begin;
    loop {
        let column = in_sweep(place);
        let depth = source[first_pixel + column].depth;
        let x = landed_at(vec2u(column, row), depth);
        let left_out = is_left_out(depth);
        let opens = x >= x_before && !left_out;
        let depth_between = select(depth, max(depth, depth_before), opens);
        let begins = select(x - 1.0, x_before - 1.0, opens);
        let ends = select(x + 1.0, f32(width), round == 0u && place + 1u == width);
        // In a full turn, columns before the first one are the last ones.
        var turned = round;
        loop {
            // A sample that was left out lands nowhere: beyond the last tile.
            let low = select(max(begins + f32(turned), 0.0), f32(width), left_out);
            let high = min(ends + f32(turned), f32(width) - 0.5);
            unseen += select(0u, u32(max(high - low - 3.0, 0.0)), opens);
            // If columns count from the right, `low` lies on the right.
            let first = select(low, max(f32(width) - high, 0.0), is_mirrored());
            let last = select(high, min(f32(width) - low, f32(width) - 0.5), is_mirrored());
            var landed = u32(first) / TILE;
            loop {
                if low > high { break; }
                if landed != tile {
                    if tile != NO_TILE { atomicMax(&bounds[BOUND_WORDS * (first_tile + tile)], bitcast<u32>(deepest)); }
                    tile = landed;
                    deepest = 0.0;
                }
                deepest = max(deepest, depth_between);
                landed += 1u;
                if landed > u32(last) / TILE { break; }
            }
            if turned == 0u { break; }
            turned = 0u;
        }
        x_before = select(x, NOWHERE, left_out);
        depth_before = depth;
        place += 1u;
        if place >= end { break; }
    }
    if tile != NO_TILE { atomicMax(&bounds[BOUND_WORDS * (first_tile + tile)], bitcast<u32>(deepest)); }
    if unseen > 0u { atomicAdd(&counters[row * COUNTERS + GAP_PIXELS], unseen); }
}

// Returns the landing position of a sample, measured from the begin of the sweep. The position is clamped, since near z
// = 0 it does not fit an integer.
fn landed_at(pixel: vec2u, depth: f32) -> f32 {
    let width = f32(frame.band.size.x);
    let x = clamp(landing_x(pixel, depth), -2.0 - f32(columns_before()), width + 2.0);
    return select(x, width - x, is_mirrored());
}
