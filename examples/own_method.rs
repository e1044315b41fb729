//! Adds a method to the comparison without a fork: depth-image-based rendering, which needs no ray for the second eye.
//! Left pixels move by their disparities, the nearest one wins, and gaps are filled from the background beside them
//! (Fehn 2004). Prints its errors beside those of the library's methods, and writes the map of its pixels.
//!
//! ```sh
//! cargo run --release --example own_method -- hall 640x480 out
//! ```

use std::{error::Error, path::Path};

use stereotrace::{
    Builtin, Gpu, Method, Options, PixelSource, Renderer, StereoPair,
    blocking::Wait,
    metrics,
    output::{Anaglyph, Picture},
};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let builtin: Builtin = arguments.next().unwrap_or("hall".into()).parse()?;
    let size = arguments.next().unwrap_or("640x480".into());
    let (width, height) = size.split_once('x').ok_or(format!("'{size}' is no size; use WIDTHxHEIGHT"))?;
    let camera = builtin.camera(width.parse()?, height.parse()?);
    let folder = arguments.next().unwrap_or("out".into());
    std::fs::create_dir_all(&folder)?;
    let file = |name: &str| Path::new(&folder).join(name);

    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let uploaded = renderer.upload(&builtin.scene()).wait()?;
    let mut pair = |method| renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait();
    let exact = pair(Method::Naive)?;
    let mut rows = vec![("own".to_owned(), warped(&exact))];
    for method in [Method::Atomic(stereotrace::Check::None), Method::ATOMIC, Method::BRACKET] {
        rows.push((method.to_string(), pair(method)?));
    }
    println!("{:18} {:>9} {:>15} {:>14}", "method", "PSNR (dB)", "wrong surface", "traced again");
    for (name, pair) in &rows {
        let error = metrics::compare(&pair.right, &exact.right, &pair.pose)?;
        let traced = pair.source.iter().filter(|source| **source != PixelSource::Reused).count();
        let filled = pair.source.iter().filter(|source| **source == PixelSource::Filled).count();
        let share = 100.0 * (traced - filled) as f64 / pair.source.len() as f64;
        println!("{name:18} {:9.2} {:14.3}% {share:13.2}%", error.psnr, error.wrong_surface_percent);
    }
    let own = &rows[0].1;
    own.anaglyph(Anaglyph::Dubois).save_png(file("own_anaglyph.png"))?;
    let [width, height] = own.pose.size;
    Picture::new(width, height, own.retrace_map()).save_png(file("own_sources.png"))?;
    Ok(())
}

/// Returns a pair with this pair's left view, and a right view made of it without rays.
fn warped(pair: &StereoPair) -> StereoPair {
    let mut own = pair.clone();
    let width = pair.left.width as usize;
    let disparities = pair.disparity();
    for (row, disparities) in disparities.chunks(width).enumerate() {
        let first = row * width;
        let found = nearest_by_column(disparities, &pair.left.depth[first..][..width]);
        let filled = filled(&found, &pair.left.depth[first..][..width]);
        for (x, (found, from)) in found.iter().zip(filled).enumerate() {
            let (to, from) = (first + x, first + from);
            own.right.rgba8[to] = pair.left.rgba8[from];
            own.right.depth[to] = pair.left.depth[from];
            own.right.primitive[to] = pair.left.primitive[from];
            own.right.object[to] = pair.left.object[from];
            own.source[to] = if found.is_some() { PixelSource::Reused } else { PixelSource::Filled };
        }
    }
    own
}

/// Returns the left column that each right column of a row shows: the nearest of those that land there.
fn nearest_by_column(disparities: &[f32], depths: &[f32]) -> Vec<Option<usize>> {
    let mut found = vec![None; depths.len()];
    for (from, disparity) in disparities.iter().enumerate() {
        // Columns before the first one become numbers near usize::MAX, which no row has.
        let column = (from as f32 - disparity).round() as isize as usize;
        if let Some(found) = found.get_mut(column)
            && found.is_none_or(|other: usize| depths[from] < depths[other])
        {
            *found = Some(from);
        }
    }
    found
}

/// Returns the left column for each right column. In gaps it is that of the farther of the pixels at both ends.
fn filled(found: &[Option<usize>], depths: &[f32]) -> Vec<usize> {
    let at = |x: usize| {
        let ends = [found[..x].iter().rev().flatten().next(), found[x..].iter().flatten().next()];
        let farther = |a: &usize, b: &usize| depths[*a].total_cmp(&depths[*b]);
        found[x].or_else(|| ends.into_iter().flatten().copied().max_by(farther)).unwrap_or(x)
    };
    (0..found.len()).map(at).collect()
}
