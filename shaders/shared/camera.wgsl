// The camera model: rays of pixels, landing positions of source samples in the target, and the width of a pixel.
// projection.wgsl has the frusta of tiles. No other kernel code reads the eyes' parameters.

//! use angles, frame, jitter, lane, lens, rays

//! if camera is planar and canvas is picture
// Returns the point where the target's rays start.
fn eye_point() -> vec3f { return frame.eyes.target_eye; }

// Returns the target's rays to the points at the given depths in source pixels. t of a point is 1. For sky pixels the
// direction is that of the source ray.
fn rays_to_source_points(pixels: Pixels, depth: F, sky: B) -> Rays {
    let direction = pixel_directions(frame.eyes.source_corner, pixels);
    let to_point = minus3(times3(direction, depth), all3(frame.eyes.right_axis * frame.eyes.shift));
    return Rays(frame.eyes.target_eye, select3(to_point, direction, sky));
}

// Returns the side of a square with a pixel's area at a ray's hit, at a distance along the view axis.
fn footprint(distance: f32, direction: vec3f) -> f32 {
    return distance * length(frame.eyes.step_x) * frame.eyes.pixel_side;
}

// Returns the width of so many pixels at distance 1 along the view axis.
fn width_of(columns: f32) -> f32 { return columns * length(frame.eyes.step_x); }

// Returns the target's rays through pixels.
fn rays_of(pixels: Pixels) -> Rays {
    return Rays(frame.eyes.target_eye, pixel_directions(frame.eyes.target_corner, pixels));
}

// Returns directions from an eye through the pixels' samples.
fn pixel_directions(corner: vec3f, pixels: Pixels) -> F3 {
    let row = pixels.y + frame.band.first_row;
    let x = sample_column(pixels.x, row);
    let y = F(row) + 0.5;
    return F3(
        corner.x + frame.eyes.step_x.x * x + frame.eyes.step_y.x * y,
        corner.y + frame.eyes.step_x.y * x + frame.eyes.step_y.y * y,
        corner.z + frame.eyes.step_x.z * x + frame.eyes.step_y.z * y,
    );
}

//! if camera is lens and canvas is picture
// Returns the side of a square with a pixel's area at a ray's hit, at a distance along the view axis. The direction's
// length gives its angle from the axis, also after reflections. The tangential part is left out.
fn footprint(distance: f32, direction: vec3f) -> f32 {
    let growth = growth_at(sqrt(max(dot(direction, direction) - 1.0, 0.0)));
    return distance * inverseSqrt(frame.eyes.focal_x * frame.eyes.focal_y * max(growth, LEAST_GROWTH));
}

// Returns the rays through pixels.
fn rays_of(pixels: Pixels) -> Rays {
    let row = pixels.y + frame.band.first_row;
    let place = undistorted(sample_column(pixels.x, row), F(row) + 0.5);
    let corner = frame.eyes.target_corner;
    return Rays(frame.eyes.target_eye, F3(
        corner.x + frame.eyes.step_x.x * place.x + frame.eyes.step_y.x * place.y,
        corner.y + frame.eyes.step_x.y * place.x + frame.eyes.step_y.y * place.y,
        corner.z + frame.eyes.step_x.z * place.x + frame.eyes.step_y.z * place.y,
    ));
}

//! if camera is around and canvas is picture
// Returns the centre of the viewing circle.
fn eye_point() -> vec3f { return frame.eyes.centre; }

// Returns the side of a square with a pixel's area at a ray's hit. Directions are longer at higher elevations, where
// pixels are narrower and hits farther off.
fn footprint(distance: f32, direction: vec3f) -> f32 {
    return distance * sqrt(frame.eyes.column_step * frame.eyes.row_step) * length(direction);
}

// Returns the width of a pixel at distance 1, and more for the curvature of a row's circle over so many pixels: on a
// vertical wall, the reciprocals of three distances deviate from a line by the square of their angle.
fn width_of(columns: f32) -> f32 {
    let angle = columns * frame.eyes.column_step;
    return angle + 32.0 * angle * angle;
}

// Returns the target's ray through a pixel, for lanes of one ray.
fn rays_of(pixels: Pixels) -> Rays {
    let row = pixels.y + frame.band.first_row;
    return ray_at(of_ray(sample_column(pixels.x, row), 0u), of_ray_u(row, 0u));
}

