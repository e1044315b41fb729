// Recalls the light that paths brought to an earlier frame's view, where the four samples around a pixel's point show
// its surface and chance explains their differences. Lists the pixels that need paths of their own: those without known
// light, and one of ASKED_AGAIN in turn, whose new paths are added to the earlier ones.
//
// launch  one thread per pixel of the current rows
// reads   view           [height * width]
// reads   history        [picture height + 1, width]   samples; its last row holds the eye of the earlier frame
// reads   earlier_light  [picture height, width]
// writes  brought        [height * width]
// appends lists          TO_TRACE

//! use camera, dice, display, earlier_light, earlier_quad, facets, frame, history, lane, lists, paths, pixels, planes
//! use primitives, rays, scattering, view, wanted

var<storage, read_write> view: array<Pixel>;
var earlier_light: texture_2d<u32>;
var<storage, read_write> brought: array<Brought>;
var<storage, read_write> lists: Lists;

// One of this number of pixels follows new paths in each frame.
const ASKED_AGAIN: u32 = 8u;
// Pixels whose light is the mean of fewer paths follow new ones in each frame.
const ENOUGH: u32 = 4u;
// Minimum cosine between the shading normals of a point and of the samples around it.
const ALIKE: f32 = 0.98;
// Glossy light is the mean of that of about so many frames. A pixel follows new paths in one of ASKED_AGAIN frames. The
// least alpha of highlights grows by the turn between all these frames.
const GLOSSY_FRAMES: u32 = 32u;
// Largest difference between the widths of lobes.
const SAME_WIDTH: f32 = 0.04;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn recall_brought(@builtin(global_invocation_id) id: vec3u) {
    let pixels = block_pixels(id);
    if !all_rays(inside_rows(pixels)) { return; }
    let hits = target_hits(pixels, true);
    if hits.primitive == MISS { return; }
    let pixel = pixel_of_ray(pixels, 0u);
    let index = pixel_index(pixel);
    if !recall_light(pixels, hits, pixel, index) { append(TO_TRACE, reserve(TO_TRACE, 1u), index); }
}

