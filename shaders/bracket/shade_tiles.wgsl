// Pass 3 of 3 of `bracket`, fourth part: shades target pixels from the hits of resolve_tiles and trace_listed, with the
// source's visibility bits, or with those of an earlier frame. It lists the pixels for which some light's bit is
// unknown.
//
// launch  one thread per block of 1x1 or 2x2 pixels of each listed tile, dispatched indirectly
// updates view         [height * width]      color; ASKED is added to the marks
// writes  kept_samples texture, for views that reuse an earlier frame's bits
// adds    counters     [height * COUNTERS]
// appends lists        TO_LIGHT; reads TO_RESOLVE

//! use camera, counters, dice, kept_samples, lane, lists, marks, pixels, shade, surfaces, view, visibility

var<storage, read_write> lists: Lists;
var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn shade_tiles(@builtin(global_invocation_id) id: vec3u) {
    let block = listed_tile_pixels(TO_RESOLVE, listed_thread(id));
    if !any_ray(block.wanted) { return; }
    let rays = rays_of(block.pixels);
    let found = target_hits(block.pixels, block.wanted);
    let surfaces = surfaces_at(rays, found);
    throw_dice(block.pixels, 0u);
    ask_source_in_tile(block.pixels, found, surfaces);
    let shaded = shade(rays, found, surfaces);
    keep_colors(block.pixels, block.wanted, shaded.color);
    keep_samples(block.pixels, block.wanted, shaded);
    let to_light = block.wanted & put_off;
    var place = reserve(TO_LIGHT, count_rays(to_light));
    var ray = 0u;
    loop {
        if of_ray_b(to_light, ray) {
            let index = pixel_index(pixel_of_ray(block.pixels, ray));
            view[index].marks |= ASKED;
            append(TO_LIGHT, place, index);
            place += 1u;
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    count_view(pixel_of_ray(block.pixels, 0u).y, 0u, 0u, 0u);
}
