// Every reused pixel is checked by a ray of limited length (thesis, 3.1.3).

// Share of the way to the reused point that must be free.
const VERIFY_FRACTION: f32 = 0.999;

// Something stands between the right eye and the points that left pixels saw. The rays are aimed at the points themselves,
// so that a slanted surface is no false alarm; a sky pixel's has the left ray's direction and no limit.
fn are_bad(left_pixels: Pixels, left_depth: F, wanted: B) -> B {
    let direction = pixel_directions(frame.left_corner, left_pixels);
    let sky = left_depth >= F(FAR);
    let to_point = minus3(times3(direction, left_depth), all3(frame.right_axis * frame.interaxial));
    let aim = select3(to_point, direction, sky);
    let t_max = select(F(VERIFY_FRACTION), F(FAR), sky);
    return any_hit(Rays(frame.right_eye, aim), F(0.0), select(F(NEVER), t_max, wanted));
}
