// Shadow-buffers: a table of directions around each of the first point lights, drawn by the T-buffer's kernels
// (docs/SHADOW-BUFFER.md), which stands between a light and its shadow rays.

// In the place of a texel's primitive: nothing is known of its direction.
const UNFILLED: u32 = 0xfffffffeu;
// With a texel's primitive: something may stand before the plane of what it shows.
const SOMETHING_BEFORE: u32 = 0x80000000u;
// Of the distance from the light: by more than this planes and points do not round.
const ON_PLANE: f32 = 4e-6;

//! if shadow_buffer is object or depth or hybrid
// A layer a light: t as bits and the primitive's place in each texel, or what read_texels.wgsl says. Behind the last
// row stands where directions are: src/steps/shadow_buffer.rs.
@group(1) @binding(8) var shadow_buffers: texture_2d_array<u32>;

// What lit_by asks for, besides a ray.
var<private> asked_normal: F3;      // unit, geometric, towards the viewer
var<private> asked_component: U;

fn ask_tables(surfaces: Surfaces) {
    asked_normal = surfaces.geometric_normal;
    asked_component = surfaces.component;
}

// What a light's table says of points: nothing of those that are unknown; of others what hides the light from them, or
// MISS.
struct Said {
    unknown: B,
    occluders: U,
}

