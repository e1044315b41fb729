// Shadow-buffers: tables of directions around the first point lights, drawn by the T-buffer's kernels
// (docs/SHADOW-BUFFER.md). They replace most shadow rays.

//! use angles, fetch, lane, light, pixels, rays, shadows

// Value stored in place of a texel's slot if the visibility in its direction is unknown.
const UNFILLED: u32 = 0xfffffffeu;
// Flag in a texel's slot, set if an occluder may lie in front of the plane of the primitive that the texel shows.
const SOMETHING_BEFORE: u32 = 0x80000000u;
// Bound of the rounding error of planes and points, as a fraction of the distance from the light.
const ON_PLANE: f32 = 4e-6;

//! if shadow_buffer is object or depth or hybrid
// The texture has one layer per light. Each texel holds the bits of t and the slot, or the result of read_texels.wgsl.
// An additional last row describes the directions (src/shadow_buffer/mod.rs).
var shadow_buffers: texture_2d_array<u32>;

// Data of the surfaces that lit_by needs in addition to its arguments.
var<private> asked_normal: F3;      // unit, geometric, towards the viewer
var<private> asked_component: U;

fn ask_tables(surfaces: Surfaces) {
    asked_normal = surfaces.geometric_normal;
    asked_component = surfaces.component;
}

// Visibility of a light at each point according to the light's table. For known points, `occluders` holds the slot of
// the occluder, or MISS if the light is visible.
struct Said {
    unknown: B,
    occluders: U,
}

// Layout of directions in a light's table.
struct Directions {
    layer: u32,
    rows: i32,
    columns: i32,
    whole: bool,         // whether the table covers all directions, so that columns wrap around
    theta_begin: f32,    // theta of the first row, radians
    theta_step: f32,     // theta per row, radians
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
    return Directions(
        layer,
        i32(size.y),
        i32(size.x),
        theta.x == 0.0,
        theta.x,
        theta.y,
        phi.x,
        phi.y,
        x,
        cross(z, x),
        z,
    );
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
// Transforms vectors to the table's axes.
fn turned(table: Directions, v: F3) -> F3 {
    return F3(along(v, table.axis_x), along(v, table.axis_y), along(v, table.axis_z));
}

// These functions return the row and the column, in texels, of directions in the table's axes.
fn table_row(table: Directions, v: F3) -> F {
    return (arctangent(sqrt(v.x * v.x + v.y * v.y), v.z) - table.theta_begin) / table.theta_step;
}

fn table_column(table: Directions, v: F3) -> F {
    let phi = arctangent(v.y, v.x);
    return (select(phi, phi + 6.2831853, (phi < F(0.0)) & B(table.whole)) - table.phi_begin) / table.phi_step;
}

// Returns the texel at a row and column, or UNFILLED outside the table. Columns of a whole table wrap around.
fn texel_of(table: Directions, row: i32, column: i32) -> vec4u {
    let last = vec2i(table.columns, table.rows) - 1;
    let around = select(column, (column + table.columns) % table.columns, table.whole);
    let is_there = row >= 0 && row <= last.y && around >= 0 && around <= last.x;
    let place = clamp(vec2i(around, row), vec2i(0), last);
    return select(vec4u(UNFILLED), textureLoad(shadow_buffers, place, table.layer, 0), is_there);
}

//! if shadow_buffer is object or depth
// Looks up the one texel that contains a point's direction.
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
                // An empty texel has no slot, so UNFILLED represents its occluder.
                said.occluders = with_ray_u(said.occluders, index, select(MISS, min(texel.y, UNFILLED), hidden));
            }
        }
        index += 1u;
        if index >= RAYS { break; }
    }
    return said;
}

//! if shadow_buffer is object
// Returns whether the texel shows another object than the point's object, or none.
fn is_hidden_by(texel: vec2u, step: f32, ray: ShadowRay, index: u32) -> bool {
    if texel.y >= UNFILLED { return true; }
    return primitive_texel(texel.y, 1u).w != of_ray_u(asked_component, index);
}

//! if shadow_buffer is depth
// Returns whether the nearest surface is nearer than the point by more than a bias. The bias is BUFFER_MARGIN texel
// widths at the point's distance, and more for slanted surfaces.
fn is_hidden_by(texel: vec2u, step: f32, ray: ShadowRay, index: u32) -> bool {
    let cosine = clamp(-dot(of_ray3(asked_normal, index), of_ray3(ray.direction, index)), 1e-3, 1.0);
    let slope = sqrt(1.0 - cosine * cosine) / cosine;
    let distance = of_ray(ray.distance, index);
    return bitcast<f32>(texel.x) < distance - BUFFER_MARGIN * distance * step * (1.0 + slope);
}

//! if shadow_buffer is hybrid
// Number of texels looked up for a point: the texel that contains its direction, and the nearest diagonal neighbour.
const ASKED_TEXELS: u32 = 2u;
// Minimum cosine between the normals of a point and of its texel's surface, if both count as one surface.
const LOOKS_ALIKE: f32 = 0.8;

// A point is hidden if its ray hits the primitive of one of its texels, or of a texel of the lane's other points.
// Otherwise the point is lit if it lies on the plane of its texel's primitive, or behind the plane within the margin.
// This requires that nothing lies in front of that plane. In all other cases the result is unknown.
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
            // Shadow rays end off their surfaces, in front of the plane. On a sphere's near side they end in front of
            // the plane of its outline, since its far side lies behind that plane.
            on = is_clear & (behind <= 0.25 * ON_PLANE * size);
            // A curved surface lies slightly behind its texel's plane and has a similar normal.
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

// Tests the unknown points against the primitives of the given slots, one primitive per round. A point that its plane
// shows as lit is tested against its own texel's primitive only. The margin tolerates more than rays do, and the
// picture must not depend on which points share a lane. For other points the result equals the result of a shadow ray.
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
// Returns the occluders of a light at points, according to its table. Shadow rays are traced only for points that the
// table leaves unknown.
fn hidden_from(light: u32, ray: ShadowRay, wanted: B) -> U {
    let said = said_by_table(light, wanted, ray);
    if !any_ray(said.unknown) { return said.occluders; }
    return select(said.occluders, occluders_of(ray, said.unknown), said.unknown);
}
