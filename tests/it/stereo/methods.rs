//! Tests the methods against each other and against `Naive` of the same run.

use std::num::NonZeroU32;

use stereotrace::{
    BufferDepth, Check, Finish, MISS, Method, Options, PixelSource, StereoCamera, StereoPair,
    blocking::Wait,
    glam::Vec3,
    metrics::{Difference, compare},
    scene::builtin::Builtin,
    testing::cpu::reproject::lemma1,
};

use super::{
    SIZE,
    common::{cases, random::Random, render, renderer},
    render_builtin,
};

const BUFFER_2E: Method = Method::Buffer(BufferDepth::TwiceInteraxial, Check::All);
const TRUSTING: Method = Method::Atomic(Check::None);

#[test]
fn ideal_copies_the_left_view() {
    let pair = render_builtin(Builtin::Spheres, Method::Ideal);
    assert_eq!(pair.left, pair.right);
    assert!(pair.source.iter().all(|source| *source == PixelSource::Reused));
}

#[test]
fn zero_interaxial_gives_identical_eyes_by_every_method() {
    let scene = Builtin::Spheres.scene();
    let camera = Builtin::Spheres.camera(63, 65).interaxial(0.0);
    for &method in Method::ALL {
        let pair = render(&scene, &camera, method);
        assert_eq!(pair.left, pair.right, "{method}");
    }
}

#[test]
fn left_differs_from_right_and_every_method_has_the_same_left() {
    let naive = render_builtin(Builtin::Hall, Method::Naive);
    assert_ne!(naive.left.rgba8, naive.right.rgba8);
    for &method in Method::ALL {
        assert_eq!(render_builtin(Builtin::Hall, method).left, naive.left, "{method}");
    }
}

#[test]
fn atomic_and_buffer_choose_the_same_candidate_everywhere() {
    for &builtin in Builtin::ALL {
        let atomic = render_builtin(builtin, Method::ATOMIC);
        let buffer = render_builtin(builtin, Method::BUFFER);
        assert_eq!(atomic.source, buffer.source, "{builtin}");
        assert_eq!(atomic.right, buffer.right, "{builtin}");
        assert_eq!(buffer.statistics.lost_candidates, 0, "{builtin}: Lemma 1's depth never loses one");
    }
}

#[test]
fn a_buffer_of_2e_slots_loses_candidates_nearer_than_half_the_screen_and_one_slot_more_than_fits_does_not() {
    let near = render_builtin(Builtin::Near, BUFFER_2E);
    assert!(near.statistics.lost_candidates > 0, "nearest surface at d/7");
    // With atomicMax the farther candidates are lost, so the picture is the same.
    assert_eq!(near.right, render_builtin(Builtin::Near, Method::BUFFER).right);
    let far = render_builtin(Builtin::Fence, BUFFER_2E);
    assert_eq!(far.statistics.lost_candidates, 0, "nothing nearer than 0.65 d");
    let shallow = BufferDepth::Fixed(NonZeroU32::new(2).unwrap());
    let shallow = render_builtin(Builtin::Near, Method::Buffer(shallow, Check::All));
    assert!(shallow.statistics.lost_candidates > near.statistics.lost_candidates);
    assert_eq!(shallow.statistics.buffer_depth, 2);
}

#[test]
fn lemma_1_bounds_the_columns_that_meet() {
    // Over random depths in [near, far], all columns that land on one right column are fewer than B + 1 columns apart.
    let mut random = Random::new(5);
    for case in 0..200 {
        let camera = StereoCamera::look_at(Vec3::Z, Vec3::ZERO)
            .size(400, 1)
            .screen_distance(1.0)
            .interaxial_pixels(random.between(0.0, 60.0));
        let pose = camera.pose().unwrap();
        let near = random.between(0.05, 2.0);
        let far = if case % 3 == 0 { f32::INFINITY } else { near * random.between(1.0, 20.0) };
        let bound = lemma1(&pose, near, far);
        let frame = stereotrace::testing::cpu::Frame::new(&pose);
        let mut first = vec![None; 400];
        for column in 0..400 {
            let z = match random.unit() {
                u if u < 0.2 => near,
                u if u > 0.8 => far.min(stereotrace::FAR),
                _ => (near * random.between(1.0, 20.0)).min(far),
            };
            if let Some(right) = stereotrace::testing::cpu::reproject::right_column(&frame, column, z) {
                let first = *first[right].get_or_insert(column);
                // f32 rounds X by a few ulps of 400 px.
                assert!(((column - first) as f64) < bound + 1.0 + 1e-4, "case {case}: {first} {column} {bound}");
            }
        }
    }
}

