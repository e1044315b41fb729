//! Measures adaptive supersampling in stereo, by the paper's method and by `bracket`.

use stereotrace::{
    Adaptive, Error, GBuffer, Method, Options, Renderer, Scene, StereoCamera, StereoPair, UploadedScene, View,
    blocking::Wait,
    scene::builtin::{Builtin, RandomObjects},
    testing::cpu,
};

use crate::{
    counts::{clear, options},
    groups::{SEED, lit},
    lattice,
    options::Plan,
    rows::{Claim, Row, Setting, Values},
};

/// Name of the scene without mirrors and glass.
const DULL: &str = "20 objects, the first";
const PLACE: &str = "adaptive supersampling, table 3";
/// Largest difference of a channel between a pixel's corners for which it is not divided. The paper does not state its
/// value.
const TOLERANCE: u8 = 8;
const M: &str = "M: primary rays of the right view, of the left one's";
const SAVED: &str = "saved of the second view by rays, %";
const COUNTERS: &str = "saved of it by nodes and primitive tests, %";
const RAYS: &str = "samples a pixel of the left view";
const PSNR: &str = "PSNR, dB";
const OF_GRID: &str = "rays of both views, of those of n x n samples of the same PSNR, without reprojection";
const FIGURES: [&str; 6] = [RAYS, M, SAVED, COUNTERS, PSNR, OF_GRID];

pub(crate) fn rows(renderer: &mut Renderer, plan: &Plan) -> Result<Vec<Row>, Error> {
    // Glass only refracts, as in the paper.
    let random = |count| clear(&RandomObjects::new(count, SEED).shares(0.1, 0.1).scene());
    let mut scenes = vec![(DULL, Builtin::Random20.scene(), if plan.smoke { 2 } else { 5 })];
    if !plan.smoke {
        scenes.extend([("125, 10% each, clear", random(125), 4), ("1000, 10% each, clear", random(1000), 4)]);
    }
    let mut rows = Vec::new();
    for (name, scene, most) in &scenes {
        let scene = lit(scene, 1);
        for e_px in plan.e_px {
            let camera = Builtin::Random20.camera(plan.side, plan.side).interaxial_pixels(e_px);
            for levels in 2..=*most {
                eprintln!("{name}: e = {e_px} px, {levels} levels of adaptive samples");
                let setting = |method: &str| Setting {
                    scene: (*name).into(),
                    e_px,
                    lights: 1,
                    samples: side_of(levels).pow(2),
                    method: method.into(),
                };
                rows.extend(by_bracket(renderer, &scene, camera, levels, &setting)?);
                if levels < 5 && *name == DULL {
                    let m = by_the_paper(renderer, &scene, camera, levels)?;
                    rows.push(row(M, setting("adelson-hodges"), levels, m));
                }
            }
        }
        let camera = Builtin::Random20.camera(plan.side / 4, plan.side / 4).interaxial_pixels(plan.e_px[0] / 4.0);
        rows.extend(at_equal_error(renderer, name, &scene, camera, plan)?);
    }
    rows.sort_by_key(|row| FIGURES.iter().position(|figure| *figure == row.claim.figure));
    Ok(rows)
}

/// Returns the number of samples along a side of a fully divided pixel: the paper's n.
fn side_of(levels: u32) -> u32 {
    (1 << (levels - 1)) + 1
}

fn row(figure: &'static str, setting: Setting, levels: u32, value: f64) -> Row {
    let paper = match (figure, levels) {
        (M, 2 | 3) => "never above 0.3, mostly 0.2 to 0.25",
        (M, 4) => "0.338",
        (SAVED, 2 | 3) => "at least 50 (of an adaptive tracer without stereo)",
        (SAVED, 4) => "66",
        _ => "",
    };
    Row { claim: Claim { place: PLACE, figure, paper }, setting, values: Values::of(&[value]) }
}

