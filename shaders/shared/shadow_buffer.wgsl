// Shadow-buffers: a table of directions around each of the first point lights, filled by fill_shadow_buffer (docs/SHADOW-BUFFER.md), which
// stands between a light and its shadow rays.

// In the place of a texel's primitive: nothing is known of its direction.
const UNFILLED: u32 = 0xfffffffeu;

//! if shadow_buffer is object or depth or hybrid
// A layer a light: t as bits and the primitive's place in each texel. Behind the last row stands where directions are: src/steps/shadow_buffer.rs.
@group(1) @binding(8) var shadow_buffers: texture_2d_array<u32>;

// What lit_by asks for, besides a ray.
var<private> asked_normal: F3;      // unit, geometric, towards the viewer
var<private> asked_component: U;

// As shade.wgsl has it.
fn radiance(rays: Rays, hits: Hits, surfaces: Surfaces) -> F3 {
    asked_normal = surfaces.geometric_normal;
    asked_component = surfaces.component;
    let light = direct_light(surfaces, rays.origin);
    var color = product3(surfaces.albedo, add3(all3(open_ambient()), light.diffuse));
    if SHINE { color = add3(color, add3(surfaces.emission, light.shine)); }
    return select3(sky(rays.direction), color, surfaces.there);
}

// What a light's table says of points: nothing of those that are unknown; of others what hides the light from them, or MISS.
struct Said {
    unknown: B,
    occluders: U,
}

// Where directions stand in a light's table.
struct Directions {
    layer: u32,
    rows: i32,
    columns: i32,
    whole: bool,         // all directions: rows go on beyond the poles, columns beyond the last one
    theta_begin: f32,    // of the first row, radians
    theta_step: f32,     // a row
    phi_begin: f32,
    phi_step: f32,
    axis_x: vec3f,
    axis_y: vec3f,
    axis_z: vec3f,
}

fn has_table(light: u32) -> bool {
    return light < 32u && ((BUFFERED_LIGHTS >> (light & 31u)) & 1u) != 0u;
}

fn directions_of(light: u32) -> Directions {
    let layer = countOneBits(BUFFERED_LIGHTS & ((1u << (light & 31u)) - 1u));
    let row = textureDimensions(shadow_buffers).y - 1u;
    let size = textureLoad(shadow_buffers, vec2u(0u, row), layer, 0).xy;
    let theta = bitcast<vec2f>(textureLoad(shadow_buffers, vec2u(1u, row), layer, 0).xy);
    let phi = bitcast<vec2f>(textureLoad(shadow_buffers, vec2u(2u, row), layer, 0).xy);
    let a = bitcast<vec2f>(textureLoad(shadow_buffers, vec2u(3u, row), layer, 0).xy);
    let b = bitcast<vec2f>(textureLoad(shadow_buffers, vec2u(4u, row), layer, 0).xy);
    let c = bitcast<vec2f>(textureLoad(shadow_buffers, vec2u(5u, row), layer, 0).xy);
    let x = vec3f(a.x, a.y, b.x);
    let z = vec3f(b.y, c.x, c.y);
    let whole = theta.x == 0.0;
    return Directions(layer, i32(size.y), i32(size.x), whole, theta.x, theta.y, phi.x, phi.y, x, cross(z, x), z);
}

// Vectors along the table's axes.
fn turned(table: Directions, v: F3) -> F3 {
    return F3(along(v, table.axis_x), along(v, table.axis_y), along(v, table.axis_z));
}

// Row and column of directions along the axes, in texels.
fn table_row(table: Directions, v: F3) -> F {
    return (atan2(sqrt(v.x * v.x + v.y * v.y), v.z) - table.theta_begin) / table.theta_step;
}

fn table_column(table: Directions, v: F3) -> F {
    let phi = atan2(v.y, v.x);
    return (select(phi, phi + 6.2831853, (phi < F(0.0)) & B(table.whole)) - table.phi_begin) / table.phi_step;
}

// t as bits and the primitive's place. Beyond a pole is the other side's row, beyond the last column the first one.
fn texel_of(table: Directions, row: i32, column: i32) -> vec2u {
    let last = table.rows - 1;
    let beyond = row < 0 || row > last;
    let mirrored = select(select(row, 2 * last + 1 - row, row > last), -1 - row, row < 0);
    let around = (column + select(0, table.columns / 2, beyond) + 2 * table.columns) % table.columns;
    let known = table.whole || !(beyond || column < 0 || column >= table.columns);
    let place = vec2i(select(column, around, table.whole), select(row, mirrored, table.whole));
    let texel = textureLoad(shadow_buffers, clamp(place, vec2i(0), vec2i(table.columns - 1, last)), table.layer, 0).xy;
    return vec2u(texel.x, select(UNFILLED, texel.y, known));
}

