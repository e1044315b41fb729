// Pass 3 of 3 of `bracket`: shades tiles that contain no primitive. These tiles have their own list, since other tiles
// cost far more.
//
// launch  one thread per block of 1x1 or 2x2 pixels of each listed tile, dispatched indirectly
// reads   lists        SKY
// writes  view         [height * width]
// writes  kept_samples texture, for views that reuse an earlier frame's bits
// adds    counters     [height * COUNTERS]

//! use camera, counters, display, kept_samples, lane, light, linear, lists, pixels, sky

var<storage, read_write> lists: Lists;
var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn shade_sky(@builtin(global_invocation_id) id: vec3u) {
    let block = listed_tile_pixels(SKY, listed_thread(id));
    if !any_ray(block.wanted) { return; }
    let direction = rays_of(block.pixels).direction;
    let color = sky(direction);
    let packed = packed_srgb(color);
    var ray = 0u;
    loop {
        if of_ray_b(block.wanted, ray) {
            let index = pixel_index(pixel_of_ray(block.pixels, ray));
            view[index] = Pixel(FAR, MISS, 0u, of_ray_u(packed, ray));
            keep_linear(index, of_ray3(color, ray));
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    keep_samples(block.pixels, block.wanted, Samples(color, F(FAR), U(MISS), U(0u), U(0u)));
    count_view(pixel_of_ray(block.pixels, 0u).y, 0u, 0u, 0u);
}
