// A scene whose lights cast no shadows.

// As with shadows, so that what is lit is lit to the same bit.
const OFFSET_BY_LIGHT: f32 = 1.0 / 1048576.0;
const shadow_rays: u32 = 0u;

fn occluders_of(ray: ShadowRay, wanted: B) -> U {
    return U(MISS);
}

fn is_occluded_by(slot: u32, ray: ShadowRay, index: u32) -> bool {
    return false;
}
