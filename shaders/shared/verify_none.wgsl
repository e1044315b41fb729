// Every reprojected pixel is trusted.
fn are_bad(left_pixels: Pixels, left_depth: F, wanted: B) -> B {
    return wanted & !wanted;
}
