//! Tests several samples per pixel without jitter, against a picture with a pixel for each sample, filtered here in
//! f64.

use crate::common;

use std::ops::ControlFlow;

use common::{
    gpu_with_limits, has_small_bands, random_stage, renderer,
    sampling::{camera, weight},
};
use stereotrace::{
    Error, Filter, GBuffer, Gpu, Material, Mesh, Method, Options, PixelSource, Renderer, Rig, Rows, Scene, Sky,
    StereoCamera, View,
    blocking::Wait,
    glam::Vec3,
    output::{Anaglyph, Packing},
    wgpu,
};

/// Filters a picture of side x side samples per pixel, each pixel separately.
fn filtered(samples: &View, side: u32, filter: Filter) -> Vec<[f32; 3]> {
    let (width, height) = (samples.width / side, samples.height / side);
    let mut pixels = Vec::new();
    for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        let near = |pixel: u32, all: u32| pixel.saturating_sub(2) * side..((pixel + 3) * side).min(all);
        for y in near(row, samples.height) {
            for x in near(column, samples.width) {
                let away =
                    |sample: u32, pixel: u32| (f64::from(sample) + 0.5) / f64::from(side) - f64::from(pixel) - 0.5;
                let weight = weight(filter, away(x, column)) * weight(filter, away(y, row));
                let color = samples.linear[(y * samples.width + x) as usize];
                (0..3).for_each(|channel| sum[channel] += weight * f64::from(color[channel]));
                weights += weight;
            }
        }
        pixels.push(sum.map(|sum| (sum / weights) as f32));
    }
    pixels
}

