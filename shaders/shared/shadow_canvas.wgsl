// The shadow-buffer of a light, as a canvas on which primitives are drawn (docs/SHADOW-BUFFER.md). A row of texels
// corresponds to an angle theta from a pole, and a column to an azimuth phi. In these coordinates the edges of
// triangles are curves. All tests therefore use planes through the light, so triangles across the seam or around a pole
// need no special case.

//! use angles, camera, counters, ellipsoid, fetch, frame, lane, pixels, planes, primitive, primitives, rays
//! use shadow_buffer, t_buffer, tiles, triangle

//! if canvas is middles or texels
// A shadow-buffer needs no projection. This type is a placeholder.
alias Canvas = u32;

fn canvas_at_work() -> Canvas { return 0u; }

fn counted_row() -> u32 { return 0u; }

// Returns the texels of a thread in a dispatch over blocks.
fn block_texels(id: vec3u) -> Pixels {
    let first = pixel_in_tile(id.xy) * BLOCK;
    return Pixels(RAY_X + U(first.x), RAY_Y + U(first.y));
}

fn inside_table(texels: Pixels) -> B {
    return (texels.x < U(frame.mapping.columns)) & (texels.y < U(frame.band.size.y));
}

// The nearest hit in a texel.
struct Shown {
    t: f32,
    slot: u32,
}

// Returns the nearer of two hits: the hit stored in the T-buffer's two words, and the hit on the nearest plane. At
// equal t the primitive of the tree wins, since its id is smaller.
fn shown_at(drawn: vec2u, nearest: Hits, ray: u32) -> Shown {
    let t = bitcast<f32>(~drawn.x);
    if drawn.x != 0u && t <= of_ray(nearest.t, ray) { return Shown(t, select(drawn.y - 1u, UNFILLED, drawn.y == 0u)); }
    return Shown(
        of_ray(nearest.t, ray),
        select(of_ray_u(nearest.slot, ray), MISS, of_ray_u(nearest.primitive, ray) == MISS),
    );
}

fn count_test(place: vec2u) {
    atomicAdd(&counters[PRIMITIVES_TESTED], 1u);
}

// Returns an upper bound of the rounding error of angles and positions in the table, in texels.
fn slack_of_places() -> f32 { return 0.02 + 4e-6 / frame.mapping.theta_step; }

// A cone of directions from the light that contains a primitive.
struct Cap {
    axis: vec3f,      // unit
    radius: f32,      // in radians; ALL_AROUND if the primitive may lie in any direction
    sine: f32,        // sine of the radius
}

const ALL_AROUND: f32 = 4.0;
// Upper bound of the rounding error of a cone's angles, in radians.
const CAP_SLACK: f32 = 4e-6;

fn cap_around(axis: vec3f, sine: f32, cosine: f32, is_narrow: bool) -> Cap {
    let radius = angle_of(sine, cosine) + CAP_SLACK;
    return Cap(
        select(frame.mapping.axis_z, axis, is_narrow),
        select(ALL_AROUND, radius, is_narrow),
        select(1.0, sine + CAP_SLACK, is_narrow),
    );
}

// Maximum chord of a narrow cone. For wider triangles, the mean direction of the corners is a poor axis.
const WIDEST_CHORD: f32 = 1.2;

// Returns a cone around the sum of the corners' directions. A cone narrower than a hemisphere contains the triangle if
// it contains the corners.
fn triangle_cap(primitive: Primitive) -> Cap {
    let a = normalize(primitive.a - eye_point());
    let b = normalize(primitive.b - eye_point());
    let c = normalize(primitive.c - eye_point());
    let axis = normalize(a + b + c);
    // The radius is computed from chords, since the cosine of a small angle is inexact.
    let chord = max(length(a - axis), max(length(b - axis), length(c - axis)));
    let is_narrow = chord < WIDEST_CHORD;
    let half = 0.5 * select(0.0, chord, is_narrow);
    let rest = 1.0 - half * half;
    return cap_around(axis, 2.0 * half * sqrt(rest), rest - half * half, is_narrow);
}

