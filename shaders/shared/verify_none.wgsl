// Every reprojected pixel is trusted.
fn is_bad(left_pixel: vec2u, left: PixelHit) -> bool {
    return false;
}