fn srgb(linear: f32) -> f64 {
    let linear = f64::from(linear);
    255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Checks that colours are equal up to the last digit of a sum.
fn assert_colors(found: &View, expected: &[[f32; 3]], what: &str) {
    assert_eq!(found.linear.len(), expected.len(), "{what}");
    for (place, (color, expected)) in found.linear.iter().zip(expected).enumerate() {
        for channel in 0..3 {
            let (value, wanted) = (color[channel], expected[channel]);
            assert!((value - wanted).abs() <= 1e-7, "{what}, {place}: {color:?} {expected:?}");
            let byte = f64::from(found.rgba8[place][channel]);
            assert!((byte - srgb(value)).abs() <= 0.5001, "{what}, {place}: {byte} of {value}");
        }
        assert_eq!((color[3], found.rgba8[place][3]), (1.0, 255), "{what}");
    }
}

/// Returns the values at the pixels' centres, such as depths and ids, from a picture of side x side samples per pixel.
fn centres<T: Copy>(samples: &View, side: u32, list: &[T]) -> Vec<T> {
    let (width, height) = (samples.width / side, samples.height / side);
    let places = (0..height).flat_map(|row| (0..width).map(move |column| [row, column]));
    places
        .map(|place| place.map(|pixel| pixel * side + side / 2))
        .map(|[y, x]| list[(y * samples.width + x) as usize])
        .collect()
}

#[test]
fn filtered_pictures_are_those_of_the_finer_picture() {
    // The finer pictures have several bands of 64 rows, and pixels with samples in two bands.
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    for (side, size) in [(2, [2051, 71]), (3, [1367, 47])] {
        let finer = camera(side * size[0], side * size[1]);
        let options = Options::new(Method::BRACKET).linear(true);
        let samples = renderer.pair(&uploaded, &finer).options(&options).read().wait().unwrap();
        let one = renderer.pair(&uploaded, &camera(size[0], size[1])).options(&options).read().wait().unwrap();
        for &filter in Filter::ALL {
            let options = options.clone().samples(side * side).filter(filter).jitter(false);
            let pair = renderer.pair(&uploaded, &camera(size[0], size[1])).options(&options).read().wait().unwrap();
            assert_eq!(pair.pose, one.pose);
            for (found, finer, one) in
                [(&pair.left, &samples.left, &one.left), (&pair.right, &samples.right, &one.right)]
            {
                let what = format!("{side} {filter}");
                assert_eq!([found.width, found.height], size);
                assert_colors(found, &filtered(finer, side, filter), &what);
                // Even grids have no sample in a pixel's centre, so a separate ray is traced there.
                let expected = |finer: Vec<u32>, one: &[u32]| if side == 2 { one.to_vec() } else { finer };
                let bits = |view: &View| Vec::from_iter(view.depth.iter().map(|depth| depth.to_bits()));
                assert!(bits(found) == expected(centres(finer, side, &bits(finer)), &bits(one)), "{what}");
                assert!(found.primitive == expected(centres(finer, side, &finer.primitive), &one.primitive), "{what}");
                assert!(found.object == expected(centres(finer, side, &finer.object), &one.object), "{what}");
                // The middle sample is the ray of a picture with one sample, except for the rounding of steps from
                // pixel to pixel.
                let other = found.primitive.iter().zip(&one.primitive).filter(|(a, b)| a != b).count();
                assert!(other <= if side == 2 { 0 } else { 6 }, "{what}: {other}");
            }
            let own = |mut rays: u64| {
                rays *= u64::from(side * side);
                rays + if side == 2 { u64::from(size[0] * size[1]) } else { 0 }
            };
            assert_eq!(pair.statistics.left.rays.primary, own(u64::from(size[0] * size[1])));
            let sources = if side == 2 { one.source.clone() } else { centres(&samples.right, side, &samples.source) };
            // Samples are searched down to the deepest bound of four tiles, so fewer of them are traced.
            let as_before =
                |(found, known): (&PixelSource, &PixelSource)| found == known || *found == PixelSource::Reused;
            assert!(pair.source.iter().zip(&sources).all(as_before), "{side} {filter}");
            let shadows = centres(&samples.right, side, &samples.shadow_source);
            assert!(pair.shadow_source == if side == 2 { one.shadow_source.clone() } else { shadows });
        }
    }
}

#[test]
fn rows_that_are_handed_on_make_the_whole_views() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(5)).wait().unwrap();
    let rig = Rig::at(camera(1051, 77), vec![-0.5, 0.5, 0.1]).traced(vec![0]);
    for (samples, g_buffer) in [(4, GBuffer::Ids), (9, GBuffer::Ids), (16, GBuffer::None)] {
        let options = Options::new(Method::Auto).samples(samples).filter(Filter::Gauss).linear(true).cost_map(true);
        let options = options.g_buffer(g_buffer);
        let whole = renderer.views(&uploaded, &rig).options(&options).read().wait().unwrap();
        let mut bands: Vec<Rows> = Vec::new();
        let rest = renderer
            .views(&uploaded, &rig)
            .options(&options)
            .rows(&mut |rows| {
                bands.push(rows);
                Ok(())
            })
            .wait();
        let rest = rest.unwrap();
        assert!(bands.len() > 1 || !has_small_bands(renderer.gpu()));
        for (index, view) in whole.views.iter().enumerate() {
            let mut next = 0;
            let (mut rgba8, mut depth, mut object, mut cost, mut source) = (vec![], vec![], vec![], vec![], vec![]);
            for band in &bands {
                assert_eq!(band.first, next, "{samples}");
                let rows = &band.views[index];
                next += rows.view.height;
                assert_eq!(rows.source.len() as u32, rows.view.height * rows.view.width);
                rgba8.extend(&rows.view.rgba8);
                depth.extend(&rows.view.depth);
                object.extend(&rows.view.object);
                cost.extend(&rows.view.cost);
                source.extend(&rows.source);
            }
            assert_eq!(next, 77);
            let found = (rgba8, depth, object, &source);
            let expected = &view.view;
            let expected_rows = (expected.rgba8.clone(), expected.depth.clone(), expected.object.clone(), &view.source);
            assert!(found == expected_rows, "{samples} {index}");
            assert_eq!(view.source.len(), 1051 * 77);
            assert_eq!(view.view.depth.is_empty(), g_buffer == GBuffer::None);
            // The costs of the pixels add up to everything that was counted.
            assert!(cost == view.view.cost);
            let sum: u64 = cost.iter().map(|&cost: &u32| u64::from(cost)).sum();
            assert_eq!(sum, view.work.nodes + view.work.primitive_tests, "{samples} {index}");
            assert_eq!((rest.views[index].work, rest.views[index].view.height), (view.work, 0));
        }
    }
}

