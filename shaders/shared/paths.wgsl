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
    _pad: vec2u,
}

// The paths of a band, and the heads of their lists, one for each ray of a path.
struct Paths {
    heads: array<ListHead, 33>,
    each: array<Path>,
}

// Light that the paths of a pixel brought to its first vertex, summed.
struct Brought {
    diffuse: vec3f,      // irradiance over pi, for diffuse reflection
    paths: u32,          // number of paths
    glossy: vec3f,       // radiance that the surface reflects or transmits to the viewer
    marks: u32,          // DIFFUSE_KNOWN, GLOSSY_KNOWN, and the width of the surface's lobes from bit 16 on
    squares: vec2f,      // sums of the squared brightness that each path but the newest brought, diffuse and glossy
    newest: vec2f,       // brightness that the newest path brought; for a known mean its variance instead
}

// Marks of means that are reused from another view.
const DIFFUSE_KNOWN: u32 = 1u;
const GLOSSY_KNOWN: u32 = 2u;

fn has_mark(sum: Brought, mark: u32) -> bool { return (sum.marks & mark) != 0u; }

// Returns the means of a pixel's paths.
fn mean_diffuse(sum: Brought) -> vec3f {
    return sum.diffuse * select(1.0 / f32(max(sum.paths, 1u)), 1.0, has_mark(sum, DIFFUSE_KNOWN));
}

fn mean_glossy(sum: Brought) -> vec3f {
    return sum.glossy * select(1.0 / f32(max(sum.paths, 1u)), 1.0, has_mark(sum, GLOSSY_KNOWN));
}

// Returns the variances of these means, by brightness: diffuse and glossy. A single path tells nothing of them.
fn mean_variances(sum: Brought) -> vec2f {
    var variances = vec2f(0.0);
    if sum.paths > 1u {
        let count = f32(sum.paths);
        let means = vec2f(luminance(sum.diffuse), luminance(sum.glossy)) / count;
        let squares = sum.squares + sum.newest * sum.newest;
        variances = max(squares / count - means * means, vec2f(0.0)) / (count - 1.0);
    }
    let known = vec2<bool>(has_mark(sum, DIFFUSE_KNOWN), has_mark(sum, GLOSSY_KNOWN));
    return select(variances, sum.newest, known);
}

// Adds a path to the list of those whose ray of this number is not traced yet. Rays are counted from 1. The order of a
// list depends on the threads, but a path's light does not depend on its place.
fn follow(index: u32, ray: u32) {
    let list = ray - 1u;
    let place = atomicAdd(&paths.heads[list].count, 1u);
    if place % LIST_WORKGROUP == 0u { atomicAdd(&paths.heads[list].workgroups_x, 1u); }
    paths.each[place].entries[list & 1u] = index;
}