//! if shadow_buffer is object or depth
// The one texel in which a point's direction lies.
fn said_by_table(light: u32, wanted: B, ray: ShadowRay) -> Said {
    var said = Said(wanted, U(MISS));
    if !has_table(light) { return said; }
    let table = directions_of(light);
    let direction = turned(table, ray.direction);
    let rows = floor(table_row(table, direction));
    let columns = floor(table_column(table, direction));
    var index = 0u;
    loop {
        if of_ray_b(wanted, index) {
            let row = clamp(i32(of_ray(rows, index)), 0, table.rows - 1);
            let texel = texel_of(table, row, i32(of_ray(columns, index)));
            let hidden = is_hidden_by(texel, table.theta_step, ray, index);
            if texel.y != UNFILLED {
                said.unknown = without_ray(said.unknown, index);
                // Of nothing no place among the primitives says that it hides a light.
                said.occluders = with_ray_u(said.occluders, index, select(MISS, min(texel.y, UNFILLED), hidden));
            }
        }
        index += 1u;
        if index >= RAYS { break; }
    }
    return said;
}

//! if shadow_buffer is object
// Whether another object is the nearest one, or none.
fn is_hidden_by(texel: vec2u, step: f32, ray: ShadowRay, index: u32) -> bool {
    if texel.y >= UNFILLED { return true; }
    return primitive_texel(texel.y, 1u).w != of_ray_u(asked_component, index);
}

//! if shadow_buffer is depth
// Whether what is nearest is nearer than the point by more than a bias, of so many widths of a texel there, and more the more the surface slants.
fn is_hidden_by(texel: vec2u, step: f32, ray: ShadowRay, index: u32) -> bool {
    let cosine = clamp(-dot(of_ray3(asked_normal, index), of_ray3(ray.direction, index)), 1e-3, 1.0);
    let slope = sqrt(1.0 - cosine * cosine) / cosine;
    let distance = of_ray(ray.distance, index);
    return bitcast<f32>(texel.x) < distance - BUFFER_MARGIN * distance * step * (1.0 + slope);
}

//! if shadow_buffer is hybrid
// Texels a side of the square around a point's direction that are asked.
const ASKED_SIDE: i32 = 2;
// A texel says nothing of a plane that its direction meets farther away than so many times as far as the point lies: of a surface that slants so much,
// a texel covers more than what stands on it.
const FARTHEST_ALONG: f32 = 1.03;
// What a texel shows may be so many widths of a texel behind the plane of the point's surface to be that surface.
const ONE_SURFACE: f32 = 1.0;

// A point that asks, as seen from a light.
struct Asking {
    place: vec2f,        // row and column of its direction
    from_light: vec3f,
    normal: vec3f,       // of its surface
    height: f32,         // of its surface's plane from the light, along the normal: below 0, since it faces the light
    distance: f32,
    component: u32,
}

// What a square of texels says of one point.
struct Neighbours {
    own: i32,          // how many show the point's own surface
    before: i32,       // how many show something that is before it
    one: bool,         // whether that lies in one plane and hangs together
    first: u32,        // what the first and the last of these show
    last: u32,
}

// Where all texels of the square show the point's own surface, or of a ball nothing before it, the light is taken to be open; where all show one plane before it, to be hidden. Else
// a primitive before it that is met is proof, and if none is nothing is said.
fn said_by_table(light: u32, wanted: B, ray: ShadowRay) -> Said {
    var said = Said(wanted, U(MISS));
    if !has_table(light) { return said; }
    let table = directions_of(light);
    let direction = turned(table, ray.direction);
    let rows = table_row(table, direction);
    let columns = table_column(table, direction);
    let height = dot3(asked_normal, ray.direction) * ray.distance;
    var firsts = U(MISS);
    var lasts = U(MISS);
    var index = 0u;
    loop {
        if of_ray_b(wanted, index) {
            let place = vec2f(of_ray(rows, index), of_ray(columns, index));
            let distance = of_ray(ray.distance, index);
            let from_light = of_ray3(ray.direction, index) * distance;
            let normal = of_ray3(asked_normal, index);
            let asking = Asking(place, from_light, normal, of_ray(height, index), distance, of_ray_u(asked_component, index));
            let found = neighbours(table, asking, ray.light);
            let all = ASKED_SIDE * ASKED_SIDE;
            if found.own == all || (found.before == all && found.one) {
                said.unknown = without_ray(said.unknown, index);
                said.occluders = with_ray_u(said.occluders, index, found.first);
            }
            firsts = with_ray_u(firsts, index, found.first);
            lasts = with_ray_u(lasts, index, found.last);
        }
        index += 1u;
        if index >= RAYS { break; }
    }
    said = with_proof(said, firsts, ray);
    return with_proof(said, select(lasts, U(MISS), lasts == firsts), ray);
}