#[test]
fn every_method_is_filtered_and_exact_ones_stay_exact() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(6)).wait().unwrap();
    let rig = Rig::at(camera(61, 43), vec![-0.5, 0.5, 1.5, -1.5]).traced(vec![1]);
    let finer = Rig::at(camera(122, 86), vec![-0.5, 0.5, 1.5, -1.5]).traced(vec![1]);
    let mut naive = None;
    for &method in Method::ALL {
        let options = Options::new(method).linear(true);
        let filtering = options.clone().samples(4).filter(Filter::Tent).jitter(false);
        let views = renderer.views(&uploaded, &rig).options(&filtering).read().wait().unwrap();
        let samples = renderer.views(&uploaded, &finer).options(&options).read().wait().unwrap();
        let one = renderer.views(&uploaded, &rig).options(&options).read().wait().unwrap();
        for index in 0..4 {
            let (found, one) = (&views.views[index], &one.views[index]);
            let what = format!("{method}, view {index}");
            assert_colors(&found.view, &filtered(&samples.views[index].view, 2, Filter::Tent), &what);
            assert!(found.source == one.source && found.shadow_source == one.shadow_source, "{what}");
            assert!(found.view.depth == one.view.depth && found.view.primitive == one.view.primitive, "{what}");
            let rays = samples.views[index].work.rays.total() + one.work.rays.total();
            let searched = matches!(method, Method::Bracket(_) | Method::Auto);
            assert!(found.work.rays.total() == rays || (searched && found.work.rays.total() < rays), "{what}");
        }
        if method == Method::Naive {
            naive = Some(views);
        } else if method == Method::BRACKET_RAYS {
            let naive = naive.as_ref().expect("rendered before");
            (0..4).for_each(|index| assert!(views.views[index].view == naive.views[index].view, "view {index}"));
        }
    }
}

/// Returns a wall on the screen, left of `x` and below `y`, in front of black. Only ambient light reaches the wall, so
/// it is white.
fn half_planes(x: f32, y: f32) -> Scene {
    let mut scene = Scene::new();
    let white = scene.add_material(Material::new(Vec3::ONE));
    let corners = [[-9.0, -9.0], [x, -9.0], [x, y], [-9.0, y]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).materials(vec![white]);
    scene.add_mesh(&mesh).unwrap();
    scene.ambient = Some(Vec3::ONE);
    scene.sky = Sky::Constant(Vec3::ZERO);
    scene
}

fn straight(width: u32, height: u32) -> StereoCamera {
    camera(width, height).eye(Vec3::new(0.0, 0.0, 5.0)).interaxial(0.0)
}

#[test]
fn a_box_is_the_share_of_samples_that_an_edge_covers() {
    let mut renderer = renderer();
    // The picture has 40 pixels of 0.1 units. The edges are at column 23.43 and row 14.71, where no sample is.
    let uploaded = renderer.upload(&half_planes(0.343, 0.529)).wait().unwrap();
    for side in 2..=8_u32 {
        let options = Options::new(Method::Naive).samples(side * side).jitter(false).linear(true);
        let pair = renderer.pair(&uploaded, &straight(40, 40)).options(&options).read().wait().unwrap();
        let part = |share: f64| (share * f64::from(side) - 0.5).ceil().max(0.0) / f64::from(side);
        let (across, down) = (part(0.43), 1.0 - part(0.71));
        for (place, color) in pair.left.linear.iter().enumerate() {
            let share = |pixel: usize, edge: usize, cut: f64, before: f64, behind: f64| match pixel.cmp(&edge) {
                std::cmp::Ordering::Less => before,
                std::cmp::Ordering::Equal => cut,
                std::cmp::Ordering::Greater => behind,
            };
            let expected = share(place % 40, 23, across, 1.0, 0.0) * share(place / 40, 14, down, 0.0, 1.0);
            assert!((f64::from(color[0]) - expected).abs() < 1e-6, "{side}, {place}: {} {expected}", color[0]);
        }
    }
}

