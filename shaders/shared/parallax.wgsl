// Where a sample of the source lands in the target's view (DESIGN, section 2).

// x_t - x_s in pixels of a point at depth z: e_px (1 - d/z), thesis eq. 10. FAR gives e_px.
fn parallax(z: f32) -> f32 {
    return frame.parallax_px * (1.0 - frame.screen_distance / z);
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
