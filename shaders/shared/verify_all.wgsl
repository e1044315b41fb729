// Every reused pixel is checked by a ray of limited length (thesis, 3.1.3).

// Share of the way to the reused point that must be free.
const VERIFY_FRACTION: f32 = 0.999;

// Something stands between the right eye and the point that left pixel saw. The ray is aimed at the point itself, so
// that a slanted surface is no false alarm; a sky pixel's has the left ray's direction and no limit.
fn is_bad(left_pixel: vec2u, left: PixelHit) -> bool {
    let direction = pixel_direction(frame.left_corner, left_pixel);
    let sky = left.primitive == MISS;
    let to_point = direction * left.depth - frame.right_axis * frame.interaxial;
    let aim = select(to_point, direction, sky);
    return any_hit(Ray(frame.right_eye, aim), 0.0, select(VERIFY_FRACTION, FAR, sky));
}
