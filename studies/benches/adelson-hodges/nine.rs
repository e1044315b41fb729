//! Measures the paper's first method for several rays per pixel. Nine rays are at a pixel's corners, sides and centre,
//! and neighbouring pixels share all but the centre one. A left pixel is reused as a whole, by the depth of its centre
//! ray, the aiming ray. A right pixel in which no aiming ray lands is traced with all nine rays.

use std::{error::Error, path::Path};

use stereotrace::{GBuffer, Method, Options, Renderer, StereoCamera, View, blocking::Wait, testing::cpu};

use crate::{
    groups::lit,
    lattice,
    options::Plan,
    rows::{Claim, Row, Setting, Values},
};
use stereotrace::scene::builtin::Builtin;

/// Figures in the order of rows, with the paper's values.
const FIGURES: [(&str, &str); 6] = [
    ("right pixels traced again, %", "7.84, 9.93% more than with one ray"),
    ("rays saved, %", "almost 80, by time"),
    ("primary rays a pixel and view, traced in full", "expected to be 4; 3.69 by time"),
    ("differing pixels, %", "15.6"),
    ("mean RGB distance of differing pixels", "3.18"),
    ("ghosts: pixels that are carried over and over 30 units off, %", "pictured"),
];
/// Smallest RGB distance of a ghost. Ghosts are dim outlines, while an offset of half a pixel is not a ghost.
const GHOST: f64 = 30.0;

/// Returns a view's pixels, each the mean of its nine samples.
fn pixels(samples: &View, [width, height]: [u32; 2]) -> Vec<[u8; 4]> {
    let mean = |place: u32| {
        let [x, y] = [2 * (place % width), 2 * (place / width)];
        let nine = (0..9).map(|one| samples.rgba8[((y + one / 3) * samples.width + x + one % 3) as usize]);
        let sum = nine.fold([0; 4], |sum: [u32; 4], color| std::array::from_fn(|at| sum[at] + u32::from(color[at])));
        sum.map(|channel| (channel as f64 / 9.0).round() as u8)
    };
    (0..width * height).map(mean).collect()
}

/// Returns the left column that each right pixel of a row reuses. The depths of the aiming rays determine where left
/// columns land, and the last of several columns wins. If two neighbours land more than one pixel apart, the pixels
/// between them are cleared. With `extra`, the paper's remedy for ghosts, the second neighbour's pixel is cleared too.
fn carried(frame: &cpu::Frame, depths: &[f32], extra: bool) -> Vec<Option<usize>> {
    let width = depths.len();
    let mut row = vec![None; width];
    let mut before = None;
    for (column, &depth) in depths.iter().enumerate() {
        let here = cpu::adelson_hodges::landing(frame, column, depth);
        let gap = before.is_some_and(|before| here > before + 1);
        let mut clear = |from: i32, to: i32| (from.max(0)..to.min(width as i32)).for_each(|at| row[at as usize] = None);
        if let Some(before) = before {
            clear(before + 1, here);
        }
        if (0..width as i32).contains(&here) {
            row[here as usize] = if gap && extra { None } else { Some(column) };
        }
        before = Some(here);
    }
    let past = before.map_or(0, |before| before + 1);
    (past.max(0)..width as i32).for_each(|at| row[at as usize] = None);
    row
}

pub(crate) fn rows(renderer: &mut Renderer, plan: &Plan, folder: &Path) -> Result<Vec<Row>, Box<dyn Error>> {
    let scene = lit(&Builtin::Random20.scene(), 1);
    let mut rows = Vec::new();
    for e_px in plan.e_px {
        eprintln!("20 objects, the first: e = {e_px} px, nine rays a pixel and aiming rays");
        let camera = Builtin::Random20.camera(plan.side, plan.side).interaxial_pixels(e_px);
        for extra in [true, false] {
            let values = measure(renderer, &scene, camera, extra, plan.smoke, folder)?;
            let method = if extra { "aiming ray" } else { "aiming ray, no extra blank" };
            rows.extend(FIGURES.into_iter().zip(values).map(|((figure, paper), value)| Row {
                claim: Claim { place: "multiple rays", figure, paper },
                setting: Setting {
                    scene: "20 objects, the first".into(),
                    e_px,
                    lights: 1,
                    samples: 9,
                    method: method.into(),
                },
                values: Values::of(&[value]),
            }));
        }
    }
    rows.sort_by_key(|row| FIGURES.iter().position(|(figure, _)| *figure == row.claim.figure));
    Ok(rows)
}

fn measure(
    renderer: &mut Renderer,
    scene: &stereotrace::Scene,
    camera: StereoCamera,
    extra: bool,
    smoke: bool,
    folder: &Path,
) -> Result<[f64; 6], Box<dyn Error>> {
    let samples = lattice::samples(renderer, scene, &lattice::camera(camera, 2)?)?;
    let uploaded = renderer.upload(scene).wait()?;
    // This pair has the depths of the aiming rays and the colours of the pixels' centres.
    let aims =
        renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive).g_buffer(GBuffer::Ids)).read().wait()?;
    let size = aims.pose.size;
    let width = size[0] as usize;
    let [left, truth] = [&samples.left, &samples.right].map(|view| pixels(view, size));
    let frame = cpu::Frame::new(&aims.pose);
    let sources: Vec<_> =
        aims.left.depth.chunks_exact(width).flat_map(|depths| carried(&frame, depths, extra)).collect();
    let mut found = truth.clone();
    let mut asked = vec![false; samples.right.rgba8.len()];
    let (mut missed, mut ghosts) = (0, 0);
    for (place, source) in sources.iter().enumerate() {
        let [column, row] = [place % width, place / width];
        match source {
            Some(source) => {
                found[place] = left[row * width + source];
                let apart = |channel: usize| f64::from(found[place][channel].abs_diff(truth[place][channel])).powi(2);
                ghosts += usize::from((0..3).map(apart).sum::<f64>().sqrt() > GHOST);
            }
            None => {
                missed += 1;
                let nine = (0..9).map(|one| (2 * row + one / 3) * samples.right.width as usize + 2 * column + one % 3);
                nine.for_each(|sample| asked[sample] = true);
            }
        }
    }
    let difference = lattice::compare(&found, &truth, &aims)?;
    if !smoke {
        let mut picture = aims.right.picture();
        picture.rgba8 = found;
        std::fs::create_dir_all(folder)?;
        picture.save_png(folder.join(if extra { "nine.png" } else { "nine-ghosts.png" }))?;
    }
    let percent = |count: usize, all: usize| 100.0 * count as f64 / all as f64;
    Ok([
        percent(missed, truth.len()),
        percent(asked.iter().filter(|asked| !**asked).count(), asked.len()),
        asked.len() as f64 / truth.len() as f64,
        difference.differing_percent,
        difference.mean_difference,
        percent(ghosts, truth.len()),
    ])
}
