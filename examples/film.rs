//! Renders a film of a thousand spheres that turn about their axis, as numbered anaglyphs. The scene stays on the
//! device, and each frame uploads only its change.
//!
//! ```sh
//! cargo run --release --example film -- out 24
//! ffmpeg -framerate 24 -i out/film_%04d.png -pix_fmt yuv420p film.mp4
//! ```

use std::{error::Error, f32::consts::TAU, fs, path::Path, time::Instant};

use stereotrace::{
    Builtin, GBuffer, Gpu, Options, Renderer, Update,
    blocking::Wait,
    glam::{Affine3A, Quat},
    output::Anaglyph,
};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or("out".into());
    let frames: u32 = arguments.next().map_or(Ok(24), |text| text.parse())?;
    fs::create_dir_all(&folder)?;

    let (mut scene, camera) = (Builtin::Spheres.scene(), Builtin::Spheres.camera(320, 240));
    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let mut uploaded = renderer.upload(&scene).wait()?;
    let options = Options::default().g_buffer(GBuffer::None);
    let step = Affine3A::from_quat(Quat::from_rotation_y(TAU / frames as f32));
    let begin = Instant::now();
    for frame in 0..frames {
        let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait()?;
        pair.anaglyph(Anaglyph::HalfColour).save_png(Path::new(&folder).join(format!("film_{frame:04}.png")))?;
        for object in 0..scene.object_count() as u32 {
            scene.transform_object(object, &step)?;
        }
        // The refit keeps the tree's structure and updates its boxes. After large changes, Update::Rebuild gives faster
        // traces.
        renderer.update(&mut uploaded, &scene, Update::Refit).wait()?;
    }
    let each = 1e3 * begin.elapsed().as_secs_f64() / f64::from(frames);
    println!("{folder}: {frames} frames, {each:.0} ms each with update and file");
    Ok(())
}
