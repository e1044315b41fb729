// A light's shadow-buffer as what primitives are drawn on (docs/SHADOW-BUFFER.md): its texels are a picture's pixels of
// which each row has the angle theta from a pole, and each column the azimuth phi. Edges of triangles are curves there,
// but planes through the light in space, where all tests are made: so triangles across the seam or around a pole are
// like all others.

//! if canvas is middles or texels
// A table is drawn on as it is.
alias Canvas = u32;

fn canvas_at_work() -> Canvas { return 0u; }

fn counted_row() -> u32 { return 0u; }

// The texels of a thread of a launch over blocks.
fn block_texels(id: vec3u) -> Pixels {
    let first = pixel_in_tile(id.xy) * BLOCK;
    return Pixels(RAY_X + U(first.x), RAY_Y + U(first.y));
}

fn inside_table(texels: Pixels) -> B {
    return (texels.x < U(frame.columns)) & (texels.y < U(frame.image_size.y));
}

// What is nearest in a texel.
struct Shown {
    t: f32,
    slot: u32,
}

// Of its two words in the T-buffer and of the nearest of all planes. Of equal t what stands in the tree wins, whose ids
// are smaller than planes'.
fn shown_at(drawn: vec2u, nearest: Hits, ray: u32) -> Shown {
    let t = bitcast<f32>(~drawn.x);
    if drawn.x != 0u && t <= of_ray(nearest.t, ray) { return Shown(t, select(drawn.y - 1u, UNFILLED, drawn.y == 0u)); }
    return Shown(of_ray(nearest.t, ray), select(of_ray_u(nearest.slot, ray), MISS, of_ray_u(nearest.primitive, ray) == MISS));
}

fn count_test(place: vec2u) {
    atomicAdd(&counters[PRIMITIVES_TESTED], 1u);
}

// Angles and places in the table round by less, in texels.
fn slack_of_places() -> f32 { return 0.02 + 4e-6 / frame.theta_step; }

// A cone of directions from the light in which a primitive lies.
struct Cap {
    axis: vec3f,      // unit
    radius: f32,      // radians; ALL_AROUND: it may lie anywhere
    sine: f32,        // of that
}

const ALL_AROUND: f32 = 4.0;
// More than caps round by, radians.
const CAP_SLACK: f32 = 4e-6;

fn cap_around(axis: vec3f, sine: f32, cosine: f32, is_narrow: bool) -> Cap {
    let radius = angle_of(sine, cosine) + CAP_SLACK;
    return Cap(select(frame.axis_z, axis, is_narrow), select(ALL_AROUND, radius, is_narrow), select(1.0, sine + CAP_SLACK, is_narrow));
}

// Wider than this the corners' middle says little.
const WIDEST_CHORD: f32 = 1.2;

// Around the sum of the corners' directions. A cone less wide than half a sphere that has the corners has the triangle.
fn triangle_cap(primitive: Primitive) -> Cap {
    let a = normalize(primitive.a - frame.target_eye);
    let b = normalize(primitive.b - frame.target_eye);
    let c = normalize(primitive.c - frame.target_eye);
    let axis = normalize(a + b + c);
    // By chords: a small angle's cosine says nothing.
    let chord = max(length(a - axis), max(length(b - axis), length(c - axis)));
    let is_narrow = chord < WIDEST_CHORD;
    let half = 0.5 * select(0.0, chord, is_narrow);
    let rest = 1.0 - half * half;
    return cap_around(axis, 2.0 * half * sqrt(rest), rest - half * half, is_narrow);
}

// Of an ellipsoid the sphere's around it.
fn ball_cap(primitive: Primitive) -> Cap {
    let center = primitive.a - frame.target_eye;
    let distance = length(center);
    let is_narrow = ball_radius(primitive) < 0.99 * distance;
    let sine = select(0.0, ball_radius(primitive) / distance, is_narrow);
    return cap_around(center / distance, sine, sqrt((1.0 - sine) * (1.0 + sine)), is_narrow);
}

