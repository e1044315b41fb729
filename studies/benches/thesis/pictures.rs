//! Renders the report's pictures: views by each method, differences from naive, costs, and sources of right pixels.

use std::{error::Error, io::Cursor};

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use stereotrace::{
    Check, Method, Options, PixelSource, Renderer, ShadowSource, StereoPair, View,
    blocking::Wait,
    metrics,
    output::{Anaglyph, Picture as Pixels},
};

use crate::{
    common::scenes,
    report::{Picture, Sources},
};

/// Factor by which differences are amplified.
const GAIN: u32 = 8;

/// Renders the pictures of every scene, for naive and the methods whose pictures differ.
pub(crate) fn of(
    renderer: &mut Renderer,
    names: &[&str],
    side: u32,
    e_px: f32,
) -> Result<Vec<Picture>, Box<dyn Error>> {
    let edges = Method::Atomic(Check::Edges);
    let mut pictures = Vec::new();
    for name in names {
        let Some(bench) = scenes::load_thesis(name, [side; 2], e_px, None)? else { continue };
        let uploaded = renderer.upload(&bench.scene).wait()?;
        let mut render = |method| {
            renderer.pair(&uploaded, &bench.camera).options(&Options::new(method).cost_map(true)).read().wait()
        };
        let naive = render(Method::Naive)?;
        let white = white(&naive.left);
        let mut add = |method: &str, kind: &str, caption: String, picture: &Pixels| {
            let (scene, method, kind) = ((*name).to_owned(), method.to_owned(), kind.to_owned());
            png(picture).map(|png| pictures.push(Picture { scene, method, kind, caption, png }))
        };
        add("naive", "left", "the left eye, which all methods trace".into(), &naive.left.picture())?;
        add("naive", "right", "the right eye, traced: the truth".into(), &naive.right.picture())?;
        add("naive", "anaglyph", "for red and cyan glasses".into(), &naive.anaglyph(Anaglyph::Dubois))?;
        let time = format!("nodes and primitive tests of each pixel, black 0, white {white} and more");
        for (eye, view) in [("cost left", &naive.left), ("cost right", &naive.right)] {
            if let Some(picture) = view.cost_picture(white) {
                add("naive", eye, time.clone(), &picture)?;
            }
        }
        for method in [Method::ATOMIC, Method::ES_ISLER, edges] {
            let pair = render(method)?;
            let method = method.to_string();
            add(&method, "right", "the right eye".into(), &pair.right.picture())?;
            let caption = format!("right eye less naive's, {GAIN} times as large");
            add(&method, &format!("difference x{GAIN}"), caption, &difference(&pair, &naive))?;
            let caption = "green reused, red rejected and yellow missed, both traced".into();
            add(&method, "re-trace map", caption, &pair.retrace_picture())?;
            if let Some(picture) = pair.right.cost_picture(white) {
                add(&method, "cost right", time.clone(), &picture)?;
            }
        }
    }
    Ok(pictures)
}

/// Renders pictures that show the sources of `bracket`'s right pixels, on built-in scenes.
pub(crate) fn sources(
    renderer: &mut Renderer,
    names: &[&str],
    size: [u32; 2],
    e_px: f32,
) -> Result<Vec<Sources>, Box<dyn Error>> {
    let mut all = Vec::new();
    for name in names {
        let Some(bench) = scenes::load(name, size, e_px, None)? else { continue };
        let uploaded = renderer.upload(&bench.scene).wait()?;
        let mut render = |method| renderer.pair(&uploaded, &bench.camera).options(&Options::new(method)).read().wait();
        let (pair, naive) = (render(Method::BRACKET)?, render(Method::Naive)?);
        let picture = |kind: &str, caption: &str, picture: &Pixels| {
            let (scene, method) = ((*name).to_owned(), Method::BRACKET.to_string());
            png(picture).map(|png| Picture { scene, method, kind: kind.into(), caption: caption.into(), png })
        };
        let mut pictures = vec![picture("right", "the right eye", &pair.right.picture())?];
        pictures.push(picture("re-trace map", "where surfaces come from", &pair.retrace_picture())?);
        if let Some(map) = pair.shadow_picture() {
            pictures.push(picture("shadow map", "where shadows come from", &map)?);
        }
        let caption = format!("right eye less naive's, {GAIN} times as large");
        pictures.push(picture(&format!("difference x{GAIN}"), &caption, &difference(&pair, &naive))?);
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        let share = |wanted| 100.0 * pair.source.iter().filter(|source| **source == wanted).count() as f64 / pixels;
        let taken = pair.shadow_source.iter().filter(|source| **source == ShadowSource::Taken).count();
        all.push(Sources {
            scene: (*name).to_owned(),
            width: size[0],
            height: size[1],
            e_px,
            lights: bench.scene.lights.len(),
            found: share(PixelSource::Reused),
            deeper: share(PixelSource::Bad),
            unbound: share(PixelSource::Missed),
            shadows_taken: 100.0 * taken as f64 / pixels,
            differing: metrics::compare(&pair.right, &naive.right, &pair.pose)?.differing_percent,
            pictures,
        });
    }
    Ok(all)
}

/// Returns a cost that 99.9% of the pixels do not exceed.
fn white(view: &View) -> u32 {
    let mut costs = view.cost.clone();
    costs.sort_unstable();
    costs.get(costs.len() * 999 / 1000).copied().unwrap_or(1).max(1)
}

fn difference(pair: &StereoPair, naive: &StereoPair) -> Pixels {
    let channel = |a: u8, b: u8| (u32::from(a.abs_diff(b)) * GAIN).min(255) as u8;
    let pixels = pair.right.rgba8.iter().zip(&naive.right.rgba8);
    let rgba8 = pixels.map(|(a, b)| [channel(a[0], b[0]), channel(a[1], b[1]), channel(a[2], b[2]), 255]).collect();
    Pixels::new(pair.right.width, pair.right.height, rgba8)
}

fn png(picture: &Pixels) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = Cursor::new(Vec::new());
    let pixels = picture.rgba8.as_flattened();
    PngEncoder::new(&mut bytes).write_image(pixels, picture.width, picture.height, ExtendedColorType::Rgba8)?;
    Ok(bytes.into_inner())
}
