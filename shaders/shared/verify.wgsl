// Verification of reused pixels.

//! use bvh, camera, lane, pixels, planes, rays

//! if checks is all
// Every reused pixel is checked by a ray of limited length (thesis, 3.1.3).

// Share of the way to the reused point that must be free of occluders.
const VERIFY_FRACTION: f32 = 0.999;

// Returns which points of source pixels are hidden from the target. Rays are aimed at the points themselves, so that a
// slanted surface raises no false alarm. A sky pixel's ray has the source ray's direction and no limit.
fn are_bad(source_pixels: Pixels, source_depth: F, wanted: B) -> B {
    let sky = source_depth >= F(FAR);
    let to_point = rays_to_source_points(source_pixels, source_depth, sky);
    let t_max = select(F(VERIFY_FRACTION), F(FAR), sky);
    return any_hit(to_point, F(0.0), select(F(NEVER), t_max, wanted));
}

//! if checks is none
// Every reprojected pixel is trusted.
fn are_bad(source_pixels: Pixels, source_depth: F, wanted: B) -> B {
    return wanted & !wanted;
}
