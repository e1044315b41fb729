// Every reprojected pixel is trusted.
fn are_bad(source_pixels: Pixels, source_depth: F, wanted: B) -> B {
    return wanted & !wanted;
}