// Returns the cone of directions from the light that contains a sphere. An ellipsoid uses the cone of its enclosing
// sphere.
fn ball_cap(primitive: Primitive) -> Cap {
    let center = primitive.a - eye_point();
    let distance = length(center);
    let is_narrow = ball_radius(primitive) < 0.99 * distance;
    let sine = select(0.0, ball_radius(primitive) / distance, is_narrow);
    return cap_around(center / distance, sine, sqrt((1.0 - sine) * (1.0 + sine)), is_narrow);
}

fn angle_of(sine: f32, cosine: f32) -> f32 { return of_ray(arctangent(F(sine), F(cosine)), 0u); }

// Ranges of angles, in radians. phi is measured from the table's first column.
struct Angles {
    theta: vec2f,
    phi: vec2f,
    all_around: bool,    // whether any phi is possible
}

fn angles_of(cap: Cap) -> Angles {
    let x = dot(cap.axis, frame.mapping.axis_x);
    let y = dot(cap.axis, frame.mapping.axis_y);
    let aside = sqrt(x * x + y * y);
    let theta = angle_of(aside, dot(cap.axis, frame.mapping.axis_z));
    // If the cone contains a pole, any azimuth is possible.
    let has_pole = cap.radius >= theta - CAP_SLACK || cap.radius >= 3.1415926 - theta - CAP_SLACK;
    let sine = min(cap.sine / max(aside, 1e-9), 1.0);
    // For a sine near 1, rounding affects the cosine more than the sine.
    let wide = angle_of(sine, sqrt((1.0 - sine) * (1.0 + sine))) + 2e-3 * sine * sine * sine + CAP_SLACK;
    let phi = angle_of(y, x) - frame.mapping.phi_begin;
    return Angles(vec2f(theta - cap.radius, theta + cap.radius), vec2f(phi - wide, phi + wide), has_pole);
}

// Returns the ranges of angles of a triangle. If its cone contains no pole, they are computed from its corners. The
// range of theta also includes the point at which an edge's great circle comes nearest to a pole. The ranges are
// tighter than the cone's, so thin triangles cover no more texels than necessary.
fn triangle_angles(primitive: Primitive) -> Angles {
    let around = angles_of(triangle_cap(primitive));
    if around.all_around { return around; }
    let turn = mat3x3f(frame.mapping.axis_x, frame.mapping.axis_y, frame.mapping.axis_z);
    let a = normalize(primitive.a - eye_point()) * turn;
    let b = normalize(primitive.b - eye_point()) * turn;
    let c = normalize(primitive.c - eye_point()) * turn;
    let middle = 0.5 * (around.phi.x + around.phi.y);
    let phis = vec3f(phi_beside(a, middle), phi_beside(b, middle), phi_beside(c, middle));
    let low = max(around.phi.x, min(phis.x, min(phis.y, phis.z)) - CAP_SLACK);
    let high = min(around.phi.y, max(phis.x, max(phis.y, phis.z)) + CAP_SLACK);
    let edges = array<vec2f, 3>(thetas_of(a, b), thetas_of(b, c), thetas_of(c, a));
    let first = max(around.theta.x, min(edges[0].x, min(edges[1].x, edges[2].x)) - CAP_SLACK);
    let last = min(around.theta.y, max(edges[0].y, max(edges[1].y, edges[2].y)) + CAP_SLACK);
    return Angles(vec2f(first, last), vec2f(low, high), false);
}

// Returns the phi of a direction in the table's axes, at most half a turn from `middle`.
fn phi_beside(v: vec3f, middle: f32) -> f32 {
    let phi = angle_of(v.y, v.x) - frame.mapping.phi_begin;
    return phi - TURN * floor((phi - middle) / TURN + 0.5);
}

const TURN: f32 = 6.2831853;

