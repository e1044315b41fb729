// Where a sample of the source lands in the target's view (DESIGN, section 2).

// x_t - x_s in pixels of a point at depth z: e_px (1 - d/z), thesis eq. 10; between parallel cameras f_px (0 - e/z).
// FAR gives that of infinity.
fn parallax(z: f32) -> f32 {
    return frame.parallax_px * (frame.at_infinity - frame.parallax_distance / z);
}

// X, where a sample lands: its centre moved by the parallax.
fn landing_x(column: u32, z: f32) -> f32 {
    return f32(column) + 0.5 + parallax(z);
}

// The target's column floor(X) of sample `column`, or -1 outside the picture. X is compared before it is converted:
// near z = 0 it does not fit an integer.
fn target_column(column: u32, z: f32) -> i32 {
    let x = landing_x(column, z);
    if !(x >= 0.0 && x < f32(frame.image_size.x)) { return -1; }
    return i32(floor(x));
}

// The same without the picture's edges, bounded so that it fits.
fn landing(column: u32, z: f32) -> i32 {
    return i32(floor(clamp(landing_x(column, z), -1e9, 1e9)));
}

// The order of a source's columns for its target: the farthest side first. To an eye on the right near things move to
// the left, so among the samples that land on one column the rightmost is the nearest; to an eye on the left all is
// mirrored.

fn is_mirrored() -> bool { return frame.parallax_px < 0.0; }

// The column that comes so late in a sweep, and how late a column comes.
fn in_sweep(place: u32) -> u32 { return select(place, frame.image_size.x - 1u - place, is_mirrored()); }

// Of a sample: larger the later its column comes; never EMPTY.
fn key_of(column: u32) -> u32 { return in_sweep(column) + 1u; }
fn column_of(key: u32) -> u32 { return in_sweep(key - 1u); }

// Marks of the pixels of a view that is not traced: checked and rejected, traced for want of a source's sample; and
// what is left for the key of the source's pixel that is taken over.
const BAD: u32 = 0x40000000u;
const MISSED: u32 = 0x80000000u;
// By `bracket`: some light needed a shadow ray.
const ASKED: u32 = 0x20000000u;
const KEY: u32 = 0x1fffffffu;

// No sample landed here.
const EMPTY: u32 = 0u;
