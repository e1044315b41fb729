// Begins a path in each pixel that shows a surface: its first vertex is the hit that an earlier step found.
//
// launch  one thread per pixel of the current rows
// reads   view       [height * width]
// updates brought    [height * width]
// appends paths      list 0
// adds    counters   [height * COUNTERS]

//! use camera, counters, emitters, frame, lane, paths, pixels, planes, scattering, sobol, textures, view, wanted

var<storage, read> view: array<Pixel>;
var<storage, read_write> brought: array<Brought>;
var<storage, read_write> paths: Paths;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn begin_paths(@builtin(global_invocation_id) id: vec3u) {
    let pixels = block_pixels(id);
    let wanted = inside_rows(pixels);
    if !all_rays(wanted) { return; }
    let pixel = pixel_of_ray(pixels, 0u);
    let index = pixel_index(pixel);
    var hits = target_hits(pixels, wanted);
    if hits.primitive == MISS { return; }
    let rays = rays_of(pixels);
    // A hit may be another view's. If this pixel's own ray hits the same primitive, that t replaces the other.
    if COUNT { primitives_tested += 1u; }
    let met = met_at(hits.slot, rays);
    hits.t = select(hits.t, met.t, met.hit & (met.t >= 0.0));
    travelled_before = 0.0;
    let number = brought[index].paths;
    begin_points(pixel, frame.paths.first + number);
    let vertex = vertex_at(rays, hits);
    let sent = sent_from_emitters(vertex, 0u, true);
    brought[index].paths = number + 1u;
    brought[index].diffuse += sent.diffuse;
    brought[index].glossy += sent.glossy;
    let way = scattered(vertex, random_point(PAIR_LOBE).x, random_point(PAIR_DIRECTION));
    if way.side != 0.0 {
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