// Returns the smallest and largest theta of an edge between two unit vectors in the table's axes. If theta falls from
// both ends towards the middle, or rises from both, its extremum lies between them. The angle between the extremum and
// the pole equals the angle between the normal of the edge's plane and the equator.
fn thetas_of(a: vec3f, b: vec3f) -> vec2f {
    let from_a = angle_of(length(a.xy), a.z);
    let from_b = angle_of(length(b.xy), b.z);
    let along_edge = dot(a, b);
    let rises = vec2f(b.z - a.z * along_edge, a.z - b.z * along_edge);
    let normal = cross(a + b, b - a);
    let turning = angle_of(abs(normal.z), length(normal.xy));
    let low = select(min(from_a, from_b), turning, all(rises > vec2f(0.0)));
    let high = select(max(from_a, from_b), 0.5 * TURN - turning, all(rises < vec2f(0.0)));
    return vec2f(low, high);
}

// Returns the range of texels, within the current rows, that ranges of angles may reach: first column, first row, last
// column, last row. If a first value exceeds its last one, the range is empty. Columns may exceed the last one of the
// table, since they wrap around.
fn texels_over(angles: Angles, reaches: vec2f) -> vec4i {
    let rows = i32(frame.band.size.y);
    let begin = i32(frame.band.first_row);
    let columns = i32(frame.mapping.columns);
    let first_row = clamp(begin_of(angles.theta.x - frame.mapping.theta_begin, reaches), f32(begin), f32(begin + rows));
    let last_row = clamp(
        end_of(angles.theta.y - frame.mapping.theta_begin, reaches),
        f32(begin - 1),
        f32(begin + rows - 1),
    );
    let is_whole = frame.mapping.theta_begin == 0.0;
    var first_column = i32(clamp(begin_of(angles.phi.x, reaches), -2.0 * f32(columns), 2.0 * f32(columns)));
    var last_column = i32(clamp(end_of(angles.phi.y, reaches), -2.0 * f32(columns), 2.0 * f32(columns)));
    if angles.all_around || (is_whole && last_column - first_column >= columns - 1) {
        first_column = 0;
        last_column = columns - 1;
    } else if is_whole {
        let turn = select(0, columns, first_column < 0) - select(0, columns, first_column >= columns);
        first_column += turn;
        last_column += turn;
    } else {
        first_column = clamp(first_column, 0, columns);
        last_column = clamp(last_column, -1, columns - 1);
    }
    return vec4i(first_column, i32(first_row), last_column, i32(last_row));
}

// These functions return the first and the last texel that a range of angles may reach. `reaches` holds the upper and
// the lower end of a texel's extent, in texels from the texel's begin.
fn begin_of(angle: f32, reaches: vec2f) -> f32 { return ceil(angle / frame.mapping.theta_step - reaches.x); }
fn end_of(angle: f32, reaches: vec2f) -> f32 { return floor(angle / frame.mapping.theta_step - reaches.y); }

fn is_out_of_sight(primitive: Primitive, canvas: Canvas) -> bool { return false; }

// Returns a lane's texels with their columns wrapped around into the table.
fn on_canvas(texels: Pixels) -> Pixels {
    let columns = U(frame.mapping.columns);
    return Pixels(select(texels.x, texels.x - columns, texels.x >= columns), texels.y);
}

// Returns rays from the light through texel centres.
fn rays_from(texels: Pixels) -> Rays {
    return Rays(eye_point(), directions_at(F(texels.y + frame.band.first_row) + 0.5, F(texels.x) + 0.5));
}

// Returns directions at rows and columns of the table, in texels.
fn directions_at(rows: F, columns: F) -> F3 {
    let theta = rows * frame.mapping.theta_step + frame.mapping.theta_begin;
    let phi = columns * frame.mapping.phi_step + frame.mapping.phi_begin;
    let across = sine(theta);
    let x = across * cosine(phi);
    let y = across * sine(phi);
    let z = cosine(theta);
    return F3(
        x * frame.mapping.axis_x.x + y * frame.mapping.axis_y.x + z * frame.mapping.axis_z.x,
        x * frame.mapping.axis_x.y + y * frame.mapping.axis_y.y + z * frame.mapping.axis_z.y,
        x * frame.mapping.axis_x.z + y * frame.mapping.axis_y.z + z * frame.mapping.axis_z.z,
    );
}

