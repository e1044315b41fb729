//! Renders pictures of all samples at the corners of pixels and between them.

use stereotrace::{
    Error, GBuffer, Method, Options, Renderer, Scene, StereoCamera, StereoPair,
    blocking::Wait,
    metrics::{self, Difference},
};

/// Returns a camera with one pixel per sample, and `side` samples from one pixel corner to the next. The first sample
/// is at the picture's upper left corner.
pub(crate) fn camera(camera: StereoCamera, side: u32) -> Result<StereoCamera, Error> {
    let pose = camera.pose()?;
    let [width, height] = pose.size.map(|pixels| pixels * side);
    let screen_width = f64::from(pose.screen_size[0]) * (1.0 + 1.0 / f64::from(width));
    Ok(camera.size(width + 1, height + 1).screen_width(screen_width as f32).interaxial(pose.interaxial))
}

/// Traces all samples.
pub(crate) fn samples(renderer: &mut Renderer, scene: &Scene, camera: &StereoCamera) -> Result<StereoPair, Error> {
    let uploaded = renderer.upload(scene).wait()?;
    renderer.pair(&uploaded, camera).options(&Options::new(Method::Naive).g_buffer(GBuffer::Depth)).read().wait()
}

/// Compares the colours of pixels with the true ones.
pub(crate) fn compare(found: &[[u8; 4]], truth: &[[u8; 4]], like: &StereoPair) -> Result<Difference, Error> {
    let view = |rgba8: &[[u8; 4]]| {
        let mut view = like.right.clone();
        view.rgba8 = rgba8.to_vec();
        view
    };
    metrics::compare(&view(found), &view(truth), &like.pose)
}
