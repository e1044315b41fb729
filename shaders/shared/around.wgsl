// Tiles of equirectangular pictures: bounds of all points that their rays see, and bounds of primitives' pixels
// (docs/BRACKET.md, "All around").

//! use angles, boxes, camera, frame, primitive, projection, tiles, triangle

//! if camera is around
// Largest half of a tile's range of azimuths whose bounds are tested. Wider tiles, in pictures of a few columns, may
// see everything.
const MOST_HALF_WIDTH: f32 = 1.2;
// Factor on lengths that exceeds their rounding.
const MORE: f32 = 1.00001;

// A point p relative to the circle's centre has the coordinates dot(p, aside), dot(p, up_axis) and dot(p, forward),
// relative to the tile's middle azimuth. The horizontal distance along a ray to p lies between dot(p, forward) - reach
// and (dot(p, forward) + reach) * stretch. A plane holds the points with dot(p, plane.xyz) + plane.w >= 0.
struct Projection {
    forward: vec3f,
    reach: f32,          // largest distance of a ray's origin along `forward`
    aside: vec3f,
    stretch: f32,        // reciprocal of the cosine of half of the tile's range of azimuths
    left_plane: vec4f,
    right_plane: vec4f,
    top_plane: vec4f,
    bottom_plane: vec4f,
    middle: f32,         // column of the middle azimuth
    least_radius: f32,   // of the circle, in the tile's rows
    most_radius: f32,
    is_narrow: bool,
}

// The middle ray of the tile at work, about which the volumes between rays and edges are linear.
struct MiddleRay {
    ahead: vec3f,        // level direction
    aside: vec3f,
    place: vec2f,        // column and row
    elevation: vec2f,    // cosine and sine
    radius: f32,
    spread: f32,         // of radii in the tile's rows
    half: f32,           // sum of the angles across and down to the farthest ray
}

var<private> middle_ray: MiddleRay;

fn projection_of(tile: Tile) -> Projection {
    let step = frame.eyes.column_step;
    let middle = f32(tile.corner.x) + 0.5 * f32(tile.size.x);
    let half_width = (0.5 * f32(tile.size.x) - 0.5 + frame.eyes.wider) * step;
    let turn = unit_at((middle - frame.eyes.middle.x) * step);
    let forward = frame.eyes.right_axis * turn.y + frame.eyes.forward * turn.x;
    let aside = frame.eyes.right_axis * turn.x - frame.eyes.forward * turn.y;
    // Elevations of the first and of the last row. The radius shrinks with their size.
    let band = guard_band().y * frame.eyes.row_step;
    let top = min(elevation_of(tile.corner.y) + band, QUARTER_TURN);
    let bottom = max(elevation_of(tile.corner.y + tile.size.y - 1u) - band, -QUARTER_TURN);
    let shares = vec2f(merged(top), merged(bottom));
    let radius = frame.eyes.target_radius;
    let least = radius * min(shares.x, shares.y) / MORE;
    let most_share = select(max(shares.x, shares.y), 1.0, top >= 0.0 && bottom <= 0.0);
    let most_radius = radius * most_share * MORE;
    let half = unit_at(half_width);
    let stretch = 1.0 / half.x;
    let reach = most_radius * half.y * MORE;
    // The left side is bounded by dot(p, n(a0)) >= r cos(2 half), and the right one by dot(p, n(a1)) <= r.
    let double = 2.0 * half.x * half.x - 1.0;
    let least_double = select(most_radius, least, double >= 0.0) * double;
    let place = vec2f(middle, f32(tile.corner.y) + 0.5 * f32(tile.size.y));
    middle_ray = MiddleRay(
        forward,
        aside,
        place,
        unit_at((frame.eyes.middle.y - place.y) * frame.eyes.row_step),
        0.5 * (least + most_radius),
        most_radius - least,
        half_width + (0.5 * f32(tile.size.y) - 0.5 + frame.eyes.wider) * frame.eyes.row_step,
    );
    let up = frame.eyes.up_axis;
    let high = unit_at(top);
    let low = unit_at(bottom);
    // Factor on the horizontal distance's bound, and its sign: the bound that makes a plane looser.
    let high_factor = high.y * select(1.0, stretch, top >= 0.0);
    let low_factor = low.y * select(stretch, 1.0, bottom >= 0.0);
    return Projection(
        forward,
        reach,
        aside,
        stretch,
        vec4f(aside * half.x + forward * half.y, -least_double + (MORE - 1.0) * most_radius),
        vec4f(forward * half.y - aside * half.x, most_radius),
        vec4f(forward * high_factor - up * max(high.x, 0.0), abs(high_factor) * reach),
        vec4f(up * max(low.x, 0.0) - forward * low_factor, abs(low_factor) * reach),
        middle,
        least,
        most_radius,
        half_width < MOST_HALF_WIDTH,
    );
}

