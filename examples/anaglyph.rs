//! Renders a stereo pair of an OBJ file, or of the built-in hall, as an anaglyph for red and cyan glasses:
//!
//! ```sh
//! cargo run --release --example anaglyph -- anaglyph.png [model.obj]
//! ```
//!
//! The command `stereotrace` does the same and much more. This example shows the start of a program that uses the
//! library.

use std::error::Error;

use stereotrace::{Builtin, Scene, StereoCamera, glam::DVec3, output::Anaglyph, render_stereo};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().unwrap_or("anaglyph.png".into());
    let (scene, camera) = match arguments.next() {
        None => (Builtin::Hall.scene(), Builtin::Hall.camera(640, 360)),
        Some(file) => {
            let mut scene = Scene::from_obj(file)?;
            let bounds = scene.bounds().unwrap_or((DVec3::NEG_ONE, DVec3::ONE));
            let camera = StereoCamera::fitting(bounds, 640, 480);
            scene.place_lights(3, &camera)?;
            (scene, camera)
        }
    };

    let pair = render_stereo(&scene, &camera)?;
    pair.anaglyph(Anaglyph::Dubois).save_png(&out)?;
    let (retraced, method) = (100.0 * pair.statistics.retraced_share(), pair.statistics.method);
    println!("{out}: {retraced:.1}% of the right eye traced again, by {method}");
    Ok(())
}
