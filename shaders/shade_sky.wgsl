// Pass 3 of 4 of `bracket`: the tiles in which nothing was found, apart from the others, which cost far more a pixel.
//
// launch  one thread per block (a pixel, or 2x2) of each listed tile, dispatched indirectly
// reads   lists        SKY
// writes  hits         [2 * height * width]  right half
// writes  right_color  [height * width]      linear RGB, 1
// adds    counters     [height * COUNTERS]

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> lists: Lists;
@group(1) @binding(2) var<storage, read_write> hits: array<PixelHit>;
@group(1) @binding(3) var<storage, read_write> right_color: array<vec4f>;
@group(1) @binding(4) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn shade_sky(@builtin(global_invocation_id) id: vec3u) {
    let block = listed_tile_pixels(SKY, id.x);
    if !any_ray(block.wanted) { return; }
    let direction = pixel_directions(frame.right_corner, block.pixels);
    let color = sky(direction);
    var ray = 0u;
    loop {
        if of_ray_b(block.wanted, ray) {
            let pixel = pixel_of_ray(block.pixels, ray);
            right_color[pixel_index(pixel)] = vec4f(clamp(of_ray3(color, ray), vec3f(0.0), vec3f(1.0)), 1.0);
            hits[right_index(pixel)] = pixel_hit(FAR, MISS, 0u);
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    count_view(pixel_of_ray(block.pixels, 0u).y, RIGHT, 0u, 0u, 0u);
}