// Returns whether rays of a tile may meet a box up to a limit of the horizontal distance.
fn meets_frustum(child: Child, projection: Projection, limit: f32) -> bool {
    let across = min(at_most(child, projection.left_plane), at_most(child, projection.right_plane));
    let down = min(at_most(child, projection.top_plane), at_most(child, projection.bottom_plane));
    let ahead = most(child, projection.forward) + projection.reach;
    let is_near = -most(child, -projection.forward) - projection.reach <= limit;
    return ((min(min(across, down), ahead) >= 0.0) & is_near) | !projection.is_narrow;
}

fn at_most(child: Child, plane: vec4f) -> f32 { return most(child, plane.xyz) + plane.w; }

// Returns the smallest and largest column and row at which rays of the tile may meet a triangle. Along an edge, the
// azimuth of the eye's ray is monotone, so the columns are bounded by the corners. The height over a bound of the
// horizontal distance is monotone too. The result is EVERYWHERE if the triangle reaches the circle, or a point beside
// the tile or behind it.
fn triangle_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    let a = bounds_of_point(primitive.a, projection);
    let b = bounds_of_point(primitive.b, projection);
    let c = bounds_of_point(primitive.c, projection);
    let near = min(a.ahead, min(b.ahead, c.ahead));
    let low = min(a.range.xy, min(b.range.xy, c.range.xy));
    let high = max(a.range.zw, max(b.range.zw, c.range.zw));
    let bounds = vec4f(low.x, row_of_slope(high.y), high.x, row_of_slope(low.y));
    return select(EVERYWHERE, bounds, near > projection.most_radius * MORE && projection.is_narrow);
}

// The columns and slopes at which a tile's rays may meet a point: least column and slope, largest column and slope.
struct PointBounds {
    ahead: f32,   // distance along the tile's middle direction
    range: vec4f,
}

fn bounds_of_point(place: vec3f, projection: Projection) -> PointBounds {
    let p = place - frame.eyes.centre;
    let ahead = dot(p, projection.forward);
    let aside = dot(p, projection.aside);
    let away = aside * aside + ahead * ahead;
    let azimuth = arc_tangent(aside / ahead);
    let least = tangent_angle(projection.most_radius, away);
    let largest = tangent_angle(projection.least_radius, away);
    let columns = projection.middle + (azimuth - vec2f(least, largest)) / frame.eyes.column_step;
    let slopes = slopes_of(dot(p, frame.eyes.up_axis), 0.0, ahead, projection);
    return PointBounds(ahead, vec4f(columns.x, slopes.x, columns.y, slopes.y));
}

// Returns the angle between the direction to a point and the ray that touches a circle, from the square of the point's
// distance.
fn tangent_angle(radius: f32, away: f32) -> f32 {
    return arc_tangent(radius * inverseSqrt(max(away - radius * radius, 1e-30)));
}

// Returns the least and the largest slope of a tile's rays to a ball at a height, and at a distance ahead.
fn slopes_of(height: f32, radius: f32, ahead: f32, projection: Projection) -> vec2f {
    let near = tangents(height, ahead - projection.reach, radius);
    let far = tangents(height, ahead + projection.reach, radius) / projection.stretch;
    return vec2f(select(far.x, near.x, near.x < 0.0), select(far.y, near.y, near.y > 0.0));
}

fn row_of_slope(slope: f32) -> f32 { return frame.eyes.middle.y - arc_tangent(slope) / frame.eyes.row_step; }

//! if camera is around and texels is corners or spheres
fn enclosing_radius(primitive: Primitive) -> f32 { return primitive.b.x; }

//! if camera is around and texels is ellipsoids
fn enclosing_radius(primitive: Primitive) -> f32 { return primitive.reach; }

