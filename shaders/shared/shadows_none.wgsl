// A scene whose lights cast no shadows.

// As with shadows, so that what is lit is lit to the same bit.
const OFFSET_BY_LIGHT: f32 = 1.0 / 1048576.0;
const shadow_rays: u32 = 0u;

fn shadowed(ray: ShadowRay, wanted: B) -> B {
    return wanted & !wanted;
}