// Returns which directions may hit a triangle: they lie on the inner side of all planes through the light and an edge,
// for one of the two windings. `reach` is a tolerance: the sine of the angle to each plane exceeds -reach.
fn is_within_edges(primitive: Primitive, directions: F3, reach: f32) -> B {
    let a = primitive.a - eye_point();
    let b = primitive.b - eye_point();
    let c = primitive.c - eye_point();
    let values = triangle_weights(directions, a, b, c);
    // The normal of a long edge that passes close to the light consists mostly of rounding error.
    let rounding = (length(a) + primitive.reach) * primitive.reach * DOUBT;
    let near = vec3f(
        length(edge_normal(b, c)),
        length(edge_normal(c, a)),
        length(edge_normal(a, b)),
    ) * reach + rounding;
    let one_way = (values.x >= F(-near.x)) & (values.y >= F(-near.y)) & (values.z >= F(-near.z));
    let other_way = (values.x <= F(near.x)) & (values.y <= F(near.y)) & (values.z <= F(near.z));
    return one_way | other_way;
}

// Maximum distance of a direction in a block of 2x2 texels from the block's centre, in rows.
const BLOCK_REACH: f32 = 1.5;

// Returns the blocks of a tile of texels, one bit each, that may lie within a triangle's edges.
fn triangle_blocks(primitive: Primitive, tile: Tile) -> u32 {
    let reach = BLOCK_REACH * frame.mapping.theta_step + CAP_SLACK;
    var bits = 0u;
    var block = 0u;
    loop {
        let columns = F((RAY_INDEX + U(block)) % U(BLOCKS)) * 2.0 + f32(tile.corner.x) + 1.0;
        let rows = F((RAY_INDEX + U(block)) / U(BLOCKS)) * 2.0 + f32(tile.corner.y) + 1.0;
        bits |= bits_of(is_within_edges(primitive, directions_at(rows, columns), reach)) << block;
        block += RAYS;
        if block >= TILE_BLOCKS { break; }
    }
    cut_short |= block < TILE_BLOCKS;
    return bits;
}

//! if canvas is middles or texels and primitives is triangles
fn angles_around(primitive: Primitive) -> Angles { return triangle_angles(primitive); }

//! if canvas is middles or texels and primitives is spheres
fn angles_around(primitive: Primitive) -> Angles { return angles_of(ball_cap(primitive)); }

//! if canvas is middles or texels and primitives is mixed
fn angles_around(primitive: Primitive) -> Angles {
    if is_sphere(primitive) { return angles_of(ball_cap(primitive)); }
    return triangle_angles(primitive);
}

//! if canvas is middles
// Returns the texels whose centres a primitive may cover.
fn drawn_over(primitive: Primitive, canvas: Canvas) -> vec4i {
    let slack = slack_of_places();
    return texels_over(angles_around(primitive), vec2f(0.5 + slack, 0.5 - slack));
}

//! if canvas is texels
// Returns the texels of which a primitive may touch any part.
fn drawn_over(primitive: Primitive, canvas: Canvas) -> vec4i {
    let slack = slack_of_places();
    return texels_over(angles_around(primitive), vec2f(1.0 + slack, -slack));
}