// Where directions stand in a light's table.
struct Directions {
    layer: u32,
    rows: i32,
    columns: i32,
    whole: bool,         // all directions: behind the last column is the first one
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

fn layer_of(light: u32) -> u32 {
    return countOneBits(BUFFERED_LIGHTS & ((1u << (light & 31u)) - 1u));
}

fn directions_in(layer: u32, size: vec2u, theta: vec2f, phi: vec2f, x: vec3f, z: vec3f) -> Directions {
    return Directions(layer, i32(size.y), i32(size.x), theta.x == 0.0, theta.x, theta.y, phi.x, phi.y, x, cross(z, x), z);
}

//! if shadow_buffer is object or depth
fn directions_of(light: u32) -> Directions {
    let layer = layer_of(light);
    let row = textureDimensions(shadow_buffers).y - 1u;
    let size = textureLoad(shadow_buffers, vec2u(0u, row), layer, 0).xy;
    let theta = bitcast<vec2f>(textureLoad(shadow_buffers, vec2u(1u, row), layer, 0).xy);
    let phi = bitcast<vec2f>(textureLoad(shadow_buffers, vec2u(2u, row), layer, 0).xy);
    let a = bitcast<vec2f>(textureLoad(shadow_buffers, vec2u(3u, row), layer, 0).xy);
    let b = bitcast<vec2f>(textureLoad(shadow_buffers, vec2u(4u, row), layer, 0).xy);
    let c = bitcast<vec2f>(textureLoad(shadow_buffers, vec2u(5u, row), layer, 0).xy);
    return directions_in(layer, size, theta, phi, vec3f(a.x, a.y, b.x), vec3f(b.y, c.x, c.y));
}

//! if shadow_buffer is hybrid
fn directions_of(light: u32) -> Directions {
    let layer = layer_of(light);
    let row = textureDimensions(shadow_buffers).y - 1u;
    let a = textureLoad(shadow_buffers, vec2u(0u, row), layer, 0);
    let b = bitcast<vec4f>(textureLoad(shadow_buffers, vec2u(1u, row), layer, 0));
    let c = bitcast<vec4f>(textureLoad(shadow_buffers, vec2u(2u, row), layer, 0));
    return directions_in(layer, a.xy, bitcast<vec2f>(a.zw), b.xy, vec3f(b.z, b.w, c.x), c.yzw);
}

//! if shadow_buffer is object or depth or hybrid
// Vectors along the table's axes.
fn turned(table: Directions, v: F3) -> F3 {
    return F3(along(v, table.axis_x), along(v, table.axis_y), along(v, table.axis_z));
}

// Row and column of directions along the axes, in texels.
fn table_row(table: Directions, v: F3) -> F {
    return (arctangent(sqrt(v.x * v.x + v.y * v.y), v.z) - table.theta_begin) / table.theta_step;
}

fn table_column(table: Directions, v: F3) -> F {
    let phi = arctangent(v.y, v.x);
    return (select(phi, phi + 6.2831853, (phi < F(0.0)) & B(table.whole)) - table.phi_begin) / table.phi_step;
}

// The texel of a place. Beyond the last column is the first one.
fn texel_of(table: Directions, row: i32, column: i32) -> vec4u {
    let last = vec2i(table.columns, table.rows) - 1;
    let around = select(column, (column + table.columns) % table.columns, table.whole);
    let is_there = row >= 0 && row <= last.y && around >= 0 && around <= last.x;
    let place = clamp(vec2i(around, row), vec2i(0), last);
    return select(vec4u(UNFILLED), textureLoad(shadow_buffers, place, table.layer, 0), is_there);
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
            let texel = texel_of(table, row, i32(of_ray(columns, index))).xy;
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
// Whether what is nearest is nearer than the point by more than a bias, of so many widths of a texel there, and more
// the more the surface slants.
fn is_hidden_by(texel: vec2u, step: f32, ray: ShadowRay, index: u32) -> bool {
    let cosine = clamp(-dot(of_ray3(asked_normal, index), of_ray3(ray.direction, index)), 1e-3, 1.0);
    let slope = sqrt(1.0 - cosine * cosine) / cosine;
    let distance = of_ray(ray.distance, index);
    return bitcast<f32>(texel.x) < distance - BUFFER_MARGIN * distance * step * (1.0 + slope);
}

//! if shadow_buffer is hybrid
// Texels that a point asks: the one in which its direction lies, and the nearest one across a corner.
const ASKED_TEXELS: u32 = 2u;
// The cosine between the normals of a point and of what its texel shows, if these are one surface.
const LOOKS_ALIKE: f32 = 0.8;

// A point behind what its texel shows, or the next one, or the other points' of the lane, is hidden if its ray meets
// it: that is proof. Of the others those are lit that are on the plane of what their texel shows, or behind it by no
// more than the margin, if nothing stands before that. Else nothing is said.
fn said_by_table(light: u32, wanted: B, ray: ShadowRay) -> Said {
    var said = Said(wanted, U(MISS));
    if !has_table(light) { return said; }
    let table = directions_of(light);
    let direction = turned(table, ray.direction);
    let row = table_row(table, direction);
    let column = table_column(table, direction);
    let below = select(F(-1.0), F(1.0), fract(row) >= F(0.5));
    let beside = select(F(-1.0), F(1.0), fract(column) >= F(0.5));
    var nearly_on: B;
    var turn = 0u;
    loop {
        let rows = floor(row) + below * f32(turn);
        let columns = floor(column) + beside * f32(turn);
        var planes: F3;
        var shown = U(UNFILLED);
        var index = 0u;
        loop {
            if of_ray_b(said.unknown, index) {
                let texel = texel_of(table, i32(of_ray(rows, index)), i32(of_ray(columns, index)));
                planes = with_ray3(planes, index, bitcast<vec3f>(texel.xyz));
                shown = with_ray_u(shown, index, texel.w);
            }
            index += 1u;
            if index >= RAYS { break; }
        }
        let behind = dot3(planes, ray.direction) * ray.distance - 1.0;
        let may_hide = said.unknown & (shown < U(UNFILLED)) & (behind > F(0.0));
        var on: B;
        if turn == 0u {
            let size = ray.distance * sqrt(dot3(planes, planes));
            let is_clear = shown < U(SOMETHING_BEFORE);
            // Shadow rays end off their surfaces, before the plane; on a ball's near side before that of its outline,
            // whose far side is behind it.
            on = is_clear & (behind <= 0.25 * ON_PLANE * size);
            // A surface that curves lies behind a plane of its own by little, and looks the same way.
            let alike = -dot3(planes, asked_normal) * ray.distance >= LOOKS_ALIKE * size;
            nearly_on = is_clear & alike & (behind <= (BUFFER_MARGIN * table.theta_step + 0.25 * ON_PLANE) * size);
        }
        said = with_proof(said, may_hide, shown & U(SOMETHING_BEFORE - 1u), on | nearly_on, ray);
        said.unknown &= !on;
        turn += 1u;
        if turn >= ASKED_TEXELS || !any_ray(said.unknown) { break; }
    }
    said.unknown &= !nearly_on;
    return said;
}

// What is said besides of unknown points where one of these primitives, of open points one each, hides them. Points
// that a plane says to be lit try their own primitive alone: a margin lets more than rays do, and which points share a
// lane must not change a picture. Of the others a ray would say the same.
fn with_proof(before: Said, asked: B, slots: U, lit: B, ray: ShadowRay) -> Said {
    var said = before;
    var open = asked;
    loop {
        if !any_ray(open) { break; }
        let slot = of_ray_u(slots, first_ray(open));
        let own = asked & (slots == U(slot));
        let hidden = occluded_by(slot, ray) & said.unknown & (own | !lit);
        said.occluders = select(said.occluders, U(slot), hidden);
        said.unknown &= !hidden;
        open &= !own & !hidden;
    }
    return said;
}

//! if shadow_buffer is none
fn ask_tables(surfaces: Surfaces) {}

fn hidden_from(light: u32, ray: ShadowRay, wanted: B) -> U { return occluders_of(ray, wanted); }

//! if shadow_buffer is object or depth or hybrid
// What hides a light from points: as its table says, and as rays say to those alone of which it says nothing.
fn hidden_from(light: u32, ray: ShadowRay, wanted: B) -> U {
    let said = said_by_table(light, wanted, ray);
    if !any_ray(said.unknown) { return said.occluders; }
    return select(said.occluders, occluders_of(ray, said.unknown), said.unknown);
}
