// Where a left sample lands in the right view (DESIGN, section 2).

// x_r - x_l in pixels of a point at depth z: e_px (1 - d/z), thesis eq. 10. FAR gives e_px.
fn parallax(z: f32) -> f32 {
    return frame.interaxial_px * (1.0 - frame.screen_distance / z);
}

// X, where a left sample lands: its centre moved by the parallax.
fn landing_x(column: u32, z: f32) -> f32 {
    return f32(column) + 0.5 + parallax(z);
}

// The right column floor(X) of left sample `column`, or -1 outside the picture. X is compared before it is converted:
// near z = 0 it does not fit an integer.
fn right_column(column: u32, z: f32) -> i32 {
    let x = landing_x(column, z);
    if !(x >= 0.0 && x < f32(frame.image_size.x)) { return -1; }
    return i32(floor(x));
}

// The same without the picture's edges, bounded so that it fits.
fn landing(column: u32, z: f32) -> i32 {
    return i32(floor(clamp(landing_x(column, z), -1e9, 1e9)));
}
