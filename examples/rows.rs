//! Renders a pair of any height and writes its rows as they are finished. Neither the device nor the host ever holds
//! more than a band of rows.
//!
//! ```sh
//! cargo run --release --example rows -- 16384x8192 out [METHOD]
//! ```
//!
//! It writes `left.png` and `right.png` of the built-in hall, and prints the process's peak memory.

use std::{error::Error, path::Path, time::Instant};

use stereotrace::{
    Builtin, Gpu, Method, Options, Renderer, Rig,
    blocking::Wait,
    output::{Batch, PngRows},
};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let size = arguments.next().unwrap_or("4096x2048".into());
    let (width, height) = size.split_once('x').ok_or(format!("'{size}' is no size; use WIDTHxHEIGHT"))?;
    let (width, height) = (width.parse()?, height.parse()?);
    let folder = arguments.next().unwrap_or("out".into());
    let method: Method = arguments.next().unwrap_or("bracket".into()).parse()?;
    std::fs::create_dir_all(&folder)?;

    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let scene = renderer.upload(&Builtin::Hall.scene()).wait()?;
    let rig = Rig::pair(Builtin::Hall.camera(width, height));
    let options = Options::new(method).g_buffer(stereotrace::GBuffer::None);
    println!("before the first row: {}", memory());
    let begin = Instant::now();
    let file = |name| PngRows::new(Path::new(&folder).join(name), width, height);
    let [mut left, mut right] = [file("left.png")?, file("right.png")?];
    let mut write = |rows: stereotrace::Rows| {
        left.write(&rows.views[0].view.rgba8)?;
        right.write(&rows.views[1].view.rgba8)
    };
    let views = renderer.views(&scene, &rig).options(&options).rows(&mut write).wait()?;
    let mut batch = Batch::new();
    batch.add_png_rows(left)?;
    batch.add_png_rows(right)?;
    batch.commit()?;
    let between = views.intermediate_bytes;
    println!("{size} by {method} on {}", renderer.gpu().adapter_name());
    println!("{:.1} s; {} MiB between the steps; {}", begin.elapsed().as_secs_f64(), between >> 20, memory());
    Ok(())
}

/// Returns the process's peak memory as Linux reports it; on other systems it is unknown.
fn memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = peak.and_then(|peak| peak.split_whitespace().next()?.parse::<u64>().ok());
    kibibytes.map_or("peak memory unknown".into(), |peak| format!("peak memory {} MiB", peak >> 10))
}