/// Returns the difference of `Atomic`'s right view from `Naive`'s.
fn accuracy(builtin: Builtin, method: Method) -> Difference {
    let naive = render_builtin(builtin, Method::Naive);
    compare(&render_builtin(builtin, method).right, &naive.right, &naive.pose).unwrap()
}

#[test]
fn atomic_is_as_accurate_as_measured_and_trust_without_verification_is_not() {
    // The entries are the scene, the percentage of pixels with a wrong surface, and the MSE. They were measured on
    // llvmpipe at 190x107. The bounds are 1.5 times these values.
    let measured = [
        (Builtin::Spheres, 1.928, 112.26),
        (Builtin::Hall, 2.120, 264.24),
        (Builtin::Fence, 6.040, 326.35),
        (Builtin::Hidden, 0.000, 9.91),
        (Builtin::Near, 0.044, 11.11),
        (Builtin::Grazing, 2.095, 84.52),
    ];
    for (builtin, wrong_surface, mse) in measured {
        let atomic = accuracy(builtin, Method::ATOMIC);
        assert!(atomic.wrong_surface_percent <= 1.5 * wrong_surface, "{builtin}: {atomic:?}");
        assert!(atomic.mse <= 1.5 * mse, "{builtin}: {atomic:?}");
        let trusting = accuracy(builtin, TRUSTING);
        // In the other scenes, few occluders are visible to the right eye alone. There, unverified reuse adds less than
        // half to the error.
        if matches!(builtin, Builtin::Fence | Builtin::Near | Builtin::Grazing) {
            assert!(trusting.wrong_surface_percent > 1.5 * wrong_surface, "{builtin}: {trusting:?}");
        }
        if matches!(builtin, Builtin::Fence | Builtin::Grazing) {
            assert!(trusting.mse > 1.5 * mse, "{builtin}: {trusting:?}");
        }
    }
}

/// Returns which primitives of a built-in scene are mirrors or glass. Their reflections and refractions depend on the
/// eye.
fn sending(builtin: Builtin) -> Vec<bool> {
    let scene = builtin.scene();
    let triangles = scene.triangles().iter().map(|triangle| triangle.material);
    let spheres = scene.spheres().iter().map(|sphere| sphere.material);
    let ellipsoids = scene.ellipsoids().iter().map(|ellipsoid| ellipsoid.material);
    let planes = scene.planes().iter().map(|plane| plane.material);
    let materials = triangles.chain(spheres).chain(ellipsoids).chain(planes);
    materials.map(|material| scene.materials()[material.0 as usize].finish != Finish::Matte).collect()
}

/// Returns whether a pixel shows a mirror or glass.
fn sends_rays(sending: &[bool], primitive: u32) -> bool {
    sending.get(primitive as usize).is_some_and(|sends| *sends)
}

#[test]
fn the_right_view_follows_the_map_and_the_counts_follow_both() {
    for &builtin in cases(Builtin::ALL, 2) {
        let naive = render_builtin(builtin, Method::Naive);
        let mut renderer = renderer();
        let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
        let camera = builtin.camera(SIZE.0, SIZE.1);
        let pair = renderer
            .pair(&uploaded, &camera)
            .options(&Options::new(Method::ATOMIC).linear(true).count(true))
            .read()
            .wait()
            .unwrap();
        let count = |kind| pair.source.iter().filter(|source| **source == kind).count() as u64;
        let (s, pixels) = (&pair.statistics, u64::from(SIZE.0 * SIZE.1));
        let fates = [PixelSource::Reused, PixelSource::Bad, PixelSource::Missed].map(count);
        assert_eq!([s.reused, s.bad, s.missed], fates);
        assert_eq!(fates.iter().sum::<u64>(), pixels);
        assert_eq!((s.left.rays.primary, s.left.rays.verification), (pixels, 0));
        assert_eq!((s.right.rays.primary, s.right.rays.verification), (s.bad + s.missed, pixels - s.missed));
        assert!(s.left.rays.shadow > 0 && s.left.nodes > pixels && s.left.primitive_tests > 0);
        assert!(s.right.cost() < s.left.cost());
        let sending = sending(builtin);
        for (index, source) in pair.source.iter().enumerate() {
            match source {
                PixelSource::Reused if sends_rays(&sending, pair.right.primitive[index]) => {}
                PixelSource::Reused => {
                    let row = index / SIZE.0 as usize * SIZE.0 as usize;
                    let reused = pair.right.linear[index];
                    assert!(pair.left.linear[row..row + SIZE.0 as usize].contains(&reused), "pixel {index}");
                }
                _ => assert_eq!(pair.right.linear[index], naive.right.linear[index], "pixel {index}"),
            }
        }
        // A miss has neither depth, primitive nor object.
        for view in [&pair.left, &pair.right] {
            for index in 0..pixels as usize {
                let hit = view.primitive[index] != MISS;
                assert_eq!((view.depth[index].is_finite(), view.object[index] != MISS), (hit, hit));
            }
        }
    }
}

