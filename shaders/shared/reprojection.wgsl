// Where a source sample lands in the target view (DESIGN, section 2).

// Returns the parallax x_t - x_s of a point at depth z, in pixels: e_px (1 - d/z), thesis eq. 10; for parallel cameras
// f_px (0 - e/z). FAR gives the parallax of infinity.
fn parallax(z: f32) -> f32 {
    return frame.parallax_px * (frame.at_infinity - frame.parallax_distance / z);
}

// Returns X, where a sample lands: its centre moved by the parallax.
fn landing_x(column: u32, z: f32) -> f32 {
    return f32(column) + 0.5 + parallax(z);
}

// Returns the target column floor(X) of a sample, or -1 outside the picture. X is compared before conversion, since
// near z = 0 it does not fit an integer.
fn target_column(column: u32, z: f32) -> i32 {
    let x = landing_x(column, z);
    if !(x >= 0.0 && x < f32(frame.image_size.x)) { return -1; }
    return i32(floor(x));
}

// Returns floor(X) without the picture's edges, clamped to fit.
fn landing(column: u32, z: f32) -> i32 {
    return i32(floor(clamp(landing_x(column, z), -1e9, 1e9)));
}

// The order of a source's columns for its target begins on the farthest side. To an eye on the right, near things move
// to the left. So of the samples that land in one column the rightmost is the nearest. For an eye on the left all is
// mirrored.

fn is_mirrored() -> bool { return frame.parallax_px < 0.0; }

// Returns the column at position `place` of the sweep. The function is its own inverse.
fn in_sweep(place: u32) -> u32 { return select(place, frame.image_size.x - 1u - place, is_mirrored()); }

// Returns a sample's key: the later its column comes in the sweep, the larger. It is never EMPTY.
fn key_of(column: u32) -> u32 { return in_sweep(column) + 1u; }
fn column_of(key: u32) -> u32 { return in_sweep(key - 1u); }

// Marks of pixels of a view that is not traced. BAD: checked and rejected. MISSED: traced, since no sample landed. KEY:
// bits for the key of the reused source pixel.
const BAD: u32 = 0x40000000u;
const MISSED: u32 = 0x80000000u;
// `bracket` only: some light needed a shadow ray.
const ASKED: u32 = 0x20000000u;
const KEY: u32 = 0x1fffffffu;

// No sample landed here.
const EMPTY: u32 = 0u;