// Takes the light that is known, and returns whether the pixel needs no new paths.
fn recall_light(pixels: Pixels, hits: Hits, pixel: vec2u, index: u32) -> bool {
    let rays = rays_of(pixels);
    let vertex = vertex_at(rays, hits);
    let lobes = vertex.lobes;
    // The light behind a veil is not the veil's.
    if lobes.opacity < 1.0 { return false; }
    let component = surface_at(rays, hits, 0u).component;
    let eye = earlier_eye();
    let quad = quad_around(eye, vertex.point, vertex.geometric_normal, component);
    if !quad.shown || is_in_groove(quad) { return false; }
    let a = light_there(quad.upper);
    let b = light_there(quad.upper + vec2u(1u, 0u));
    let c = light_there(quad.lower);
    let d = light_there(quad.lower + vec2u(1u, 0u));
    let counts = array(
        vec4u(a.counts.x, b.counts.x, c.counts.x, d.counts.x),
        vec4u(a.counts.y, b.counts.y, c.counts.y, d.counts.y),
    );
    if any(counts[0] == vec4u(0u)) { return false; }
    let normal = vertex.normal;
    let cosines = vec4f(dot(a.normal, normal), dot(b.normal, normal), dot(c.normal, normal), dot(d.normal, normal));
    if any(cosines < vec4f(ALIKE)) { return false; }
    let diffuse = brightness(a.diffuse, b.diffuse, c.diffuse, d.diffuse);
    let diffuse_deviations = diffuse * vec4f(a.deviations.x, b.deviations.x, c.deviations.x, d.deviations.x);
    let diffuse_variances = diffuse_deviations * diffuse_deviations;
    if !agree(diffuse, diffuse_variances, counts[0]) { return false; }
    let way = quad.way;
    let width = lobe_width(lobes);
    // Counts are rounded up or down by chance, so that they do not shrink from frame to frame.
    let place = vec2u(pixel.x, pixel.y + frame.band.first_row);
    let chance = vec2f(scrambled(vec3u(place, earlier_frame())).xy >> vec2u(8u)) / 16777216.0;
    var sum: Brought;
    sum.marks = DIFFUSE_KNOWN | (u32(width * 65535.0) << 16u);
    sum.diffuse = light_between(a.diffuse, b.diffuse, c.diffuse, d.diffuse, way);
    sum.newest.x = between_four(diffuse_variances, way);
    var earlier = vec2u(u32(between_four(vec4f(counts[0]), way) + chance.x), 0u);
    let glossy = brightness(a.glossy, b.glossy, c.glossy, d.glossy);
    let glossy_deviations = glossy * vec4f(a.deviations.y, b.deviations.y, c.deviations.y, d.deviations.y);
    let glossy_variances = glossy_deviations * glossy_deviations;
    let turn = distance(eye.place, eye_point()) / quad.depth;
    let least = max(LEAST_WIDTH, WIDTH_PER_TURN * f32(GLOSSY_FRAMES) * turn);
    let same = abs(vec4f(a.width, b.width, c.width, d.width) - width) <= vec4f(SAME_WIDTH);
    if lobes.glossy == 0.0 {
        sum.marks |= GLOSSY_KNOWN;
        earlier.y = earlier.x;
    } else if width >= least && all(same) && all(counts[1] > vec4u(0u))
        && agree(glossy, glossy_variances, counts[1]) {
        let tint = tint_of(lobes);
        sum.marks |= GLOSSY_KNOWN;
        sum.glossy = light_between(a.glossy, b.glossy, c.glossy, d.glossy, way) * tint;
        sum.newest.y = between_four(glossy_variances, way) * luminance(tint) * luminance(tint);
        let held = (GLOSSY_FRAMES / ASKED_AGAIN - 1u) * eye_tag(3u);
        earlier.y = min(u32(between_four(vec4f(counts[1]), way) + chance.y), held);
    }
    let is_turn = is_asked_again(place) || earlier.x < ENOUGH;
    brought[index] = with_earlier(sum, earlier, is_turn);
    return !is_turn && has_mark(sum, GLOSSY_KNOWN);
}

fn light_there(place: vec2u) -> EarlierLight { return unpacked_light(textureLoad(earlier_light, place, 0)); }

fn brightness(a: vec3f, b: vec3f, c: vec3f, d: vec3f) -> vec4f {
    return vec4f(luminance(a), luminance(b), luminance(c), luminance(d));
}

fn light_between(a: vec3f, b: vec3f, c: vec3f, d: vec3f, way: vec3f) -> vec3f {
    return mix(mix(a, b, way.x), mix(c, d, way.y), way.z);
}

// Returns whether chance explains the differences between the sides, and between the diagonals, of four samples. The
// variance of a single path is unknown, so chance explains any difference. That of few paths is known roughly.
fn agree(values: vec4f, variances: vec4f, counts: vec4u) -> bool {
    let fewest = min(min(counts.x, counts.y), min(counts.z, counts.w));
    let deviation = (0.5 + 1.0 / f32(fewest)) * sqrt(dot(variances, vec4f(1.0)));
    // A smaller tolerance would reject bright samples more often than dark ones.
    let limit = max(max(frame.paths.tolerance, 1.0) * deviation, NEARLY_EQUAL * 0.25 * dot(values, vec4f(1.0)));
    let differences = 0.5 * vec3f(
        dot(values, vec4f(1.0, -1.0, 1.0, -1.0)),
        dot(values, vec4f(1.0, 1.0, -1.0, -1.0)),
        dot(values, vec4f(1.0, -1.0, -1.0, 1.0)),
    );
    return all(abs(differences) <= vec3f(limit)) || fewest == 1u;
}

fn is_asked_again(place: vec2u) -> bool {
    return (place.x + 3u * place.y + 5u * earlier_frame()) % ASKED_AGAIN == 0u;
}