#[test]
fn a_thread_a_row_sweeps_as_adelson_and_hodges_do() {
    for &builtin in cases(Builtin::ALL, 2) {
        let es_isler = render_builtin(builtin, Method::ES_ISLER);
        let adelson_hodges = render_builtin(builtin, Method::ADELSON_HODGES);
        assert_eq!(es_isler.source, adelson_hodges.source, "{builtin}");
        assert_eq!(es_isler.right, adelson_hodges.right, "{builtin}");
        // Both must equal a sweep in plain Rust over the left view's depths.
        let frame = stereotrace::testing::cpu::Frame::new(&es_isler.pose);
        let depths: Vec<f32> = es_isler.left.depth.iter().map(|depth| depth.min(stereotrace::FAR)).collect();
        let swept = stereotrace::testing::cpu::adelson_hodges::sweep(&frame, &depths);
        let naive = render_builtin(builtin, Method::Naive);
        let sending = sending(builtin);
        for (index, source) in swept.iter().enumerate() {
            if sends_rays(&sending, es_isler.right.primitive[index]) {
                continue;
            }
            let taken = index / SIZE.0 as usize * SIZE.0 as usize + (*source as usize).saturating_sub(1);
            let (fate, color) = match source {
                0 => (PixelSource::Missed, naive.right.linear[index]),
                _ => (PixelSource::Reused, naive.left.linear[taken]),
            };
            assert_eq!((es_isler.source[index], es_isler.right.linear[index]), (fate, color), "{builtin} {index}");
        }
    }
}

#[test]
fn edges_are_traced_and_the_rest_is_trusted() {
    let edges = Method::Atomic(Check::Edges);
    let width = SIZE.0 as usize;
    for builtin in [Builtin::Hall, Builtin::Spheres, Builtin::Fence] {
        let pair = render_builtin(builtin, edges);
        let left = &pair.left;
        let frame = stereotrace::testing::cpu::Frame::new(&pair.pose);
        let depths: Vec<f32> = left.depth.iter().map(|depth| depth.min(stereotrace::FAR)).collect();
        let parallax = |index: usize| pair.pose.parallax_px(left.depth[index]);
        let mut wrong = 0;
        for (index, source) in stereotrace::testing::cpu::reproject::reproject(&frame, &depths).iter().enumerate() {
            let (row, column) = (index / width, (*source as usize).wrapping_sub(1));
            if *source == 0 {
                assert_eq!(pair.source[index], PixelSource::Missed);
                continue;
            }
            let at = row * width + column;
            let beside = [
                (column > 0).then(|| at - 1),
                (column + 1 < width).then_some(at + 1),
                (row > 0).then(|| at - width),
                (row + 1 < SIZE.1 as usize).then_some(at + width),
            ];
            // Two sky pixels are both infinitely deep, so their parallaxes do not differ.
            let apart = |other: usize| match left.depth[other] == left.depth[at] {
                true => 0.0,
                false => (parallax(other) - parallax(at)).abs(),
            };
            let edge = |limit: f32| {
                let differs = |other: usize| left.object[other] != left.object[at] || apart(other) > limit;
                beside.into_iter().flatten().any(differs)
            };
            // Within rounding of the limit, either result is correct.
            let bad = pair.source[index] == PixelSource::Bad;
            wrong += usize::from(bad && !edge(1.0 - 1e-4) || !bad && edge(1.0 + 1e-4));
        }
        assert_eq!(wrong, 0, "{builtin}");
        assert!(pair.statistics.bad > 500, "{builtin}: {}", pair.statistics.bad);
        assert_eq!(pair.statistics.right.rays.verification, 0);
        let trusting = render_builtin(builtin, TRUSTING);
        let naive = render_builtin(builtin, Method::Naive);
        let error = |pair: &StereoPair| compare(&pair.right, &naive.right, &naive.pose).unwrap().mse;
        assert!(error(&pair) < 0.8 * error(&trusting), "{builtin}: {} {}", error(&pair), error(&trusting));
    }
}
