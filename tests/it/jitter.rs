//! Tests jittered samples. The expected pictures are filtered in f64 from the colours at the documented positions.

use crate::common;

use common::{
    is_exact,
    random::pcg,
    random_stage, renderer,
    sampling::{self, weight},
};
use stereotrace::{
    Error, Filter, GBuffer, Material, Mesh, Method, Options, Rig, Scene, Sky, StereoCamera, View, blocking::Wait,
    glam::Vec3, testing::suite::Trial,
};

/// Returns the distance of a row's samples to the right of their cells' middles, in cells. docs/DESIGN.md defines it.
fn offset(side: u32, seed: u32, row: u32) -> f64 {
    let hash = |row: u32| pcg(row ^ pcg(seed));
    let pixel = row / side;
    let mut order = Vec::from_iter(pixel * side..(pixel + 1) * side);
    order.sort_by_key(|&row| (hash(row), row));
    let rank = order.iter().position(|&other| other == row).unwrap();
    (rank as f64 + 0.5) / f64::from(side) - 0.5
}

/// Filters the light at positions in pixels from the picture's top left corner. Rows are filtered first, and each row's
/// weights are divided by their sum.
fn filtered(
    [width, height]: [u32; 2],
    (side, seed): (u32, u32),
    filter: Filter,
    light: impl Fn(f64, f64) -> f64,
) -> Vec<f64> {
    let places = |pixels: u32| (0..pixels * side).map(|sample| (f64::from(sample) + 0.5) / f64::from(side));
    let mut pixels = Vec::new();
    for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (sample_row, y) in places(height).enumerate() {
            let aside = offset(side, seed, sample_row as u32) / f64::from(side);
            let down = weight(filter, y - f64::from(row) - 0.5);
            let near = (f64::from(column) - 2.0, f64::from(column) + 3.0);
            let (mut along, mut across) = (0.0, 0.0);
            for x in places(width).map(|x| x + aside).filter(|x| (near.0..near.1).contains(x)) {
                let weight = weight(filter, x - f64::from(column) - 0.5);
                along += weight * if down > 0.0 { light(x, y) } else { 0.0 };
                across += weight;
            }
            sum += down * along / across;
            weights += down;
        }
        pixels.push(sum / weights);
    }
    pixels
}

fn camera(width: u32, height: u32) -> StereoCamera {
    sampling::camera(width, height).eye(5.0 * Vec3::Z)
}

/// Returns a white half plane on the screen, where `x cos a + y sin a < d`, in front of black.
fn half_plane(angle: f32, d: f32) -> Scene {
    let mut scene = Scene::new();
    let white = scene.add_material(Material::new(Vec3::ONE));
    let (normal, along) = (Vec3::new(angle.cos(), angle.sin(), 0.0), Vec3::new(-angle.sin(), angle.cos(), 0.0));
    let corners = [(d, -9.0), (d, 9.0), (-9.0, 9.0), (-9.0, -9.0)].map(|(a, b)| a * normal + b * along);
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).materials(vec![white]);
    scene.add_mesh(&mesh).unwrap();
    scene.ambient = Some(Vec3::ONE);
    scene.sky = Sky::Constant(Vec3::ZERO);
    scene
}

/// Tests vertical, horizontal and slanted edges on the screen. Both eyes see points of the screen at the same position.
#[test]
fn an_edge_covers_what_the_documented_places_say_in_both_eyes() {
    let mut renderer = renderer();
    let size = [20, 15];
    for (angle, d) in [(0.0_f32, 0.1234), (0.07, 0.037), (1.570_796_4, 0.0067), (0.6, 0.211), (2.5, 0.111)] {
        let uploaded = renderer.upload(&half_plane(angle, d)).wait().unwrap();
        let (cos, sin) = (f64::from(angle.cos()), f64::from(angle.sin()));
        // The picture has 20 columns of 0.2 units.
        let inside = |x: f64, y: f64| (x - 10.0) * 0.2 * cos - (y - 7.5) * 0.2 * sin - f64::from(d);
        for side in 2..=6 {
            let seed = 40 + side;
            let filter = Filter::ALL[side as usize % 3];
            let options = Options::new(Method::ALL[side as usize % 2]).samples(side * side).filter(filter);
            let options = options.seed(seed).linear(true).noise_by_view(true);
            let expected = filtered(size, (side, seed), filter, |x, y| f64::from(u8::from(inside(x, y) < 0.0)));
            let unsure = filtered(size, (side, seed), filter, |x, y| f64::from(u8::from(inside(x, y).abs() < 2e-6)));
            let pair = renderer.pair(&uploaded, &camera(size[0], size[1])).options(&options).read().wait().unwrap();
            let mut cut = 0;
            for view in [&pair.left, &pair.right] {
                for (place, color) in view.linear.iter().enumerate() {
                    let (found, wanted) = (f64::from(color[0]), expected[place]);
                    assert!(
                        (found - wanted).abs() <= unsure[place] + 1e-6,
                        "{angle} {side} {filter}, {place}: {found} {wanted}"
                    );
                    cut += usize::from(found > 0.01 && found < 0.99);
                }
            }
            assert!(cut > 20 && unsure.iter().sum::<f64>() < 0.5, "{angle} {side}: {cut}");
        }
    }
}