fn angle_of(sine: f32, cosine: f32) -> f32 { return of_ray(arctangent(F(sine), F(cosine)), 0u); }

// Angles that something lies between, radians; of phi from the table's begin.
struct Angles {
    theta: vec2f,
    phi: vec2f,
    all_around: bool,    // it may have any phi
}

fn angles_of(cap: Cap) -> Angles {
    let x = dot(cap.axis, frame.axis_x);
    let y = dot(cap.axis, frame.axis_y);
    let aside = sqrt(x * x + y * y);
    let theta = angle_of(aside, dot(cap.axis, frame.axis_z));
    // Around a pole it has all azimuths.
    let has_pole = cap.radius >= theta - CAP_SLACK || cap.radius >= 3.1415926 - theta - CAP_SLACK;
    let sine = min(cap.sine / max(aside, 1e-9), 1.0);
    // Near 1 the cosine rounds by more than the sine.
    let wide = angle_of(sine, sqrt((1.0 - sine) * (1.0 + sine))) + 2e-3 * sine * sine * sine + CAP_SLACK;
    let phi = angle_of(y, x) - frame.phi_begin;
    return Angles(vec2f(theta - cap.radius, theta + cap.radius), vec2f(phi - wide, phi + wide), has_pole);
}

// Of a triangle whose cone has no pole they are those of its corners, and the thetas where an edge, which is a great
// circle's, comes nearest to a pole: so needles have no more texels than they need.
fn triangle_angles(primitive: Primitive) -> Angles {
    let around = angles_of(triangle_cap(primitive));
    if around.all_around { return around; }
    let turn = mat3x3f(frame.axis_x, frame.axis_y, frame.axis_z);
    let a = normalize(primitive.a - frame.target_eye) * turn;
    let b = normalize(primitive.b - frame.target_eye) * turn;
    let c = normalize(primitive.c - frame.target_eye) * turn;
    let middle = 0.5 * (around.phi.x + around.phi.y);
    let phis = vec3f(phi_beside(a, middle), phi_beside(b, middle), phi_beside(c, middle));
    let low = max(around.phi.x, min(phis.x, min(phis.y, phis.z)) - CAP_SLACK);
    let high = min(around.phi.y, max(phis.x, max(phis.y, phis.z)) + CAP_SLACK);
    let edges = array<vec2f, 3>(thetas_of(a, b), thetas_of(b, c), thetas_of(c, a));
    let first = max(around.theta.x, min(edges[0].x, min(edges[1].x, edges[2].x)) - CAP_SLACK);
    let last = min(around.theta.y, max(edges[0].y, max(edges[1].y, edges[2].y)) + CAP_SLACK);
    return Angles(vec2f(first, last), vec2f(low, high), false);
}

// The phi of a direction along the axes, no more than half a turn from another one.
fn phi_beside(v: vec3f, middle: f32) -> f32 {
    let phi = angle_of(v.y, v.x) - frame.phi_begin;
    return phi - TURN * floor((phi - middle) / TURN + 0.5);
}

const TURN: f32 = 6.2831853;

// Least and largest theta of an edge between two unit vectors along the axes. Where it rises from both of its ends, or
// falls, it turns back in between, as far from the pole as its plane's normal is from the equator.
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

