// The first vertices of paths: hits that earlier steps found.

//! use camera, counters, display, emitters, facets, frame, lane, path_steps, paths, pixels, planes, rays, scattering
//! use sobol, textures, view

//! if light is paths
// Begins a path in a pixel, if it shows a surface.
fn begin_path(pixels: Pixels) {
    let hits = first_hits(pixels);
    if hits.primitive == MISS { return; }
    let pixel = pixel_of_ray(pixels, 0u);
    let index = pixel_index(pixel);
    travelled_before = 0.0;
    begin_points(pixel, frame.paths.first + brought[index].paths);
    let vertex = vertex_at(rays_of(pixels), hits);
    count_path(index);
    brought[index].marks = with_width(brought[index].marks, vertex);
    add_first_light(index, sent_from_emitters(vertex, 0u, true));
    if go_on(index, first_path(pixels, hits), vertex, hits.t, 0u) { follow(index, 0u); }
    count_pixel(pixel);
    count_view(pixel.y, light_rays, nodes_visited, primitives_tested);
    atomicAdd(&counters[pixel.y * COUNTERS + OWN_SHADOW_RAYS], light_rays);
}

// Begins a path like begin_path, but leaves its first vertex to later kernels.
fn begin_vertex(pixels: Pixels) {
    let hits = first_hits(pixels);
    if hits.primitive == MISS { return; }
    let pixel = pixel_of_ray(pixels, 0u);
    let index = pixel_index(pixel);
    let path = first_path(pixels, hits);
    paths.each[index].origin = path.origin;
    paths.each[index].travelled = path.travelled;
    paths.each[index].direction = path.direction;
    paths.each[index].weight = path.weight;
    paths.each[index].t = path.t;
    paths.each[index].slot = path.slot;
    count_path(index);
    follow(index, 0u);
    count_pixel(pixel);
    count_view(pixel.y, 0u, nodes_visited, primitives_tested);
}

// Returns the hits of pixels. A hit may be another view's. If this pixel's own ray hits the same primitive, that t
// replaces the other.
fn first_hits(pixels: Pixels) -> Hits {
    var hits = target_hits(pixels, true);
    if hits.primitive == MISS { return hits; }
    if COUNT { primitives_tested += 1u; }
    let met = met_at(hits.slot, rays_of(pixels));
    hits.t = select(hits.t, met.t, met.hit & (met.t >= 0.0));
    return hits;
}

// Returns the part of a path from the eye to its first vertex.
fn first_path(pixels: Pixels, hits: Hits) -> Path {
    let rays = rays_of(pixels);
    var path: Path;
    path.origin = rays.origin;
    path.direction = of_ray3(rays.direction, 0u);
    path.weight = vec3f(1.0);
    path.t = hits.t;
    path.slot = hits.slot;
    return path;
}

// Counts a new path of a pixel. Until its light is added, the newest brightness is 0.
fn count_path(index: u32) {
    let before = brought[index];
    brought[index].paths = before.paths + 1u;
    if !has_mark(before, DIFFUSE_KNOWN) {
        brought[index].squares.x = before.squares.x + before.newest.x * before.newest.x;
        brought[index].newest.x = 0.0;
    }
    brought[index].squares.y = before.squares.y + before.newest.y * before.newest.y;
    brought[index].newest.y = 0.0;
}

// Returns a pixel's marks with the width of the lobes of its first vertex.
fn with_width(marks: u32, vertex: Vertex) -> u32 {
    return (marks & 0xffffu) | (u32(lobe_width(vertex.lobes) * 65535.0) << 16u);
}

// Adds light that a first vertex sends to the eye.
fn add_first_light(index: u32, sent: Sent) {
    if !has_mark(brought[index], DIFFUSE_KNOWN) {
        brought[index].diffuse += sent.diffuse;
        brought[index].newest.x = luminance(sent.diffuse);
    }
    brought[index].glossy += sent.glossy;
    brought[index].newest.y = luminance(sent.glossy);
}
