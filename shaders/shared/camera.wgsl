// The camera model: rays of pixels, landing positions of source samples in the target, and the width of a pixel.
// projection.wgsl has the frusta of tiles. No other kernel code reads the eyes' parameters.

//! use frame, jitter, lane, rays

//! if canvas is picture
// Returns the point where the target's rays start.
fn eye_point() -> vec3f { return frame.eyes.target_eye; }

// Returns the directions from the target eye to the points at the given depths in source pixels. For sky pixels the
// result is the direction of the source ray.
fn to_source_points(pixels: Pixels, depth: F, sky: B) -> F3 {
    let direction = pixel_directions(frame.eyes.source_corner, pixels);
    let to_point = minus3(times3(direction, depth), all3(frame.eyes.right_axis * frame.eyes.shift));
    return select3(to_point, direction, sky);
}

// Returns the side of a square with a pixel's area, at a distance along the view axis.
fn footprint(distance: f32) -> f32 { return distance * length(frame.eyes.step_x) * frame.eyes.pixel_side; }

// Returns the width of a pixel at distance 1 along the view axis.
fn column_step() -> f32 { return length(frame.eyes.step_x); }

//! if camera is planar and canvas is picture
// Returns the target's rays through pixels.
fn rays_of(pixels: Pixels) -> Rays {
    return Rays(frame.eyes.target_eye, pixel_directions(frame.eyes.target_corner, pixels));
}

//! if camera is around and canvas is picture
const HALF_TURN: f32 = 3.14159265;

// Returns the target's ray through a pixel, for lanes of one ray. The ray is tangent to a circle around target_eye. Its
// t is the distance along the ground (src/frame/eyes/around.rs).
fn rays_of(pixels: Pixels) -> Rays {
    let pixel = pixel_of_ray(pixels, 0u);
    let azimuth = (f32(pixel.x) + 0.5) * frame.eyes.step_x.x - HALF_TURN;
    let elevation = 0.5 * HALF_TURN - (f32(pixel.y + frame.band.first_row) + 0.5) * frame.eyes.step_y.y;
    let right = vec3f(cos(azimuth), 0.0, sin(azimuth));
    let ahead = vec3f(sin(azimuth), 0.0, -cos(azimuth));
    return Rays(frame.eyes.target_eye + right * frame.eyes.shift, all3(ahead + vec3f(0.0, tan(elevation), 0.0)));
}

//! if canvas is middles or texels
fn eye_point() -> vec3f { return frame.mapping.light; }

//! if jitter is none
// Returns directions from an eye through the pixels' centres.
fn pixel_directions(corner: vec3f, pixels: Pixels) -> F3 {
    let x = F(pixels.x) + 0.5;
    let y = F(pixels.y + frame.band.first_row) + 0.5;
    return F3(
        corner.x + frame.eyes.step_x.x * x + frame.eyes.step_y.x * y,
        corner.y + frame.eyes.step_x.y * x + frame.eyes.step_y.y * y,
        corner.z + frame.eyes.step_x.z * x + frame.eyes.step_y.z * y,
    );
}

//! if jitter is rows
// Returns directions from an eye through jittered samples.
fn pixel_directions(corner: vec3f, pixels: Pixels) -> F3 {
    let row = pixels.y + frame.band.first_row;
    let x = F(pixels.x) + 0.5 + sample_aside(row);
    let y = F(row) + 0.5;
    return F3(
        corner.x + frame.eyes.step_x.x * x + frame.eyes.step_y.x * y,
        corner.y + frame.eyes.step_x.y * x + frame.eyes.step_y.y * y,
        corner.z + frame.eyes.step_x.z * x + frame.eyes.step_y.z * y,
    );
}

//! end
// Returns the parallax x_t - x_s of a point at depth z, in pixels. It is e_px (1 - d/z), thesis eq. 10; for parallel
// cameras f_px (0 - e/z). FAR gives the parallax at infinity.
fn parallax(z: f32) -> f32 {
    return frame.eyes.parallax_px * (frame.eyes.at_infinity - frame.eyes.parallax_distance / z);
}

// Returns the angle between the views of a point from source and target in radians, or a little more.
fn view_turn(depth: f32) -> f32 { return abs(frame.eyes.shift) / depth; }

// Returns X, the landing position of a sample: the sample's centre plus its parallax, in pixels.
fn landing_x(column: u32, z: f32) -> f32 {
    return f32(column) + 0.5 + parallax(z);
}

// Returns the target column floor(X) of a sample, or -1 outside the picture. X is compared before conversion, since X
// does not fit an integer near z = 0.
fn target_column(column: u32, z: f32) -> i32 {
    let x = landing_x(column, z);
    if !(x >= 0.0 && x < f32(frame.band.size.x)) { return -1; }
    return i32(floor(x));
}

// Returns floor(X), also outside the picture, clamped to the range of an integer.
fn landing(column: u32, z: f32) -> i32 {
    return i32(floor(clamp(landing_x(column, z), -1e9, 1e9)));
}

// A sweep orders a source's columns so that, among the samples that land in one target column, the nearest one comes
// last. For a target on the right, near points move to the left, so the rightmost of these samples is the nearest. For
// a target on the left, the order is mirrored.

fn is_mirrored() -> bool { return frame.eyes.parallax_px < 0.0; }

// Returns the column at position `place` of the sweep. The function is its own inverse.
fn in_sweep(place: u32) -> u32 { return select(place, frame.band.size.x - 1u - place, is_mirrored()); }

// Returns a sample's key. Keys grow along the sweep and are never EMPTY.
fn key_of(column: u32) -> u32 { return in_sweep(column) + 1u; }
fn column_of(key: u32) -> u32 { return in_sweep(key - 1u); }

// The parameters of a source view that a target view queries.
struct Asked {
    parallax_px: f32,     // like frame.eyes.parallax_px
    same_parallax: f32,
    second: bool,
}

fn nearest_source() -> Asked { return Asked(frame.eyes.parallax_px, frame.eyes.same_parallax, false); }

fn second_source() -> Asked { return Asked(frame.eyes.second_parallax_px, frame.eyes.second_same_parallax, true); }

fn parallax_from(source: Asked, z: f32) -> f32 {
    return source.parallax_px * (frame.eyes.at_infinity - frame.eyes.parallax_distance / z);
}