// Marks texels in which a primitive may lie in front of the texel's surface. t_buffer holds the output of read_texels.
fn draw(primitive: Primitive, slot: u32, texels: Pixels, last: vec2i) -> Later {
    let inside = before_end(texels, last);
    let texel = pixel_of_ray(on_canvas(texels), 0u);
    let place = 4u * pixel_index(texel);
    if any_ray(inside) {
        let shown = atomicLoad(&t_buffer[place + 3u]);
        if shown < SOMETHING_BEFORE && shown != slot {
            if COUNT { count_test(texel); }
            let x = bitcast<f32>(atomicLoad(&t_buffer[place]));
            let y = bitcast<f32>(atomicLoad(&t_buffer[place + 1u]));
            let z = bitcast<f32>(atomicLoad(&t_buffer[place + 2u]));
            let at = vec2f(f32(texel.y + frame.band.first_row), f32(texel.x));
            if stands_before(primitive, vec3f(x, y, z), at) { atomicOr(&t_buffer[place + 3u], SOMETHING_BEFORE); }
        }
    }
    return Later(0u, 0u);
}

// This variant defers nothing to a second test.
fn draw_again(primitive: Primitive, slot: u32, texels: Pixels, later: Later) {}

// Maximum distance of a direction in a texel from the texel's centre, in rows.
const TEXEL_REACH: f32 = 0.75;

// Returns the tolerated distance in front of a texel's surface, as a fraction of the distance from the light.
fn allowed_before() -> f32 { return frame.mapping.margin * frame.mapping.theta_step + ON_PLANE; }

fn middle_of(texel: vec2f) -> F3 { return directions_at(F(texel.x + 0.5), F(texel.y + 0.5)); }

// Returns whether a primitive may lie in front of a texel's surface, within the texel. The surface is a plane: the
// points x, relative to the light, with plane . x = 1.
fn stands_before(primitive: Primitive, plane: vec3f, texel: vec2f) -> bool {
    // First tests the largest distance in front of the plane over all points of the primitive, including points outside
    // the texel. This test uses the smallest tolerance, for a texel that faces the plane.
    let size = length(plane);
    if size > 0.0 && 1.0 + most_along(primitive, -plane) <= allowed_before() { return false; }
    return touches_before(primitive, plane, texel);
}

// Maximum width of a texel, in radians. Tables with few rows may have wider texels. Their sides curve by more than the
// distance by which is_before moves the corners outwards.
const WIDEST_TEXEL: f32 = 0.65;

// Returns whether a plane lies in front of another plane somewhere in a texel. The reciprocal of a plane's distance
// from the light is linear in direction. The difference between two planes is therefore largest in a corner of the
// texel. The corners are moved outwards, by more than the curvature of the sides and the rounding of directions. NaN
// counts as in front.
fn is_before(other: vec3f, plane: vec3f, texel: vec2f) -> bool {
    let difference = other - plane;
    let allowed = allowed_before() * length(plane);
    let out = 0.05 + CAP_SLACK / frame.mapping.theta_step;
    var before = frame.mapping.theta_step > WIDEST_TEXEL;
    var corner = 0u;
    loop {
        let aside = select(vec2f(-out), vec2f(1.0 + out), vec2<bool>((corner & 1u) != 0u, (corner & 2u) != 0u));
        let place = texel + aside;
        before |= !(dot(difference, of_ray3(directions_at(F(place.x), F(place.y)), 0u)) <= allowed);
        corner += 1u;
        if corner >= 4u { break; }
    }
    cut_short |= corner < 4u;
    return before;
}

fn triangle_touches_before(primitive: Primitive, plane: vec3f, texel: vec2f) -> bool {
    let reach = TEXEL_REACH * frame.mapping.theta_step + CAP_SLACK;
    if !any_ray(is_within_edges(primitive, middle_of(texel), reach)) { return false; }
    // f32 is too coarse for a large triangle's plane.
    if CLOSE {
        let light = eye_point();
        if is_close(primitive.a - light, primitive.b - light, primitive.c - light, primitive.reach) { return true; }
    }
    return is_before(triangle_plane(primitive), plane, texel);
}

fn ball_touches(primitive: Primitive, texel: vec2f) -> bool {
    let cap = ball_cap(primitive);
    let aside = length(of_ray3(middle_of(texel), 0u) - cap.axis);
    return aside <= cap.radius + TEXEL_REACH * frame.mapping.theta_step + CAP_SLACK;
}