#[test]
fn constants_stay_constant_and_edges_where_they_are() {
    let mut renderer = renderer();
    let mut empty = Scene::new();
    empty.sky = Sky::Constant(Vec3::new(0.3, 0.7, 0.01));
    let empty = renderer.upload(&empty).wait().unwrap();
    // The edges go through the middle of the picture.
    let edges = renderer.upload(&half_planes(0.0, 0.0)).wait().unwrap();
    for (&filter, side) in Filter::ALL.iter().flat_map(|filter| (1..=5_u32).map(move |side| (filter, side))) {
        let options = Options::new(Method::Naive).samples(side * side).filter(filter).jitter(false).linear(true);
        let pair = renderer.pair(&empty, &straight(7, 5)).options(&options).read().wait().unwrap();
        let sky = [0.3, 0.7, 0.01, 1.0];
        assert!(pair.left.linear.iter().all(|color| *color == sky), "{filter} {side}: {:?}", pair.left.linear[0]);
        let once = renderer.pair(&empty, &straight(7, 5)).options(&Options::new(Method::Naive)).read().wait().unwrap();
        assert_eq!(pair.left.rgba8, once.left.rgba8, "{filter} {side}");
        if side == 1 {
            continue;
        }
        // A pixel and its mirror image at the edge add up to 1. With an offset of half a sample they would not.
        let light = renderer.pair(&edges, &straight(20, 20)).options(&options).read().wait().unwrap().left.linear;
        for pixel in 0..20 {
            let ([right, left], [above, below]) =
                ([15 * 20 + pixel, 15 * 20 + 19 - pixel], [pixel * 20 + 4, (19 - pixel) * 20 + 4]);
            for [a, b] in [[right, left], [above, below]] {
                let sum = light[a][0] + light[b][0];
                assert!((sum - 1.0).abs() < 1e-6, "{filter} {side}, {pixel}: {sum}");
            }
        }
    }
}

#[test]
fn a_ramp_stays_the_ramp() {
    let mut renderer = renderer();
    // The sky is linear in the sine of the angle, so a narrow picture of it is nearly linear.
    let mut scene = Scene::new();
    scene.sky = Sky::Gradient { nadir: Vec3::ZERO, zenith: Vec3::ONE };
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let camera = StereoCamera::look_at(Vec3::ZERO, Vec3::new(0.0, 0.6, -0.8))
        .size(9, 32)
        .screen_distance(1.0)
        .screen_width(0.02)
        .interaxial(0.0);
    let mut light = |options: Options| {
        let pair = renderer.pair(&uploaded, &camera).options(&options.linear(true)).read().wait().unwrap();
        (0..32).map(|row| pair.left.linear[row * 9 + 4][0]).collect::<Vec<_>>()
    };
    let one = light(Options::new(Method::Naive));
    let step = (one[0] - one[31]) / 31.0;
    assert!(step > 4e-4, "{step}");
    for (&filter, side) in Filter::ALL.iter().flat_map(|filter| (2..=5_u32).map(move |side| (filter, side))) {
        let filtered = light(Options::new(Method::Naive).samples(side * side).filter(filter));
        for row in 1..31 {
            let off = (filtered[row] - one[row]) / step;
            assert!(off.abs() < 0.01, "{filter} {side}, row {row}: {off} pixels");
        }
    }
}