#[test]
fn an_upright_edge_has_as_many_levels_as_a_pixel_has_samples() {
    let mut renderer = renderer();
    let side = 3;
    for jitter in [false, true] {
        let mut levels = std::collections::BTreeSet::new();
        for step in 0..60 {
            // In 60 steps, the edge moves to the right by one pixel, which is 0.4 units.
            let uploaded = renderer.upload(&half_plane(0.0, 0.001 + step as f32 * 0.4 / 60.0)).wait().unwrap();
            let options = Options::new(Method::Naive).samples(side * side).jitter(jitter).linear(true);
            let pair = renderer.pair(&uploaded, &camera(10, 1)).options(&options).read().wait().unwrap();
            levels.insert((9.0 * pair.left.linear[5][0]).round() as u32);
        }
        let expected = if jitter { Vec::from_iter(0..=9) } else { vec![0, 3, 6, 9] };
        assert_eq!(Vec::from_iter(levels), expected);
    }
}

#[test]
fn constants_stay_constant_by_every_filter() {
    let mut renderer = renderer();
    let mut empty = Scene::new();
    empty.sky = Sky::Constant(Vec3::new(0.3, 0.7, 0.01));
    let uploaded = renderer.upload(&empty).wait().unwrap();
    for (&filter, side) in Filter::ALL.iter().flat_map(|filter| (1..=8_u32).map(move |side| (filter, side))) {
        let options = Options::new(Method::Naive).samples(side * side).filter(filter).linear(true);
        let pair = renderer.pair(&uploaded, &camera(7, 5)).options(&options).read().wait().unwrap();
        let off = |color: &[f32; 4]| (color[0] - 0.3).abs().max((color[1] - 0.7).abs()).max((color[2] - 0.01).abs());
        assert!(pair.left.linear.iter().all(|color| off(color) < 1e-6), "{filter} {side}: {:?}", pair.left.linear[0]);
    }
}

fn without_color(view: &View) -> View {
    let mut view = view.clone();
    (view.rgba8, view.linear, view.cost) = (Vec::new(), Vec::new(), Vec::new());
    view
}

#[test]
fn depth_ids_and_sources_are_those_of_rays_through_the_pixels_centres() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let camera = camera(61, 40);
    let one = renderer.pair(&uploaded, &camera).options(&Options::new(Method::BRACKET)).read().wait().unwrap();
    for samples in [1, 4, 9] {
        let options = Options::new(Method::BRACKET).samples(samples);
        let still = renderer.pair(&uploaded, &camera).options(&options.clone().jitter(false)).read().wait().unwrap();
        let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        assert!(without_color(&pair.left) == without_color(&one.left), "{samples}");
        assert!(without_color(&pair.right) == without_color(&one.right), "{samples}");
        assert!(pair.source == one.source && pair.shadow_source == one.shadow_source, "{samples}");
        // A single sample is in the pixel's centre, with and without jitter.
        assert_eq!(pair.left.rgba8 == still.left.rgba8, samples == 1);
        let rays = 61 * 40 * u64::from(if samples == 1 { 1 } else { samples + 1 });
        assert_eq!(pair.statistics.left.rays.primary, rays);
        // Without a G-buffer, there are no rays through the pixels' centres.
        let colors = options.g_buffer(GBuffer::None);
        let alone = renderer.pair(&uploaded, &camera).options(&colors).read().wait().unwrap();
        assert!(alone.left.rgba8 == pair.left.rgba8 && alone.right.rgba8 == pair.right.rgba8);
        assert_eq!(alone.statistics.left.rays.primary, 61 * 40 * u64::from(samples));
        assert_eq!((alone.source.len(), alone.left.depth.len()), (61 * 40, 0));
    }
}