//! if camera is around
// Returns the smallest and largest column and row at which rays of the tile may meet a ball. The result is EVERYWHERE
// if it reaches the circle, or a point beside the tile or behind it.
fn sphere_bounds(primitive: Primitive, projection: Projection) -> vec4f {
    let p = primitive.a - frame.eyes.centre;
    let radius = enclosing_radius(primitive);
    let ahead = dot(p, projection.forward);
    let aside = dot(p, projection.aside);
    let away = aside * aside + ahead * ahead;
    let farthest = sqrt(away) + radius;
    let nearest = (away - radius * radius) / farthest;
    let azimuth = arc_tangent(aside / ahead);
    let half = tangent_angle(radius, away);
    let least = azimuth - half - tangent_angle(projection.most_radius, nearest * nearest);
    let largest = azimuth + half - tangent_angle(projection.least_radius, farthest * farthest);
    let columns = projection.middle + vec2f(least, largest) / frame.eyes.column_step;
    let slopes = slopes_of(dot(p, frame.eyes.up_axis), radius, ahead, projection);
    let bounds = vec4f(columns.x, row_of_slope(slopes.y), columns.y, row_of_slope(slopes.x));
    let is_ahead = ahead - radius > max(projection.most_radius * MORE, (length(p) + radius) * NEAR_PLANE);
    return select(EVERYWHERE, bounds, is_ahead && projection.is_narrow);
}

//! if camera is around and canvas is picture
// The volume that a ray spans with an edge is W / cos p for the ray's elevation p, with N the edge's normal at the
// circle's centre and E the edge: W = (N f + R E u) cos p + (N u - R E f) sin p, where f is the ray's azimuth and u is
// up. The first and second derivatives of W by both angles are at most |N| + R |E|.
struct EdgeValues {
    first: f32,    // of W at the centre of the first block
    across: f32,   // change per column
    down: f32,     // change per row
    reach: f32,    // bounds the change of W from a block's centre to its rays, and all errors
}

// Returns the blocks of a tile, one bit each, in which some ray may pass a triangle's edges on one side.
fn triangle_blocks(primitive: Primitive, tile: Tile) -> u32 {
    let a = primitive.a - frame.eyes.centre;
    let b = primitive.b - frame.eyes.centre;
    let c = primitive.c - frame.eyes.centre;
    // Rays that intersect_triangle may find uncertain count as possible hits.
    let far = sqrt(dot(a, a)) + middle_ray.radius + middle_ray.spread + primitive.reach;
    let doubtful = far * primitive.reach * (2.0 * DOUBT);
    let first = vec2f(tile.corner) + 1.0 - middle_ray.place;
    let of_a = edge_values(b, c, first, doubtful);
    let of_b = edge_values(c, a, first, doubtful);
    let of_c = edge_values(a, b, first, doubtful);
    let values = vec3f(of_a.first, of_b.first, of_c.first);
    let across = vec3f(of_a.across, of_b.across, of_c.across);
    let down = vec3f(of_a.down, of_b.down, of_c.down);
    let reach = vec3f(of_a.reach, of_b.reach, of_c.reach);
    return blocks_of_rows(values, across, down, reach);
}

fn edge_values(p: vec3f, q: vec3f, first: vec2f, doubtful: f32) -> EdgeValues {
    let normal = edge_normal(p, q); // twice the cross product
    let edge = 2.0 * (q - p);
    let radius = middle_ray.radius;
    let elevation = middle_ray.elevation;
    let level = dot(normal, middle_ray.ahead) + radius * dot(edge, frame.eyes.up_axis);
    let upright = dot(normal, frame.eyes.up_axis) - radius * dot(edge, middle_ray.ahead);
    let level_turn = dot(normal, middle_ray.aside);
    let upright_turn = -radius * dot(edge, middle_ray.aside);
    let across = (level_turn * elevation.x + upright_turn * elevation.y) * frame.eyes.column_step;
    let down = (level * elevation.y - upright * elevation.x) * frame.eyes.row_step;
    let size = components(edge);
    let most = components(normal) + radius * size;
    let curved = 0.5 * MORE * middle_ray.half * middle_ray.half * most;
    let origin = middle_ray.spread + (components(frame.eyes.centre) + radius) * (1.0 / 4194304.0);
    let rounding = most * (1.0 / 262144.0) + size * origin + doubtful;
    let reach = (0.5 + frame.eyes.wider) * (abs(across) + abs(down)) + curved + rounding;
    let value = level * elevation.x + upright * elevation.y;
    return EdgeValues(value + across * first.x + down * first.y, across, down, reach);
}

//! if camera is around and planes is some
// Returns whether some ray of a tile may meet a plane.
fn meets_planes(tile: Tile) -> bool { return true; }
