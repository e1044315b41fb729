// Paths of light, one per pixel of a band, and the light that they brought.

//! use display, lists, pixels

//! if light is paths
struct Path {
    origin: vec3f,
    travelled: f32,      // depth of the first hit, plus the path's length from there
    direction: vec3f,    // unit
    density: f32,        // density of the direction per steradian; 0 for a single direction
    weight: vec3f,       // multiplies what the path sees
    is_diffuse: u32,     // 1 if its first vertex reflected it diffusely
    // The pixels of the paths that are followed, in two lists that take turns: entry k of list n is entries[n & 1] of
    // path k.
    entries: array<u32, 2>,
    t: f32,              // hit of the ray, once it is traced
    slot: u32,           // MISS: none
}

// The paths of a band, and the heads of their lists, one for each vertex or ray of a path.
struct Paths {
    heads: array<ListHead, 34>,
    each: array<Path>,
}

// Light that the paths of a pixel brought to its first vertex, summed.
struct Brought {
    diffuse: vec3f,      // irradiance over pi, for diffuse reflection
    paths: u32,          // number of paths
    glossy: vec3f,       // radiance that the surface reflects or transmits to the viewer
    // DIFFUSE_KNOWN, GLOSSY_KNOWN, the numbers of paths of earlier frames in either light from bits 2 and 9 on, and the
    // width of the surface's lobes from bit 16 on.
    marks: u32,
    squares: vec2f,      // sums of the squared brightness that each path but the newest brought, diffuse and glossy
    newest: vec2f,       // brightness that the newest path brought; for a known mean its variance instead
}

// Marks of means that are reused from another view or frame.
const DIFFUSE_KNOWN: u32 = 1u;
const GLOSSY_KNOWN: u32 = 2u;
// Share of their mean by which samples of the same light may always differ.
const NEARLY_EQUAL: f32 = 0.02;
// Least alpha of highlights that are reused: in any case, and per radian between the two views of a point.
const LEAST_WIDTH: f32 = 0.05;
const WIDTH_PER_TURN: f32 = 2.5;
// Maximum number of paths of earlier frames.
const MOST_EARLIER: u32 = 127u;

fn has_mark(sum: Brought, mark: u32) -> bool { return (sum.marks & mark) != 0u; }

// Returns which means are known: diffuse and glossy.
fn known_means(sum: Brought) -> vec2<bool> {
    return vec2<bool>(has_mark(sum, DIFFUSE_KNOWN), has_mark(sum, GLOSSY_KNOWN));
}

// Returns the numbers of paths of this frame and of earlier ones in either light.
fn path_counts(sum: Brought) -> vec2u {
    let earlier = vec2u(sum.marks >> 2u, sum.marks >> 9u) & vec2u(MOST_EARLIER);
    return earlier + select(vec2u(sum.paths), vec2u(0u), known_means(sum));
}

// Returns the means of a pixel's paths.
fn mean_diffuse(sum: Brought) -> vec3f {
    return sum.diffuse * select(1.0 / f32(max(path_counts(sum).x, 1u)), 1.0, has_mark(sum, DIFFUSE_KNOWN));
}

fn mean_glossy(sum: Brought) -> vec3f {
    return sum.glossy * select(1.0 / f32(max(path_counts(sum).y, 1u)), 1.0, has_mark(sum, GLOSSY_KNOWN));
}

// Returns a sum with paths of earlier frames, whose means and variances are given as for known means. If paths are to
// be added to them, the result has their sums instead.
fn with_earlier(known: Brought, counts: vec2u, adds: bool) -> Brought {
    var sum = known;
    let held = min(counts, vec2u(MOST_EARLIER));
    sum.marks |= (held.x << 2u) | (held.y << 9u);
    if !adds { return sum; }
    sum.marks &= ~(DIFFUSE_KNOWN | GLOSSY_KNOWN);
    let weights = vec2f(held);
    sum.diffuse *= weights.x;
    sum.glossy *= weights.y;
    let means = vec2f(luminance(known.diffuse), luminance(known.glossy));
    sum.squares = weights * (means * means + known.newest * max(weights - 1.0, vec2f(0.0)));
    sum.newest = vec2f(0.0);
    return sum;
}

// Returns the variances of these means, by brightness: diffuse and glossy. A single path tells nothing of them.
fn mean_variances(sum: Brought) -> vec2f {
    let counts = vec2f(max(path_counts(sum), vec2u(1u)));
    let means = vec2f(luminance(sum.diffuse), luminance(sum.glossy)) / counts;
    let squares = sum.squares + sum.newest * sum.newest;
    let several = max(squares / counts - means * means, vec2f(0.0)) / max(counts - 1.0, vec2f(1.0));
    let variances = select(several, vec2f(0.0), counts < vec2f(1.5));
    return select(variances, sum.newest, known_means(sum));
}

// Adds a path to the list of those whose next ray is not traced yet. The order of a list depends on the threads, but a
// path's light does not depend on its place.
fn follow(index: u32, list: u32) {
    let place = atomicAdd(&paths.heads[list].count, 1u);
    if place % LIST_WORKGROUP == 0u {
        let begun = place / LIST_WORKGROUP + 1u;
        atomicMax(&paths.heads[list].workgroups_x, min(begun, MOST_ACROSS));
        if begun > MOST_ACROSS { atomicMax(&paths.heads[list].workgroups_y, rows_of_workgroups(begun)); }
    }
    paths.each[place].entries[list & 1u] = index;
}
