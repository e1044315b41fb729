// Steps of a path at a vertex. Vertices are counted from 0, and the ray that finds a vertex has its number.

//! use display, emitters, paths, scattering, sobol

//! if light is paths
// Paths end by chance from this vertex on.
const FIRST_ROULETTE: u32 = 3u;

// Adds light that a path brings to its pixel.
fn add_light(index: u32, is_diffuse: u32, light: vec3f) {
    if is_diffuse == 1u {
        brought[index].diffuse += light;
        brought[index].newest.x += luminance(light);
    } else {
        brought[index].glossy += light;
        brought[index].newest.y += luminance(light);
    }
}

// Sends a path on from a vertex, t from the ray's origin, and returns whether there is a next ray. The path may end by
// chance.
fn go_on(index: u32, path: Path, vertex: Vertex, t: f32, number: u32) -> bool {
    let pair = number * PAIRS;
    let chance = random_point(pair + PAIR_LOBE);
    let way = scattered(vertex, chance.x, random_point(pair + PAIR_DIRECTION));
    if way.side == 0.0 { return false; }
    var weight = path.weight * way.weight;
    var is_diffuse = path.is_diffuse;
    if number == 0u {
        if way.is_diffuse && has_mark(brought[index], DIFFUSE_KNOWN) { return false; }
        is_diffuse = select(0u, 1u, way.is_diffuse);
    } else {
        if way.is_diffuse { weight *= vertex.lobes.diffuse; }
        if number >= FIRST_ROULETTE {
            let survives = min(max(max(weight.x, weight.y), weight.z), 1.0);
            if chance.y >= survives { return false; }
            weight /= survives;
        }
        if all(weight <= vec3f(0.0)) { return false; }
    }
    paths.each[index].origin = leaving(vertex, way.side);
    paths.each[index].travelled = path.travelled + t;
    paths.each[index].direction = way.direction;
    paths.each[index].density = way.density;
    paths.each[index].weight = weight;
    paths.each[index].is_diffuse = is_diffuse;
    return true;
}
