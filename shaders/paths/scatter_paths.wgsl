// Sends each path on from the hit of its ray, and proposes light of lights, emitting surfaces and the sky to the vertex
// there. light_paths finds how much of this light arrives.
//
// launch  one thread per list entry, dispatched indirectly
// updates brought    [height * width]
// reads   paths      list of this ray
// updates paths      the next ray
// appends paths      list of the next ray
// writes  proposed   [height * width]

//! use emitters, first_vertex, frame, lane, path_steps, paths, pixels, proposed, rays, scattering, sobol, textures

var<storage, read_write> brought: array<Brought>;
var<storage, read_write> paths: Paths;
var<storage, read_write> proposed: array<Proposed>;

@compute @workgroup_size(LIST_WORKGROUP)
fn scatter_paths(@builtin(global_invocation_id) id: vec3u) {
    let ray = frame.paths.ray;
    let place = listed_thread(id);
    if place >= atomicLoad(&paths.heads[ray].count) { return; }
    let index = paths.each[place].entries[ray & 1u];
    let path = paths.each[index];
    let pixel = vec2u(index % frame.band.size.x, index / frame.band.size.x);
    begin_points(pixel, frame.paths.first + brought[index].paths - 1u);
    proposed[index].is_open = 0u;
    if path.slot == MISS {
        add_light(index, path.is_diffuse, sky_of_path(path.direction, path.density) * path.weight);
    } else {
        scatter(index, path, ray);
    }
}

fn scatter(index: u32, arriving: Path, ray: u32) {
    var path = arriving;
    travelled_before = path.travelled;
    let vertex = vertex_at(Rays(path.origin, all3(path.direction)), Hits(path.t, 0u, path.slot));
    var light = vec3f(0.0);
    if ray == 0u {
        brought[index].marks = with_width(brought[index].marks, vertex);
    } else {
        path.weight *= pow(vertex.left, vec3f(path.t));
        light = emission_of_path(vertex, path.density, path.t);
        if ray > frame.paths.bounces {
            add_light(index, path.is_diffuse, light * path.weight);
            return;
        }
    }
    let pair = ray * PAIRS;
    proposed[index].start = leaving(vertex, 1.0);
    proposed[index].is_open = 1u;
    proposed[index].emitted = light;
    proposed[index].travelled = path.travelled;
    proposed[index].weight = path.weight;
    proposed[index].is_diffuse = path.is_diffuse;
    proposed[index].albedo = vertex.lobes.diffuse;
    proposed[index].rays[0] = ray_to_light(vertex, pair, ray == 0u);
    proposed[index].rays[1] = ray_to_emitting(vertex, pair);
    proposed[index].rays[2] = ray_to_sky(vertex, pair);
    if go_on(index, path, vertex, path.t, ray) { follow(index, ray + 1u); }
}
