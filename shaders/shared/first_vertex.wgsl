// The first vertices of paths: hits that earlier steps found.

//! use camera, counters, display, emitters, facets, frame, lane, paths, pixels, planes, scattering, sobol, textures
//! use view

//! if light is paths
// Begins a path in a pixel, if it shows a surface.
fn begin_path(pixels: Pixels) {
    let pixel = pixel_of_ray(pixels, 0u);
    let index = pixel_index(pixel);
    var hits = target_hits(pixels, true);
    if hits.primitive == MISS { return; }
    let rays = rays_of(pixels);
    // A hit may be another view's. If this pixel's own ray hits the same primitive, that t replaces the other.
    if COUNT { primitives_tested += 1u; }
    let met = met_at(hits.slot, rays);
    hits.t = select(hits.t, met.t, met.hit & (met.t >= 0.0));
    travelled_before = 0.0;
    let before = brought[index];
    begin_points(pixel, frame.paths.first + before.paths);
    let vertex = vertex_at(rays, hits);
    let sent = sent_from_emitters(vertex, 0u, true);
    let is_known = has_mark(before, DIFFUSE_KNOWN);
    brought[index].paths = before.paths + 1u;
    brought[index].marks = (before.marks & 0xffffu) | (u32(lobe_width(vertex.lobes) * 65535.0) << 16u);
    if !is_known {
        brought[index].diffuse = before.diffuse + sent.diffuse;
        brought[index].squares.x = before.squares.x + before.newest.x * before.newest.x;
        brought[index].newest.x = luminance(sent.diffuse);
    }
    brought[index].glossy = before.glossy + sent.glossy;
    brought[index].squares.y = before.squares.y + before.newest.y * before.newest.y;
    brought[index].newest.y = luminance(sent.glossy);
    let way = scattered(vertex, random_point(PAIR_LOBE).x, random_point(PAIR_DIRECTION));
    if way.side != 0.0 && !(is_known && way.is_diffuse) {
        paths.each[index].origin = leaving(vertex, way.side);
        paths.each[index].travelled = hits.t;
        paths.each[index].direction = way.direction;
        paths.each[index].density = way.density;
        paths.each[index].weight = way.weight;
        paths.each[index].is_diffuse = select(0u, 1u, way.is_diffuse);
        follow(index, 1u);
    }
    count_pixel(pixel);
    count_view(pixel.y, light_rays, nodes_visited, primitives_tested);
    atomicAdd(&counters[pixel.y * COUNTERS + OWN_SHADOW_RAYS], light_rays);
}