#[test]
fn the_same_seed_makes_the_same_picture_and_another_one_another() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(5)).wait().unwrap();
    let mut picture = |seed, method| {
        let options = Options::new(method).samples(4).filter(Filter::Tent).seed(seed).linear(true);
        renderer.pair(&uploaded, &camera(61, 43)).options(&options).read().wait().unwrap()
    };
    let [first, again, other] = [1, 1, 2].map(|seed| picture(seed, Method::BRACKET));
    assert!((&first.left, &first.right) == (&again.left, &again.right));
    let differing = first.left.rgba8.iter().zip(&other.left.rgba8).filter(|(a, b)| a != b).count();
    assert!(differing > 61 * 43 / 20, "{differing}");
}

/// Tests filtered pictures of every exact method, sweeps on the device and on the host, and a rig with views on both
/// sides.
#[test]
fn methods_that_agree_without_jitter_agree_with_it() {
    let mut renderer = renderer();
    let exact = is_exact(&renderer);
    let scenes = [random_stage(6), Trial::Wires.scene(), Trial::Fence.scene()];
    let cameras = [camera(61, 43), Trial::Wires.camera(61, 43), Trial::Fence.camera(61, 43)];
    for (scene, camera) in scenes.iter().zip(cameras) {
        let uploaded = renderer.upload(scene).wait().unwrap();
        let rig = Rig::at(camera, vec![-0.5, 0.5, 1.5, -1.5]).traced(vec![1]);
        for samples in [4, 9] {
            let mut of = |method| {
                let options = Options::new(method).samples(samples).filter(Filter::Gauss).linear(true);
                let views =
                    renderer.views(&uploaded, &rig).options(&options.noise_by_view(true)).read().wait().unwrap();
                Vec::from_iter(views.views.into_iter().map(|view| view.view))
            };
            let [naive, rays, scanline, sequential] =
                [Method::Naive, Method::BRACKET_RAYS, Method::ES_ISLER, Method::ADELSON_HODGES].map(&mut of);
            for view in 0..4 {
                assert!(!exact || naive[view] == rays[view], "{samples}, view {view}");
                assert!(!exact || scanline[view] == sequential[view], "{samples}, view {view}");
            }
        }
    }
}

/// Methods that reuse colours have as many wrong pixels with jitter as without. They reuse samples of the same row, and
/// all samples of a row have the same offset.
#[test]
fn methods_that_copy_are_as_wrong_as_without_jitter() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(7)).wait().unwrap();
    let mut picture = |method, jitter| {
        let options = Options::new(method).samples(9).jitter(jitter).linear(true);
        renderer.pair(&uploaded, &camera(61, 43)).options(&options).read().wait().unwrap().right.linear
    };
    let naive = [false, true].map(|jitter| picture(Method::Naive, jitter));
    for &method in Method::ALL.iter().filter(|&&method| method != Method::Ideal) {
        let [still, jittered] = [false, true].map(|jitter| {
            let pairs = picture(method, jitter).into_iter().zip(&naive[usize::from(jitter)]).collect::<Vec<_>>();
            pairs.iter().map(|(a, b)| f64::from((a[1] - b[1]).abs())).sum::<f64>() / pairs.len() as f64
        });
        println!("{method}: {still:.5} {jittered:.5}");
        assert!(jittered <= 1.2 * still + 1e-4, "{method}: {still} {jittered}");
    }
}

#[test]
fn centres_that_fill_memory_are_refused_with_a_remedy() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Scene::new()).wait().unwrap();
    let camera = camera(20_000, 20_000).screen_width(40.0).screen_distance(5.0);
    let options = Options::new(Method::Naive).samples(9);
    let error =
        renderer.views(&uploaded, &Rig::pair(camera)).options(&options).rows(&mut |_| Ok(())).wait().unwrap_err();
    let message = error.to_string();
    assert!(
        matches!(error, Error::Limit { .. }) && message.ends_with("without jitter, or only colours (GBuffer::None)"),
        "{message}"
    );
}