// The same where a ray to an unknown point meets one of the primitives, one for each ray: that is proof.
fn with_proof(before: Said, slots: U, ray: ShadowRay) -> Said {
    var said = before;
    var index = 0u;
    loop {
        let slot = of_ray_u(slots, index);
        if slot < UNFILLED && of_ray_b(said.unknown, index) && is_occluded_by(slot, ray, index) {
            said.unknown = without_ray(said.unknown, index);
            said.occluders = with_ray_u(said.occluders, index, slot);
        }
        index += 1u;
        if index >= RAYS { break; }
    }
    return said;
}

// A texel shows what is before the point where that is nearer than the plane of the point's surface, along the texel's direction, and the point is behind
// the plane of what is shown. What the point is clearly above of can't hide the light from it, as a wall beside a floor that both face the light; where it
// is hard to say, the texel shows neither.
fn neighbours(table: Directions, asking: Asking, light: vec3f) -> Neighbours {
    var found = Neighbours(0, 0, true, MISS, MISS);
    // Where the first of those that are before the point is, its normal, and its component.
    var at_first: vec3f;
    var normal: vec3f;
    var component: u32;
    // A ball has no rims that stand up from it, so a texel that passes it by says as much as one that shows it.
    let is_convex = (asking.component & IS_SPHERE) != 0u;
    // The square's first texel; middles stand half a texel behind its begin.
    let first = vec2i(ceil(asking.place - 0.5 - 0.5 * f32(ASKED_SIDE)));
    var at = 0;
    loop {
        let row = first.x + at / ASKED_SIDE;
        let column = first.y + at % ASKED_SIDE;
        let direction = table_direction(table, row, column);
        let slope = dot(asking.normal, direction);
        let meets = slope * FARTHEST_ALONG * asking.distance < asking.height;
        let plane = asking.height / select(-1.0, slope, meets);
        let texel = texel_of(table, row, column);
        let t = bitcast<f32>(texel.x);
        let width = table.theta_step * asking.distance;
        let there = direction * t;
        if texel.y < UNFILLED {
            let seen = surface_at(Rays(light, all3(direction)), Hits(F(t), U(0u), U(texel.y)), 0u);
            let above = dot(seen.geometric_normal, asking.from_light - there);
            let margin = BUFFER_MARGIN * width;
            let nearer = !meets || t < plane - margin;
            if nearer && above < -margin {
                if found.first == MISS {
                    found.first = texel.y;
                    at_first = there;
                    normal = seen.geometric_normal;
                    component = seen.component;
                }
                found.last = texel.y;
                found.before += 1;
                found.one &= component == seen.component;
                found.one &= abs(dot(normal, there - at_first)) <= BUFFER_MARGIN * table.theta_step * t;
            } else if meets && (t < plane + ONE_SURFACE * width || is_convex) && (!nearer || above > margin) {
                found.own += 1;
            }
        } else if texel.y == MISS && meets && is_convex {
            found.own += 1;
        }
        at += 1;
        if at >= ASKED_SIDE * ASKED_SIDE { break; }
    }
    return found;
}

// The direction of a texel's middle, in the world.
fn table_direction(table: Directions, row: i32, column: i32) -> vec3f {
    let theta = table.theta_begin + (f32(row) + 0.5) * table.theta_step;
    let phi = table.phi_begin + (f32(column) + 0.5) * table.phi_step;
    let across = sin(theta);
    return table.axis_x * (across * cos(phi)) + table.axis_y * (across * sin(phi)) + table.axis_z * cos(theta);
}

//! if shadow_buffer is object or depth or hybrid and visibility is traced
// As visibility.wgsl has it, with rays to those alone of which the table says nothing.
fn lit_by(light: u32, wanted: B, ray: ShadowRay) -> B {
    let said = said_by_table(light, wanted, ray);
    var occluders = said.occluders;
    if any_ray(said.unknown) { occluders = select(occluders, occluders_of(ray, said.unknown), said.unknown); }
    let lit = wanted & (occluders == U(MISS));
    if KEEP_BITS && light < 16u {
        found_bits |= select(U(0u), U(1u << (light + 16u)), wanted) | select(U(0u), U(1u << light), lit);
        found_occluders = select(found_occluders, select(occluders, U(MISS), occluders == U(UNFILLED)), wanted & !lit);
    }
    return lit;
}

//! if shadow_buffer is object or depth or hybrid and visibility is taken_or_traced
// As visibility.wgsl has it: the source's samples come first.
fn lit_by(light: u32, wanted: B, ray: ShadowRay) -> B {
    let known = is_known(taken, light);
    let unknown = wanted & !known;
    var lit = wanted & known & is_lit(taken, light);
    if any_ray(unknown) {
        var open = unknown;
        if KEEP_OCCLUDERS { open &= !hidden_likewise(unknown, ray); }
        let said = said_by_table(light, open, ray);
        lit |= open & !said.unknown & (said.occluders == U(MISS));
        if any_ray(said.unknown) { lit |= said.unknown & (occluders_of(ray, said.unknown) == U(MISS)); }
    }
    return lit;
}