// Returns the target's ray to the point at the given depth in a source pixel. t of the point is 1. For sky pixels the
// direction is that of the source ray.
fn rays_to_source_points(pixels: Pixels, depth: F, sky: B) -> Rays {
    let row = pixels.y + frame.band.first_row;
    let distance = of_ray(depth, 0u);
    let moved = select(parallax(of_ray_u(pixels.y, 0u), distance), 0.0, of_ray_b(sky, 0u));
    let rays = ray_at(of_ray(sample_column(pixels.x, row), 0u) + moved, of_ray_u(row, 0u));
    return Rays(rays.origin, select3(times3(rays.direction, depth), rays.direction, sky));
}

// Returns the target's ray through a column in a row of samples of the picture.
fn ray_at(column: f32, row: u32) -> Rays {
    let elevation = elevation_of(row);
    let turn = unit_at((column - frame.eyes.middle.x) * frame.eyes.column_step);
    let rise = unit_at(elevation);
    let to_side = frame.eyes.right_axis * turn.x - frame.eyes.forward * turn.y;
    let ahead = frame.eyes.right_axis * turn.y + frame.eyes.forward * turn.x;
    return Rays(
        frame.eyes.centre + to_side * (frame.eyes.target_radius * merged(elevation)),
        all3(ahead + frame.eyes.up_axis * (rise.y / rise.x)),
    );
}

// Returns the cosine and the sine of an angle in radians.
fn unit_at(angle: f32) -> vec2f {
    return vec2f(of_ray(cosine(F(angle)), 0u), of_ray(sine(F(angle)), 0u));
}

fn arc_tangent(slope: f32) -> f32 { return of_ray(arctangent(F(slope), F(1.0)), 0u); }

// Returns the elevation of a row of samples in radians.
fn elevation_of(row: u32) -> f32 {
    let most = frame.eyes.most_elevation;
    return clamp((frame.eyes.middle.y - (f32(row) + 0.5)) * frame.eyes.row_step, -most, most);
}

// Returns the share of the circle's radius at an elevation.
fn merged(elevation: f32) -> f32 {
    let place = (abs(elevation) - frame.eyes.merge.x) / (frame.eyes.merge.y - frame.eyes.merge.x);
    if place <= 0.0 { return 1.0; }
    if place >= 1.0 { return 0.0; }
    return unit_at(QUARTER_TURN * place).x;
}

// Returns the target's radius in a row of the band.
fn radius_in(row: u32) -> f32 { return frame.eyes.target_radius * merged(elevation_of(row + frame.band.first_row)); }

// Returns the parallax x_t - x_s of a point in a row of the band at the horizontal distance z, in pixels. The source is
// the left eye, and the target the right one, so it is negative, and 0 at infinity.
fn parallax(row: u32, z: f32) -> f32 { return -2.0 * arc_tangent(radius_in(row) / z) / frame.eyes.column_step; }

// Returns the angle between the views of a point from source and target in radians, or a little more.
fn view_turn(depth: f32) -> f32 { return 2.0 * abs(frame.eyes.target_radius) / depth; }

// Returns the target column where a sample lands, or -1 outside the picture.
fn target_column(pixel: vec2u, z: f32) -> i32 {
    let column = landing(pixel, z);
    if column >= 0 { return column; }
    return select(-1, column + i32(frame.eyes.turn), frame.eyes.wraps == 1u);
}

// Returns floor(X), also outside the picture. X is at least minus half a turn.
fn landing(pixel: vec2u, z: f32) -> i32 { return i32(floor(landing_x(pixel, z))); }

// Near points move to the left, so sweeps go from left to right.

fn is_mirrored() -> bool { return false; }
fn in_sweep(place: u32) -> u32 { return place; }

// Returns a sample's key for the target column where it lands. Keys are never EMPTY. They grow with the distance
// between the columns, which is larger for nearer samples. Across the seam, columns themselves have no order.
fn key_of(column: u32, target_place: u32) -> u32 {
    return (column + frame.eyes.turn - target_place) % frame.eyes.turn + 1u;
}
fn column_of(key: u32, target_place: u32) -> u32 { return (target_place + key - 1u) % frame.eyes.turn; }

// A full turn has no second source.
struct Asked {
    second: bool,
}

fn nearest_source() -> Asked { return Asked(false); }

fn second_source() -> Asked { return Asked(true); }

fn parallax_from(source: Asked, row: u32, z: f32) -> f32 { return parallax(row, z); }

fn same_parallax_at(source: Asked, row: u32, z: f32) -> f32 {
    return min(MOST_PARALLAX, STEEPEST * 2.0 * radius_in(row) / z);
}

