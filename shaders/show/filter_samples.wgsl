// Filters the samples of a view's pixels, in linear light, as src/sampling does on the host.
//
// launch  one thread per pixel of the picture
// reads   samples  [side * height, side * width]  exposed linear colour
// writes  picture  [height, width]                sRGB-encoded, alpha 1

//! use display, frame, jitter, lane, pixels

var samples: texture_2d<f32>;
var picture: texture_storage_2d<rgba8unorm, write>;

// Filters, by frame.display.filter_kind.
const TENT: u32 = 1u;
const GAUSS: u32 = 2u;

// Returns the filter's radius in pixels.
fn filter_radius() -> f32 {
    switch frame.display.filter_kind {
        case TENT: { return 1.0; }
        case GAUSS: { return 1.5; }
        default: { return 0.5; }
    }
}

// Returns the weight at a distance in pixels within the radius.
fn filter_weight(x: f32) -> f32 {
    switch frame.display.filter_kind {
        case TENT: { return 1.0 - abs(x); }
        case GAUSS: { return exp(-2.0 * x * x) - exp(-4.5); }
        default: { return 1.0; }
    }
}

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn filter_samples(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(picture);
    if any(id.xy >= size) { return; }
    let all = vec2i(textureDimensions(samples));
    let side = f32(textureDimensions(samples).x / size.x);
    let centre = (vec2f(id.xy) + 0.5) * side;
    let reach = filter_radius() * side;
    // One more sample on either side, since jittered samples stay in their cells.
    let first = max(vec2i(floor(centre - reach)) - 1, vec2i(0));
    let last = min(vec2i(ceil(centre + reach)), all - 1);
    var color = vec3f(0.0);
    var weights = 0.0;
    var row = first.y;
    loop {
        let down = f32(row) + 0.5 - centre.y;
        let aside = row_aside(u32(row));
        if abs(down) < reach {
            var of_row = vec3f(0.0);
            var weights_of_row = 0.0;
            var column = first.x;
            loop {
                let across = f32(column) + 0.5 + aside - centre.x;
                let weight = select(0.0, filter_weight(across / side), abs(across) < reach);
                of_row += weight * textureLoad(samples, vec2i(column, row), 0).rgb;
                weights_of_row += weight;
                column += 1;
                if column > last.x { break; }
            }
            let weight = filter_weight(down / side);
            color += weight / weights_of_row * of_row;
            weights += weight;
        }
        row += 1;
        if row > last.y { break; }
    }
    color /= weights * frame.display.exposure; // packed_srgb exposes again
    let light = F3(F(color.x), F(color.y), F(color.z));
    textureStore(picture, id.xy, unpack4x8unorm(of_ray_u(packed_srgb(light), 0u)));
}
