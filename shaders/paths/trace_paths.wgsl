// Traces one ray of each path that is followed, adds the light that it finds, and lets the path go on.
//
// launch  one thread per list entry, dispatched indirectly
// updates brought    [height * width]
// reads   paths      list of this ray
// appends paths      list of the next ray
// adds    counters   [height * COUNTERS]

//! use bvh, counters, display, emitters, frame, lane, paths, pixels, planes, rays, scattering, sobol, stack, textures

var<storage, read_write> brought: array<Brought>;
var<storage, read_write> paths: Paths;
var<storage, read_write> counters: array<atomic<u32>>;

// Paths end by chance from this ray on.
const FIRST_ROULETTE: u32 = 3u;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_paths(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let ray = frame.paths.ray;
    let place = listed_thread(id);
    if place >= atomicLoad(&paths.heads[ray - 1u].count) { return; }
    let index = paths.each[place].entries[(ray - 1u) & 1u];
    var path = paths.each[index];
    let pixel = vec2u(index % frame.band.size.x, index / frame.band.size.x);
    begin_points(pixel, frame.paths.first + brought[index].paths - 1u);
    travelled_before = path.travelled;
    let rays = Rays(path.origin, all3(path.direction));
    let hits = closest_hit(rays, 0.0, FAR);
    var light = vec3f(0.0);
    if hits.primitive == MISS {
        light = sky_of_path(path.direction, path.density);
    } else {
        let vertex = vertex_at(rays, hits);
        path.weight *= pow(vertex.left, vec3f(hits.t));
        light = emission_of_path(vertex, path.density, hits.t);
        if ray <= frame.paths.bounces {
            let pair = ray * PAIRS;
            let sent = sent_from_emitters(vertex, pair, false);
            light += vertex.lobes.diffuse * sent.diffuse + sent.glossy;
            go_on(index, path, vertex, hits.t, pair);
        }
    }
    light *= path.weight;
    if path.is_diffuse == 1u {
        brought[index].diffuse += light;
        brought[index].newest.x += luminance(light);
    } else {
        brought[index].glossy += light;
        brought[index].newest.y += luminance(light);
    }
    count_pixel(pixel);
    count_view(pixel.y, light_rays, nodes_visited, primitives_tested);
    atomicAdd(&counters[pixel.y * COUNTERS + SENT_RAYS], 1u);
    atomicAdd(&counters[pixel.y * COUNTERS + OWN_SHADOW_RAYS], light_rays);
}

// Sends a path on from its newest vertex, unless it ends by chance.
fn go_on(index: u32, path: Path, vertex: Vertex, t: f32, pair: u32) {
    let ray = frame.paths.ray;
    let chance = random_point(pair + PAIR_LOBE);
    let way = scattered(vertex, chance.x, random_point(pair + PAIR_DIRECTION));
    if way.side == 0.0 { return; }
    var weight = path.weight * way.weight;
    if way.is_diffuse { weight *= vertex.lobes.diffuse; }
    if ray >= FIRST_ROULETTE {
        let survives = min(max(max(weight.x, weight.y), weight.z), 1.0);
        if chance.y >= survives { return; }
        weight /= survives;
    }
    if all(weight <= vec3f(0.0)) { return; }
    paths.each[index].origin = leaving(vertex, way.side);
    paths.each[index].travelled = path.travelled + t;
    paths.each[index].direction = way.direction;
    paths.each[index].density = way.density;
    paths.each[index].weight = weight;
    follow(index, ray + 1u);
}
