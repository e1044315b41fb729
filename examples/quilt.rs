//! A quilt for a light-field display: many views of one scene, of which only a few are traced.
//!
//! ```sh
//! cargo run --release --example quilt -- out
//! ```

use std::{error::Error, fs, path::Path};

use stereotrace::{
    Builtin, Gpu, Renderer, Rig,
    blocking::Wait,
    output::{quilt, quilt_name},
};

/// Number of views across and down, and the size of each view in pixels.
const GRID: [u32; 2] = [6, 4];
const VIEW: [u32; 2] = [210, 280];
/// Parallax at infinity between neighbouring views, in pixels. It is small, since displays blur points far from their
/// screen.
const APART: f32 = 1.2;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or("out".into());
    fs::create_dir_all(&folder)?;
    let camera = Builtin::HallFinished.camera(VIEW[0], VIEW[1]).interaxial_pixels(APART);
    let rig = Rig::row(camera, (GRID[0] * GRID[1]) as usize);

    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let scene = renderer.upload(&Builtin::HallFinished.scene()).wait()?;
    let views = renderer.views(&scene, &rig).read().wait()?;

    // Displays read the grid from the file name.
    let path = Path::new(&folder).join(quilt_name("hall", &views, GRID[0], GRID[1]));
    quilt(&views, GRID[0], GRID[1])?.save_png(&path)?;
    let traced = views.views.iter().enumerate().filter(|(index, view)| view.made_from == *index).count();
    println!("{}: {} views, {traced} of them traced", path.display(), views.views.len());
    Ok(())
}