// First column and row, and the last ones, of the table, of the rows at work that what lies between angles may reach;
// none if a first is past its last. Columns may go on beyond the last one, behind which the first one is.
fn texels_over(angles: Angles, reaches: vec2f) -> vec4i {
    let rows = i32(frame.image_size.y);
    let begin = i32(frame.first_row);
    let columns = i32(frame.columns);
    let first_row = clamp(begin_of(angles.theta.x - frame.theta_begin, reaches), f32(begin), f32(begin + rows));
    let last_row = clamp(end_of(angles.theta.y - frame.theta_begin, reaches), f32(begin - 1), f32(begin + rows - 1));
    let is_whole = frame.theta_begin == 0.0;
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

// The first place of the table that an angle on may reach, and the last one that an angle up to another one may, a
// place being what lies so far on both sides of a texel's middle.
fn begin_of(angle: f32, reaches: vec2f) -> f32 { return ceil(angle / frame.theta_step - reaches.x); }
fn end_of(angle: f32, reaches: vec2f) -> f32 { return floor(angle / frame.theta_step - reaches.y); }

fn is_out_of_sight(primitive: Primitive, canvas: Canvas) -> bool { return false; }

// Where a lane's texels stand: behind the last column the first one is.
fn on_canvas(texels: Pixels) -> Pixels {
    let columns = U(frame.columns);
    return Pixels(select(texels.x, texels.x - columns, texels.x >= columns), texels.y);
}

// Rays from the light through texels' middles.
fn rays_from(texels: Pixels) -> Rays {
    return Rays(frame.target_eye, directions_at(F(texels.y + frame.first_row) + 0.5, F(texels.x) + 0.5));
}

// Directions of places in the table, in texels.
fn directions_at(rows: F, columns: F) -> F3 {
    let theta = rows * frame.theta_step + frame.theta_begin;
    let phi = columns * frame.phi_step + frame.phi_begin;
    let across = sine(theta);
    let x = across * cosine(phi);
    let y = across * sine(phi);
    let z = cosine(theta);
    return F3(
        x * frame.axis_x.x + y * frame.axis_y.x + z * frame.axis_z.x,
        x * frame.axis_x.y + y * frame.axis_y.y + z * frame.axis_z.y,
        x * frame.axis_x.z + y * frame.axis_y.z + z * frame.axis_z.z,
    );
}

// How far directions stand on the inner side of the planes through the light and a triangle's edges: the sine of the
// angle, above -reach for some winding where what lies so close to it may meet the triangle.
fn is_within_edges(primitive: Primitive, directions: F3, reach: f32) -> B {
    let a = primitive.a - frame.target_eye;
    let b = primitive.b - frame.target_eye;
    let c = primitive.c - frame.target_eye;
    let values = triangle_weights(directions, a, b, c);
    // Normals of long edges that pass the light closely are mostly rounding.
    let rounding = (length(a) + primitive.reach) * primitive.reach * DOUBT;
    let near = vec3f(length(edge_normal(b, c)), length(edge_normal(c, a)), length(edge_normal(a, b))) * reach + rounding;
    let one_way = (values.x >= F(-near.x)) & (values.y >= F(-near.y)) & (values.z >= F(-near.z));
    let other_way = (values.x <= F(near.x)) & (values.y <= F(near.y)) & (values.z <= F(near.z));
    return one_way | other_way;
}

// Of a block of 2x2 texels no direction is farther from its middle than so many rows.
const BLOCK_REACH: f32 = 1.5;

// The blocks of a tile of texels, a bit each, that may lie within a triangle's edges.
fn triangle_blocks(primitive: Primitive, tile: Tile) -> u32 {
    let reach = BLOCK_REACH * frame.theta_step + CAP_SLACK;
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
// Texels whose middles a primitive may cover.
fn drawn_over(primitive: Primitive, canvas: Canvas) -> vec4i {
    let slack = slack_of_places();
    return texels_over(angles_around(primitive), vec2f(0.5 + slack, 0.5 - slack));
}

//! if canvas is texels
// Texels that a primitive may touch anywhere.
fn drawn_over(primitive: Primitive, canvas: Canvas) -> vec4i {
    let slack = slack_of_places();
    return texels_over(angles_around(primitive), vec2f(1.0 + slack, -slack));
}

// Marks the texels of which something may stand before the surface that they show: t_buffer has what read_texels wrote.
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
            let at = vec2f(f32(texel.y + frame.first_row), f32(texel.x));
            if stands_before(primitive, vec3f(x, y, z), at) { atomicOr(&t_buffer[place + 3u], SOMETHING_BEFORE); }
        }
    }
    return Later(0u, 0u);
}

