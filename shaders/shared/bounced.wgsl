// Pixels that show mirrors, glass or veils, and the rays that these surfaces send on. A round traces one ray of each
// pixel and shades its hit (src/steps/mirrors.rs).

//! use frame, lane, light, lists, pixels, rays

// A ray that a surface reflects or transmits, or the ray from the eye.
struct SentRay {
    origin: vec3f,
    travelled: f32,     // depth of the first hit, plus the path length from there
    direction: vec3f,   // unit, except from the eye: there t is depth
    depth: u32,         // number of surfaces hit so far
    weight: vec3f,      // multiplies what the ray sees
    t: f32,             // of its hit, once it is traced
}

// A surface sends on at most two rays, one of which is followed at once. So the number of waiting rays exceeds the
// number of surfaces hit along a ray by at most one.
const MOST_WAITING: u32 = 9u;

struct BouncedPixel {
    color: vec3f,               // sum of the light that its rays have brought
    waiting: u32,               // number of waiting rays, the next one last
    diffuse: vec3f,             // direct light at the hit of the last waiting ray
    slot: u32,                  // slot of that hit; MISS: none
    shine: vec3f,
    sent: u32,                  // number of rays that were traced
    entries: array<u32, 2>,     // as in paths.wgsl: entry k of list n is entries[n & 1] of pixel k
    _pad: vec2u,
    rays: array<SentRay, MOST_WAITING>,
}

// The pixels of a band, and the heads of their lists: those of each round, and those that no round is left for.
struct Bounced {
    heads: array<ListHead, 18>,
    each: array<BouncedPixel>,
}

var<storage, read_write> bounced: Bounced;

// Number of waiting rays of the current pixel, and its index.
var<private> waiting: u32;
var<private> bounced_index: u32;

// Takes the pixel of a thread from the list of this round, and returns whether there is one.
fn take_bounced(thread: u32) -> bool {
    let list = frame.paths.ray;
    if thread >= atomicLoad(&bounced.heads[list].count) { return false; }
    bounced_index = bounced.each[thread].entries[list & 1u];
    waiting = bounced.each[bounced_index].waiting;
    return true;
}

// Lists the current pixel for a round. The order of a list depends on the threads, but a pixel's light does not depend
// on its place.
fn list_bounced(list: u32) {
    let place = atomicAdd(&bounced.heads[list].count, 1u);
    if place % LIST_WORKGROUP == 0u {
        let begun = place / LIST_WORKGROUP + 1u;
        atomicMax(&bounced.heads[list].workgroups_x, min(begun, MOST_ACROSS));
        if begun > MOST_ACROSS { atomicMax(&bounced.heads[list].workgroups_y, rows_of_workgroups(begun)); }
    }
    bounced.each[place].entries[list & 1u] = bounced_index;
}

fn bounced_pixels() -> Pixels {
    let width = frame.band.size.x;
    return Pixels(bounced_index % width, bounced_index / width);
}

// Adds a ray to those that wait.
fn hold(ray: SentRay) {
    bounced.each[bounced_index].rays[waiting] = ray;
    waiting += 1u;
}

// Returns the ray that waits last.
fn last_ray() -> SentRay { return bounced.each[bounced_index].rays[waiting - 1u]; }

// Stores the hit of the ray that waits last.
fn keep_hit(hits: Hits) {
    bounced.each[bounced_index].rays[waiting - 1u].t = hits.t;
    bounced.each[bounced_index].slot = select(hits.slot, MISS, hits.primitive == MISS);
}

// Returns the hit of the ray that waits last.
fn kept_hit(ray: SentRay) -> Hits {
    let slot = bounced.each[bounced_index].slot;
    // Only the slot identifies the primitive.
    return Hits(ray.t, select(0u, MISS, slot == MISS), select(slot, 0u, slot == MISS));
}

// Stores the direct light at the hit of the ray that waits last.
fn keep_light(light: Light) {
    bounced.each[bounced_index].diffuse = of_ray3(light.diffuse, 0u);
    bounced.each[bounced_index].shine = of_ray3(light.shine, 0u);
}

fn kept_light() -> Light {
    return Light(all3(bounced.each[bounced_index].diffuse), all3(bounced.each[bounced_index].shine));
}