fn is_left_of_source(source: Asked) -> bool { return false; }

// Returns a source column between 0 and the number of columns of a full turn. Other pictures' columns stay.
fn in_turn(column: f32) -> f32 {
    let turn = f32(frame.eyes.turn);
    return select(column, select(column, column - turn, column >= turn), frame.eyes.wraps == 1u);
}

// Returns the column to the right of a source column.
fn next_column(column: u32) -> u32 {
    return select(column + 1u, 0u, frame.eyes.wraps == 1u && column + 1u == frame.band.size.x);
}

// Returns the number of columns that lie before the first one and continue the picture there.
fn columns_before() -> u32 { return select(0u, frame.eyes.turn, frame.eyes.wraps == 1u); }

//! if canvas is middles or texels
fn eye_point() -> vec3f { return frame.mapping.light; }

//! if jitter is none and canvas is picture
// Returns the columns of the pixels' samples, their centres.
fn sample_column(columns: U, rows: U) -> F { return F(columns) + 0.5; }

//! if jitter is rows and canvas is picture
// Returns the columns of the pixels' samples, which are moved along their rows.
fn sample_column(columns: U, rows: U) -> F { return F(columns) + 0.5 + sample_aside(rows); }

//! if camera is planar and canvas is picture
// Returns the parallax x_t - x_s of a point at depth z, in pixels. It is e_px (1 - d/z), thesis eq. 10; for parallel
// cameras f_px (0 - e/z). FAR gives the parallax at infinity.
fn parallax(row: u32, z: f32) -> f32 {
    return frame.eyes.parallax_px * (frame.eyes.at_infinity - frame.eyes.parallax_distance / z);
}

// Returns the angle between the views of a point from source and target in radians, or a little more.
fn view_turn(depth: f32) -> f32 { return abs(frame.eyes.shift) / depth; }

// Returns the target column floor(X) of a sample, or -1 outside the picture. X is compared before conversion, since X
// does not fit an integer near z = 0.
fn target_column(pixel: vec2u, z: f32) -> i32 {
    let x = landing_x(pixel, z);
    if !(x >= 0.0 && x < f32(frame.band.size.x)) { return -1; }
    return i32(floor(x));
}

// Returns floor(X), also outside the picture, clamped to the range of an integer.
fn landing(pixel: vec2u, z: f32) -> i32 {
    return i32(floor(clamp(landing_x(pixel, z), -1e9, 1e9)));
}

// A sweep orders a source's columns so that, among the samples that land in one target column, the nearest one comes
// last. For a target on the right, near points move to the left, so the rightmost of these samples is the nearest. For
// a target on the left, the order is mirrored.

fn is_mirrored() -> bool { return frame.eyes.parallax_px < 0.0; }

// Returns the column at position `place` of the sweep. The function is its own inverse.
fn in_sweep(place: u32) -> u32 { return select(place, frame.band.size.x - 1u - place, is_mirrored()); }

// Returns a sample's key. Keys grow along the sweep and are never EMPTY.
fn key_of(column: u32, target_place: u32) -> u32 { return in_sweep(column) + 1u; }
fn column_of(key: u32, target_place: u32) -> u32 { return in_sweep(key - 1u); }

// The parameters of a source view that a target view queries.
struct Asked {
    parallax_px: f32,     // like frame.eyes.parallax_px
    same_parallax: f32,
    second: bool,
}

fn nearest_source() -> Asked { return Asked(frame.eyes.parallax_px, frame.eyes.same_parallax, false); }

fn second_source() -> Asked { return Asked(frame.eyes.second_parallax_px, frame.eyes.second_same_parallax, true); }

fn parallax_from(source: Asked, row: u32, z: f32) -> f32 {
    return source.parallax_px * (frame.eyes.at_infinity - frame.eyes.parallax_distance / z);
}

// Returns the largest difference of parallaxes between a sample and a point of its surface at depth z, in pixels.
fn same_parallax_at(source: Asked, row: u32, z: f32) -> f32 { return source.same_parallax; }

fn is_left_of_source(source: Asked) -> bool { return source.parallax_px < 0.0; }

fn in_turn(column: f32) -> f32 { return column; }

fn next_column(column: u32) -> u32 { return column + 1u; }

fn columns_before() -> u32 { return 0u; }

//! if canvas is picture
// Returns X, the landing position of a sample: the sample's centre plus its parallax, in pixels.
fn landing_x(pixel: vec2u, z: f32) -> f32 {
    return f32(pixel.x) + 0.5 + parallax(pixel.y, z);
}