// Nothing is left to look at again.
fn draw_again(primitive: Primitive, slot: u32, texels: Pixels, later: Later) {}

// Of a texel no direction is farther from its middle than so many rows.
const TEXEL_REACH: f32 = 0.75;

// So much before a texel's surface is no matter, of the distance from the light.
fn allowed_before() -> f32 { return frame.margin * frame.theta_step + ON_PLANE; }

fn middle_of(texel: vec2f) -> F3 { return directions_at(F(texel.x + 0.5), F(texel.y + 0.5)); }

// Whether a primitive may be before a texel's surface, within the texel: the plane of which the points x from the light
// have plane . x = 1.
fn stands_before(primitive: Primitive, plane: vec3f, texel: vec2f) -> bool {
    // Of all of it, wherever it is, how much is before the plane: with the distances of a texel that looks at it
    // straight on, the least there are.
    let size = length(plane);
    if size > 0.0 && 1.0 + most_along(primitive, -plane) <= allowed_before() { return false; }
    return touches_before(primitive, plane, texel);
}

// Wider texels than this, of tables of a few rows, curve by more than their corners are moved out; radians.
const WIDEST_TEXEL: f32 = 0.65;

// Whether a plane is before another one somewhere in a texel. The reciprocal of the distance from the light to a plane
// is linear in direction, so that two planes' differ most in one of the texel's corners, which are moved out by more
// than its sides curve and directions round. (What is no number is before it.)
fn is_before(other: vec3f, plane: vec3f, texel: vec2f) -> bool {
    let difference = other - plane;
    let allowed = allowed_before() * length(plane);
    let out = 0.05 + CAP_SLACK / frame.theta_step;
    var before = frame.theta_step > WIDEST_TEXEL;
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
    let reach = TEXEL_REACH * frame.theta_step + CAP_SLACK;
    if !any_ray(is_within_edges(primitive, middle_of(texel), reach)) { return false; }
    // f32 is too coarse for a large triangle's plane.
    if CLOSE {
        let light = frame.target_eye;
        if is_close(primitive.a - light, primitive.b - light, primitive.c - light, primitive.reach) { return true; }
    }
    return is_before(triangle_plane(primitive), plane, texel);
}

fn ball_touches(primitive: Primitive, texel: vec2f) -> bool {
    let cap = ball_cap(primitive);
    let aside = length(of_ray3(middle_of(texel), 0u) - cap.axis);
    return aside <= cap.radius + TEXEL_REACH * frame.theta_step + CAP_SLACK;
}

// The plane of a triangle, seen from the light: of its points the products with this vector are 1. Of one through the
// light there is none: that light does not see it.
fn triangle_plane(primitive: Primitive) -> vec3f {
    let normal = normalize(largest_one(cross(largest_one(primitive.b - primitive.a), largest_one(primitive.c - primitive.a))));
    let height = dot(normal, primitive.a - frame.target_eye);
    return select(normal / height, vec3f(0.0), height == 0.0);
}

//! if canvas is texels and texels is corners or spheres
// The plane of the circle in which a ball's outline lies: what is behind it hides no point of the ball that faces the
// light. From within there is none.
fn ball_plane(primitive: Primitive) -> vec3f {
    let center = primitive.a - frame.target_eye;
    let distance = length(center);
    let radius = primitive.b.x;
    if distance <= radius { return vec3f(0.0); }
    return center / ((distance - radius) * (distance + radius));
}

//! if canvas is texels and texels is ellipsoids
// The same of an ellipsoid: of the sphere that its matrix takes it to, and back.
fn ball_plane(primitive: Primitive) -> vec3f {
    let center = to_sphere(primitive, primitive.a - frame.target_eye);
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
    let height = plane_above(slot, frame.target_eye);
    return select(bitcast<vec3f>(primitive_texel(slot, 1u).xyz) / height, vec3f(0.0), height == 0.0);
}

// Whether an infinite plane other than the one that a texel shows is before what it shows.
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