fn by_bracket(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: StereoCamera,
    levels: u32,
    setting: &impl Fn(&str) -> Setting,
) -> Result<Vec<Row>, Error> {
    let uploaded = renderer.upload(scene).wait()?;
    let mut render = |method| {
        let adaptive = Adaptive::new(levels, TOLERANCE.into());
        renderer
            .pair(&uploaded, &camera)
            .options(&options(method).g_buffer(GBuffer::None).adaptive(adaptive))
            .read()
            .wait()
    };
    let (naive, bracket) = (render(Method::Naive)?.statistics, render(Method::BRACKET)?.statistics);
    let pixels = camera.pose()?.size.map(f64::from).iter().product::<f64>();
    let share = |found: u64, of: u64| found as f64 / of as f64;
    let values = [
        (RAYS, naive.left.rays.primary as f64 / pixels),
        (M, share(bracket.right.rays.primary, naive.left.rays.primary)),
        (SAVED, 100.0 * (1.0 - share(bracket.right.rays.total(), naive.right.rays.total()))),
        (COUNTERS, 100.0 * (1.0 - share(bracket.right.cost(), naive.right.cost()))),
    ];
    Ok(values.map(|(figure, value)| row(figure, setting("bracket"), levels, value)).into())
}

/// Returns the paper's M: the number of traced right samples divided by the number of left samples. The samples of each
/// of the n rows of left pixels are reprojected by depth to the right view's finest sample grid. The latest of several
/// samples in one place wins. If two neighbours land farther apart than they were, the samples between them are
/// cleared. The right view is divided by its colours, and a requested sample is traced if no left sample landed there.
fn by_the_paper(renderer: &mut Renderer, scene: &Scene, camera: StereoCamera, levels: u32) -> Result<f64, Error> {
    let finest = lattice::camera(camera, side_of(levels) - 1)?;
    let all = lattice::samples(renderer, scene, &finest)?;
    let frame = cpu::Frame::new(&all.pose);
    let width = all.left.width as usize;
    let mut left = vec![false; all.left.rgba8.len()];
    divide_all(&all.left, levels, &mut left);
    let mut landed = vec![false; left.len()];
    for (row, landed) in landed.chunks_exact_mut(width).enumerate() {
        let mut before: Option<(i32, i32)> = None;
        for column in (0..width).filter(|column| left[row * width + column]) {
            let here = cpu::adelson_hodges::landing(&frame, column, all.left.depth[row * width + column]);
            if let Some((_, x_before)) = before.filter(|(at, x)| here - x > column as i32 - at) {
                (x_before.max(-1) + 1..here.min(width as i32)).for_each(|at| landed[at as usize] = false);
            }
            if (0..width as i32).contains(&here) {
                landed[here as usize] = true;
            }
            before = Some((column as i32, here));
        }
    }
    let mut right = vec![false; left.len()];
    divide_all(&all.right, levels, &mut right);
    let traced = right.iter().zip(&landed).filter(|(asked, landed)| **asked && !**landed).count();
    Ok(traced as f64 / left.iter().filter(|asked| **asked).count() as f64)
}

/// Marks the samples that a view requests.
fn divide_all(view: &View, levels: u32, asked: &mut [bool]) {
    let side = side_of(levels) - 1;
    for y in (0..view.height - 1).step_by(side as usize) {
        for x in (0..view.width - 1).step_by(side as usize) {
            divide(view, [x, y], side, asked);
        }
    }
}

fn divide(view: &View, [x, y]: [u32; 2], side: u32, asked: &mut [bool]) {
    let corners = [[x, y], [x + side, y], [x, y + side], [x + side, y + side]];
    let corners = corners.map(|[x, y]| (y * view.width + x) as usize);
    corners.iter().for_each(|&corner| asked[corner] = true);
    let differs = (0..3).any(|channel| {
        let values = corners.map(|corner| view.rgba8[corner][channel]);
        values.iter().max().zip(values.iter().min()).is_some_and(|(most, least)| most - least > TOLERANCE)
    });
    if differs && side > 1 {
        let half = side / 2;
        let parts = [[x, y], [x + half, y], [x, y + half], [x + half, y + half]];
        parts.into_iter().for_each(|part| divide(view, part, half, asked));
    }
}

/// The truth is rendered at this multiple of the picture's width and height, with `TRUE_SAMPLES` samples per pixel.
const TRUE_SIDE: u32 = 4;
const TRUE_SAMPLES: u32 = 64;