// Returns the plane of a triangle, relative to the light: the dot product of the result with each point of the plane is
// 1. The result is 0 for a plane through the light, since the light sees such a triangle edge-on.
fn triangle_plane(primitive: Primitive) -> vec3f {
    let across = cross(largest_one(primitive.b - primitive.a), largest_one(primitive.c - primitive.a));
    let normal = normalize(largest_one(across));
    let height = dot(normal, primitive.a - eye_point());
    return select(normal / height, vec3f(0.0), height == 0.0);
}

//! if canvas is texels and texels is corners or spheres
// Returns the plane of the circular outline of a sphere, as seen from the light. A primitive behind this plane hides no
// point of the sphere that faces the light. The result is 0 if the light is inside the sphere.
fn ball_plane(primitive: Primitive) -> vec3f {
    let center = primitive.a - eye_point();
    let distance = length(center);
    let radius = primitive.b.x;
    if distance <= radius { return vec3f(0.0); }
    return center / ((distance - radius) * (distance + radius));
}

//! if canvas is texels and texels is ellipsoids
// Returns the plane of an ellipsoid's outline. It is the plane of the mapped sphere's outline, transformed back.
fn ball_plane(primitive: Primitive) -> vec3f {
    let center = to_sphere(primitive, primitive.a - eye_point());
    let distance = length(center);
    let radius = primitive.reach;
    if distance <= radius { return vec3f(0.0); }
    let across = primitive.b * center.x + primitive.c * center.y + primitive.d * center.z;
    return across / ((distance - radius) * (distance + radius));
}

//! if canvas is texels and primitives is triangles
fn plane_in_tree(slot: u32) -> vec3f { return triangle_plane(primitive_at(slot)); }

fn touches_before(primitive: Primitive, plane: vec3f, texel: vec2f) -> bool {
    return triangle_touches_before(primitive, plane, texel);
}

//! if canvas is texels and primitives is spheres
fn plane_in_tree(slot: u32) -> vec3f { return ball_plane(primitive_at(slot)); }

fn touches_before(primitive: Primitive, plane: vec3f, texel: vec2f) -> bool {
    return ball_touches(primitive, texel);
}

//! if canvas is texels and primitives is mixed
fn plane_in_tree(slot: u32) -> vec3f {
    let primitive = primitive_at(slot);
    if is_sphere(primitive) { return ball_plane(primitive); }
    return triangle_plane(primitive);
}

fn touches_before(primitive: Primitive, plane: vec3f, texel: vec2f) -> bool {
    if is_sphere(primitive) { return ball_touches(primitive, texel); }
    return triangle_touches_before(primitive, plane, texel);
}

//! if canvas is texels and primitives is none
fn plane_in_tree(slot: u32) -> vec3f { return vec3f(0.0); }

//! if canvas is texels and planes is none
fn shown_plane(slot: u32) -> vec3f { return plane_in_tree(slot); }

fn plane_stands_before(shown: u32, plane: vec3f, texel: vec2f) -> bool { return false; }

//! if canvas is texels and planes is some
fn shown_plane(slot: u32) -> vec3f {
    if slot >= PLANES { return plane_in_tree(slot); }
    let height = plane_above(slot, eye_point());
    return select(bitcast<vec3f>(primitive_texel(slot, 1u).xyz) / height, vec3f(0.0), height == 0.0);
}

// Returns whether an infinite plane, other than the one that a texel shows, lies in front of the texel's surface.
fn plane_stands_before(shown: u32, plane: vec3f, texel: vec2f) -> bool {
    var before = false;
    var slot = 0u;
    loop {
        if slot != shown { before |= is_before(shown_plane(slot), plane, texel); }
        slot += 1u;
        if slot >= PLANES { break; }
    }
    cut_short |= slot < PLANES;
    return before;
}