#[test]
fn a_tall_picture_comes_in_order_and_progress_is_a_share_of_all_rays() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&half_planes(0.0, 0.0)).wait().unwrap();
    let camera = straight(30, 9001).screen_width(0.01);
    let options = Options::new(Method::Naive).samples(4).filter(Filter::Tent);
    let (mut next, mut shares) = (0, Vec::new());
    let mut progress = |progress: stereotrace::Progress| {
        shares.push(progress.done);
        ControlFlow::Continue(())
    };
    let mut on_rows = |rows: Rows| {
        assert_eq!(rows.first, next);
        next += rows.views[0].view.height;
        Ok(())
    };
    let rig = Rig::pair(camera);
    pollster::block_on(renderer.views(&uploaded, &rig).options(&options).progress(&mut progress).rows(&mut on_rows))
        .unwrap();
    assert_eq!(next, 9001);
    assert!(shares.is_sorted() && shares[0] <= 0.2001 && shares.last() == Some(&1.0), "{shares:?}");
    let mut calls = 0;
    let stopped = renderer
        .pair(&uploaded, &camera)
        .options(&options)
        .progress(&mut |_| {
            calls += 1;
            if calls == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .read()
        .wait();
    assert!(matches!(stopped, Err(Error::Cancelled)) && calls == 2);
}

#[test]
fn one_sample_is_the_picture_without_any() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let options = Options::new(Method::BRACKET).count(true);
    let mut render = |options: &Options| {
        let mut pair = renderer.pair(&uploaded, &camera(61, 40)).options(options).read().wait().unwrap();
        pair.statistics.times = None;
        pair
    };
    let (usual, one) = (render(&options), render(&options.clone().samples(1).filter(Filter::Gauss)));
    assert!(usual == one);
    let four = render(&options.clone().samples(4));
    assert!(four.left.linear.is_empty() && four.left.rgba8.len() == 61 * 40);
    // Anaglyphs and packings of this pair have the usual sizes.
    assert_eq!(four.anaglyph(Anaglyph::Dubois).width, 61);
    assert_eq!(four.packed(Packing::SideBySide).width, 122);
}

#[test]
fn what_cannot_be_sampled_is_refused_by_name() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let mut refused = |camera: StereoCamera, samples: u32| {
        let options = Options::new(Method::Naive).samples(samples);
        let error = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap_err();
        assert!(matches!(error, Error::Samples { .. }), "{error:?}");
        let rows =
            renderer.views(&uploaded, &Rig::pair(camera)).options(&options).rows(&mut |_| Ok(())).wait().unwrap_err();
        assert_eq!(rows.to_string(), error.to_string());
        assert_eq!(
            renderer.pair(&uploaded, &camera).options(&options).trace().wait().unwrap_err().to_string(),
            error.to_string()
        );
        error.to_string()
    };
    for samples in [0, 5, 65] {
        let message = refused(camera(16, 16), samples);
        assert_eq!(message, format!("invalid samples: {samples} per pixel; use 1, 4, 9, 16, 25, 36, 49 or 64"));
    }
    let message = refused(camera(4, 20_000).screen_width(0.001), 64);
    assert!(
        message.starts_with("invalid samples: 64 per pixel; for 4x20000 pixels they form a grid of 32x160000"),
        "{message}"
    );
    let message = refused(camera(400, 300).screen_width(0.01), 16);
    assert!(message.contains("16 per pixel; for 400x300 pixels they are 1.2e-6 radians apart"), "{message}");
    let gpu = renderer.gpu().clone();
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let options = Options::new(Method::Naive).samples(4);
    let message = renderer
        .views(&uploaded, &Rig::pair(camera(16, 16)))
        .options(&options)
        .encode(&mut encoder)
        .wait()
        .unwrap_err()
        .to_string();
    assert!(
        message.starts_with("the depth of several samples per pixel (GBuffer::None asks for none) can't be encoded"),
        "{message}"
    );
}

#[test]
fn a_limit_that_only_samples_reach_is_said_to_be_theirs() {
    let gpu = gpu_with_limits(wgpu::Limits { max_texture_dimension_2d: 2048, ..Gpu::required_limits() });
    let mut renderer = Renderer::new(gpu);
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let mut render = |samples| {
        let options = Options::new(Method::BRACKET).samples(samples);
        renderer.pair(&uploaded, &camera(1025, 4)).options(&options).read().wait()
    };
    render(1).unwrap();
    let message = render(4).unwrap_err().to_string();
    let about = message.starts_with("4 samples per pixel: ") && message.contains("max_texture_dimension_2d");
    assert!(about && message.ends_with("use fewer samples or pixels"), "{message}");
}