/// Compares the cost of adaptive samples with n x n samples of equal error. The truth has 1024 samples per pixel.
fn at_equal_error(
    renderer: &mut Renderer,
    name: &str,
    scene: &Scene,
    camera: StereoCamera,
    plan: &Plan,
) -> Result<Vec<Row>, Error> {
    eprintln!("{name}: adaptive samples and n x n of one error");
    let uploaded = renderer.upload(scene).wait()?;
    let pose = camera.pose()?;
    let [width, height] = pose.size;
    let finer = camera.interaxial(pose.interaxial).size(TRUE_SIDE * width, TRUE_SIDE * height);
    let plain = |method| Options::new(method).linear(true).g_buffer(GBuffer::None);
    let samples = if plan.smoke { 1 } else { TRUE_SAMPLES };
    let truth = renderer.pair(&uploaded, &finer).options(&plain(Method::Naive).samples(samples)).read().wait()?;
    let truth = [&truth.left, &truth.right].map(|view| means(view, [width, height]));
    let rays = |pair: &StereoPair| (pair.statistics.left.rays.total() + pair.statistics.right.rays.total()) as f64;
    let mut grids = Vec::new();
    for side in 1..=if plan.smoke { 2 } else { 8 } {
        let pair =
            renderer.pair(&uploaded, &camera).options(&plain(Method::Naive).samples(side * side)).read().wait()?;
        grids.push((rays(&pair), mean_square(&pair, &truth)));
    }
    let mut rows = Vec::new();
    for levels in 2..=if plan.smoke { 2 } else { 5 } {
        let pair = of_levels(renderer, &uploaded, &camera, plain(Method::Naive), levels)?;
        let error = mean_square(&pair, &truth);
        let setting = || Setting {
            scene: format!("{name}, {width}x{height}"),
            e_px: pose.interaxial_px,
            lights: 1,
            samples: side_of(levels).pow(2),
            method: "naive".into(),
        };
        rows.push(row(PSNR, setting(), levels, 10.0 * (255.0 * 255.0 / error).log10()));
        // No share is reported if the error is outside the range of the measured grids.
        let share = rays_of_error(&grids, error).map(|grid| rays(&pair) / grid);
        rows.extend(share.map(|share| row(OF_GRID, setting(), levels, share)));
    }
    Ok(rows)
}

fn of_levels(
    renderer: &mut Renderer,
    scene: &UploadedScene,
    camera: &StereoCamera,
    options: Options,
    levels: u32,
) -> Result<StereoPair, Error> {
    renderer.pair(scene, camera).options(&options.adaptive(Adaptive::new(levels, TOLERANCE.into()))).read().wait()
}

/// Returns the rays of a grid with this error, by interpolation between two measured grids. It assumes that the error
/// is a power of the number of rays.
fn rays_of_error(grids: &[(f64, f64)], error: f64) -> Option<f64> {
    let between = grids.windows(2).find(|two| two[0].1 >= error && error >= two[1].1)?;
    let [(rays_a, error_a), (rays_b, error_b)] = [between[0], between[1]];
    let way = (error_a / error).ln() / (error_a / error_b).ln();
    Some(rays_a * (rays_b / rays_a).powf(way))
}

/// Returns the mean of a larger picture's linear colours over each pixel, in sRGB from 0 to 255.
fn means(view: &View, [width, height]: [u32; 2]) -> Vec<[f64; 3]> {
    let side = TRUE_SIDE;
    let mean = |place: u32| {
        let [x, y] = [side * (place % width), side * (place / width)];
        let parts = (0..side * side).map(|part| ((y + part / side) * view.width + x + part % side) as usize);
        let sum = parts.fold([0.0; 3], |sum: [f64; 3], part| {
            std::array::from_fn(|channel| sum[channel] + f64::from(view.linear[part][channel]))
        });
        sum.map(|sum| encoded(sum / f64::from(side * side)))
    };
    (0..width * height).map(mean).collect()
}

/// Converts linear light to sRGB, 0 to 255, without rounding.
fn encoded(linear: f64) -> f64 {
    let linear = linear.clamp(0.0, 1.0);
    255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Returns the mean squared difference from the truth over both views, in sRGB.
fn mean_square(pair: &StereoPair, truth: &[Vec<[f64; 3]>; 2]) -> f64 {
    let colors = [&pair.left, &pair.right].into_iter().zip(truth);
    let squares = colors.flat_map(|(view, truth)| {
        let pairs = view.linear.iter().zip(truth);
        pairs.flat_map(|(found, truth)| {
            (0..3).map(|channel| (encoded(found[channel].into()) - truth[channel]).powi(2)).collect::<Vec<_>>()
        })
    });
    let count = 6 * truth[0].len();
    squares.sum::<f64>() / count as f64
}
