//! Tests that random cameras of a data set are in free space.

use crate::common;

use common::renderer;
use stereotrace::{
    Material, Mesh, Scene, StereoCamera,
    blocking::Wait,
    dataset::FreePoses,
    glam::{DVec3, Vec3, vec3},
};

/// Returns the faces of a box whose front sides face outward or inward.
fn block(low: Vec3, high: Vec3, inward: bool) -> Mesh {
    let corner = |index: usize| {
        Vec3::from_array(std::array::from_fn(|axis| if index >> axis & 1 == 0 { low[axis] } else { high[axis] }))
    };
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let turned = triangles.map(|[a, b, c]| if inward { [a, c, b] } else { [a, b, c] });
    Mesh::new((0..8).map(corner).collect(), turned.collect())
}

/// Returns a room of 10 x 4 x 10 with a solid block of 4 x 4 x 4 in it.
fn room(walls_face_inward: bool) -> Scene {
    let mut scene = Scene::new();
    let grey = scene.add_material(Material::new(Vec3::splat(0.5)));
    for (low, high, inward) in [
        (vec3(-5.0, 0.0, -5.0), vec3(5.0, 4.0, 5.0), walls_face_inward),
        (vec3(-2.0, 0.0, -2.0), vec3(2.0, 4.0, 2.0), false),
    ] {
        scene.add_mesh(&block(low, high, inward).materials(vec![grey; 12])).unwrap();
    }
    scene
}

fn camera() -> StereoCamera {
    StereoCamera::look_at(vec3(-4.0, 1.6, 4.0), vec3(4.0, 1.6, 3.0)).size(64, 48).interaxial(0.1)
}

#[test]
fn places_in_a_room_are_neither_in_a_wall_nor_in_what_stands_there() {
    let renderer = renderer();
    // The walls face inward or outward. If they face outward, only the given camera shows that their back sides are
    // visible.
    for walls_face_inward in [true, false] {
        let scene = room(walls_face_inward);
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let poses = FreePoses::new(&scene, camera(), 7).unwrap().clearance(0.3);
        let mut tries = 0;
        for item in 0..60 {
            let found = poses.find(&renderer, &uploaded, item).wait().unwrap();
            let eye = found.camera.pose().unwrap().eye.as_vec3();
            // The clearance is tested in 128 directions, so a corner may be a little nearer.
            let near = 0.25;
            let in_room = eye.cmpge(vec3(-5.0, 0.0, -5.0) + near).all() && eye.cmple(vec3(5.0, 4.0, 5.0) - near).all();
            let in_block = eye.x.abs() < 2.0 + near && eye.z.abs() < 2.0 + near;
            assert!(in_room && !in_block, "item {item}: {eye}");
            assert_eq!(found, poses.find(&renderer, &uploaded, item).wait().unwrap());
            tries += found.tries;
        }
        assert!(tries > 60, "nothing was rejected, though a fifth of the room is the block's");
    }
}

#[test]
fn around_an_object_the_distance_stays_and_the_object_is_seen() {
    let renderer = renderer();
    let mut scene = Scene::new();
    let grey = scene.add_material(Material::new(Vec3::splat(0.5)));
    scene.add_mesh(&block(vec3(0.0, 0.0, 0.0), vec3(2.0, 1.0, 3.0), false).materials(vec![grey; 12])).unwrap();
    let middle = DVec3::new(1.0, 0.5, 1.5);
    let camera = StereoCamera::look_at(vec3(6.0, 2.0, 1.5), middle).size(64, 48).vertical_fov_degrees(30.0);
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let poses = FreePoses::new(&scene, camera, 1).unwrap().surfaces(0.2);
    let eyes = Vec::from_iter((0..12).map(|item| {
        let pose = poses.find(&renderer, &uploaded, item).wait().unwrap().camera.pose().unwrap();
        assert!((pose.eye.distance(middle) - camera.pose().unwrap().eye.distance(middle)).abs() < 1e-4, "{}", pose.eye);
        pose.eye
    }));
    assert!(
        eyes.iter().any(|eye| eye.z > 3.0) && eyes.iter().any(|eye| eye.z < 0.0) && eyes.iter().any(|eye| eye.x < 0.0)
    );
}

#[test]
fn where_there_is_no_room_the_reasons_are_said() {
    let renderer = renderer();
    let scene = room(true);
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let refused = |poses: FreePoses<'_>| poses.find(&renderer, &uploaded, 3).wait().unwrap_err().to_string();
    let poses = || FreePoses::new(&scene, camera(), 0).unwrap();
    let near = refused(poses().clearance(6.0));
    assert!(near.contains("no free camera position for item 3 in 2000 tries: 2000 too near a surface"), "{near}");
    let aside = refused(poses().disparity(1e-3));
    assert!(aside.contains("with too large disparities") && !aside.contains(" 0 with too large"), "{aside}");
    assert!(FreePoses::new(&Scene::new(), camera(), 0).unwrap_err().to_string().contains("cameras can't be placed"));
}

#[cfg(feature = "dataset")]
mod made {
    use std::ops::ControlFlow;

    use serde_json::json;
    use stereotrace::{
        Builtin, CameraPath, Error, Limits, Method, Occlusion, Options, Renderer, StereoCamera,
        blocking::Wait,
        dataset::{MadePair, PairMaker, Spec},
        glam::DQuat,
    };

    use super::{common::folder::Folder, renderer};

    const SPEC: &str = r#"{
        "seed": 11, "pairs": 12, "size": [32, 24],
        "scenes": [{"builtin": "hall-finished", "weight": 2}, {"builtin": "near"}],
        "rig": {"interaxial": {"log_uniform": [0.05, 0.2]}},
        "randomise": {
            "lights": {"count": {"uniform": [1, 3]}, "radius": {"choice": [0.1, 0.2]}},
            "materials": {"share": 0.3, "tint": {"uniform": [0.1, 1.3]}, "specular": {"uniform": [0, 1]}},
            "exposure": {"uniform": [-1, 1]}
        },
        "outputs": ["color", "occlusion", "left.normal"]
    }"#;

    fn maker() -> PairMaker {
        PairMaker::new(Spec::from_json(SPEC, ".").unwrap())
    }

    fn made(maker: &mut PairMaker, renderer: &mut Renderer, item: u32) -> Result<MadePair, Error> {
        maker.pair(renderer, item, &mut |_| ControlFlow::Continue(())).wait()
    }

    /// Pairs are the same in any order, after pairs that can't be made, and on another device.
    #[test]
    fn a_pair_depends_on_nothing_but_its_number() {
        let (mut one, mut first) = (maker(), renderer());
        let pairs: Vec<_> = (0..12).map(|item| made(&mut one, &mut first, item)).collect();
        let failed = pairs.iter().filter(|pair| pair.is_err()).count();
        assert!((2..=8).contains(&failed), "some materials reflect more light than they receive: {failed}");
        let mut second = renderer();
        for (item, pair) in pairs.iter().enumerate().rev() {
            let again = made(&mut one, &mut second, item as u32);
            let (Ok(pair), Ok(again)) = (pair, &again) else {
                assert!(pair.is_err() && again.is_err(), "{item}");
                continue;
            };
            assert_eq!(again.record, pair.record);
            assert_eq!(again.pair.right.rgba8, pair.pair.right.rgba8);
            assert_eq!(
                again.truth.as_ref().unwrap().left.shading_normal,
                pair.truth.as_ref().unwrap().left.shading_normal
            );
            assert_eq!(again.camera, pair.camera);
        }
        let alone = (0..12).find(|&item| pairs[item as usize].is_ok()).unwrap();
        let pair = made(&mut maker(), &mut second, alone).unwrap();
        assert_eq!(pair.record, pairs[alone as usize].as_ref().unwrap().record);
        assert_eq!(one.scenes_read(), if one.scene_of(0) == 0 { [0, 1] } else { [1, 0] });
    }

    #[test]
    fn the_spec_with_its_defaults_is_the_same_spec() {
        let spec = maker().spec().clone();
        let text = spec.to_json();
        assert!(text.contains("\"shard_pairs\":64") && text.contains("\"weight\":2.0"), "{text}");
        assert_eq!(Spec::from_json(&text, ".").unwrap().to_json(), text);
        let twice = Spec::from_json(r#"{"pairs": 1, "scenes": [{"file": "a.obj", "file": "b.obj"}]}"#, ".");
        assert!(twice.unwrap_err().to_string().contains("the key 'file' occurs twice in one mapping"));
    }

    #[test]
    fn a_changed_or_missing_scene_is_refused() {
        let mut one = maker();
        let hash = one.scene_sha256(1).unwrap();
        let mut renderer = renderer();
        for item in 0..12 {
            drop(made(&mut one, &mut renderer, item)); // sets lights and materials
        }
        assert_eq!(one.scene_sha256(1).unwrap(), hash);
        let message = made(&mut one, &mut renderer, 12).unwrap_err().to_string();
        assert_eq!(message, "pairs: no pair 12; there are 12");
        let mut other = maker();
        other.expect_hashes(&[Some("0".repeat(64)), Some(hash)]);
        assert!(other.scene(1).is_ok());
        let message = other.scene(0).err().unwrap().to_string();
        assert_eq!(message, "scenes[0]: builtin:hall-finished: it has changed since the data set was begun");
        assert!(other.scene(2).err().unwrap().to_string().contains("no scene 2; there are 2"));
        let file = r#"{"pairs": 1, "scenes": [{"file": "no/such.obj"}]}"#;
        let message = PairMaker::new(Spec::from_json(file, "folder").unwrap()).scene(0).err().unwrap().to_string();
        assert!(message.starts_with("scenes[0]: folder/no/such.obj: "), "{message}");
    }

    fn of_spec(text: &str) -> PairMaker {
        PairMaker::new(Spec::from_json(text, ".").unwrap())
    }

    const GENERATED: &str = r#"{
        "seed": 5, "pairs": 6, "size": [64, 48],
        "scenes": [{"generate": "rooms"}, {"generate": {"kind": "floating", "glass": 0.3}}, {"generate": "outdoors"}]
    }"#;

    #[test]
    fn generated_pairs_are_the_same_alone_in_another_order_and_by_another_maker() {
        let (mut one, mut renderer) = (of_spec(GENERATED), renderer());
        let pairs: Vec<_> = (0..6).map(|item| made(&mut one, &mut renderer, item).unwrap()).collect();
        assert!(pairs.windows(2).all(|pair| pair[0].pair.left.rgba8 != pair[1].pair.left.rgba8));
        let mut other = of_spec(GENERATED);
        for item in [4, 1, 5, 0, 2, 3] {
            let again = made(&mut other, &mut renderer, item).unwrap();
            let first = &pairs[item as usize];
            assert_eq!(again.record, first.record);
            assert_eq!(again.pair.right.rgba8, first.pair.right.rgba8);
            assert_eq!(again.pair.left.depth, first.pair.left.depth);
            assert!(again.record.scene.starts_with("generate:"), "{}", again.record.scene);
            let [low, .., high] = again.record.disparity_percentiles.unwrap();
            let [least, most] = again.record.disparity.unwrap();
            assert!(least <= low && low < high && high <= most, "{:?}", again.record);
            assert!(least >= 0.0 && most < 0.21 * 64.0, "{:?}", again.record);
        }
        let alone = made(&mut of_spec(GENERATED), &mut renderer, 3).unwrap();
        assert_eq!(alone.pair.left.rgba8, pairs[3].pair.left.rgba8);
    }

    #[test]
    fn several_pairs_show_one_scene_with_its_materials() {
        let keys = r#""pairs": 9, "scene_pairs": 3,
            "randomise": {"materials": {"tint": {"uniform": [0.5, 1]}}, "exposure": {"uniform": [-1, 1]}},"#;
        let text = GENERATED.replace(r#""pairs": 6,"#, keys);
        let (mut maker, mut renderer) = (of_spec(&text), renderer());
        let mut shown = Vec::new();
        for item in 0..9 {
            let pair = made(&mut maker, &mut renderer, item).unwrap();
            let scene = maker.scene(maker.scene_of(item)).unwrap();
            shown.push((scene.sha256(), pair));
        }
        for three in shown.chunks(3) {
            for two in three.windows(2) {
                assert_eq!(two[0].0, two[1].0);
                assert_ne!(two[0].1.record.eye, two[1].1.record.eye);
            }
        }
        assert!(shown[0].0 != shown[3].0 && shown[3].0 != shown[6].0);
        // A pair does not depend on the pairs before it.
        let alone = made(&mut of_spec(&text), &mut renderer, 5).unwrap();
        assert_eq!(alone.pair.left.rgba8, shown[5].1.pair.left.rgba8);
        // Without the key, each pair has its own scene, and the first pair of three has the same one as before.
        let single = made(&mut of_spec(&text.replace(r#""scene_pairs": 3,"#, "")), &mut renderer, 3).unwrap();
        assert_eq!(single.pair.left.rgba8, shown[3].1.pair.left.rgba8);
    }

    const MOVING: &str = r#"{
        "seed": 3, "pairs": 2, "size": [48, 32],
        "scenes": [{"builtin": "near"}],
        "rig": {"interaxial": 0.1, "screen_distance": "inf"},
        "motion": {"camera": {"right": 0.1, "turn": 3}, "objects": {"distance": 0.2}},
        "outputs": ["color", "flow", "next.color"]
    }"#;

    /// Returns the first pair of a spec with some keys changed.
    fn changed(renderer: &mut Renderer, change: impl Fn(&mut serde_json::Value)) -> MadePair {
        let mut spec = serde_json::from_str(MOVING).unwrap();
        change(&mut spec);
        made(&mut of_spec(&spec.to_string()), renderer, 0).unwrap()
    }

    /// Elsewhere in the box of an outdoor scene, a camera may be below the ground.
    #[test]
    fn scenes_without_a_place_for_a_camera_are_drawn_again() {
        let text = r#"{"pairs": 10000, "seed": 5, "size": [64, 48],
            "scenes": [{"generate": "rooms"}, {"generate": "floating"}, {"generate": "outdoors"}]}"#;
        let mut renderer = renderer();
        let record = made(&mut of_spec(text), &mut renderer, 7133).unwrap().record;
        assert_eq!(record.rejects, ["the generated scene has no free place for a camera"]);
        assert!(record.eye[0].hypot(record.eye[2]) < 15.0, "{:?}", record.eye);
    }

    #[test]
    fn a_projector_moves_with_the_cameras_and_both_eyes_see_its_dots() {
        let mut renderer = renderer();
        let dark = |spec: &mut serde_json::Value| {
            spec["scenes"] = json!([{"builtin": "near", "lights": 0, "ambient": 0}]);
            spec["outputs"] = json!(["color", "disparity", "occlusion"]);
            spec["size"] = json!([96, 64]);
            spec["render"] = json!({"samples": 16});
        };
        let projector = json!({"intensity": 30, "fov": 60, "offset": [0.05, 0.1, 0], "dots": 120, "size": [192, 128]});
        let lit = |spec: &mut serde_json::Value| {
            dark(spec);
            spec["rig"]["projector"] = projector.clone();
        };
        let made_pair = changed(&mut renderer, lit);
        let unlit = changed(&mut renderer, dark);
        assert!(unlit.pair.left.rgba8.iter().all(|pixel| pixel[..3] == [0; 3]));
        let truth = made_pair.truth.as_ref().unwrap();
        let grey = |pixel: [u8; 4]| i32::from(pixel[0]) + i32::from(pixel[1]) + i32::from(pixel[2]);
        let (left, right) = (&made_pair.pair.left.rgba8, &made_pair.pair.right.rgba8);
        let bright = left.iter().filter(|pixel| grey(**pixel) > 150).count();
        assert!((100..3000).contains(&bright), "{bright}");
        // Carried by their disparities, the dots of the right picture are those of the left one.
        let seen = || (0..left.len()).filter(|&pixel| truth.left.occlusion[pixel] == Occlusion::Visible);
        let apart = |shift: f32| {
            let of = |pixel: usize| {
                let column = (pixel % 96) as f32 + 0.5 - shift * truth.left.disparity[pixel];
                let there = pixel / 96 * 96 + (column.max(0.0) as usize).min(95);
                i64::from((grey(left[pixel]) - grey(right[there])).abs())
            };
            seen().map(of).sum::<i64>() / seen().count() as i64
        };
        assert!(2 * apart(1.0) < apart(0.0), "{} {}", apart(1.0), apart(0.0));
        // The next pair is that of a camera which stands there from the start.
        let mut spec: serde_json::Value = serde_json::from_str(MOVING).unwrap();
        lit(&mut spec);
        spec["motion"].as_object_mut().unwrap().remove("objects");
        let moved = made(&mut of_spec(&spec.to_string()), &mut renderer, 0).unwrap();
        let mut there = of_spec(&spec.to_string());
        let camera = moved.next.as_ref().unwrap().camera;
        let again = there.pair_from(&mut renderer, 0, camera, &mut |_| ControlFlow::Continue(())).wait().unwrap();
        assert!(again.pair.left.rgba8 == moved.next.as_ref().unwrap().pair.left.rgba8);
        assert!(again.pair.left.rgba8 != moved.pair.left.rgba8);
        for (keys, text) in [
            (json!({}), "rig.projector.intensity"),
            (json!({"intensity": 1, "dots": 90_000}), "dots: 90000 dots in 1280x800 pixels"),
            (json!({"intensity": 1, "dots": 9, "picture": "a.png"}), "rig.projector: picture takes the place of dots"),
            (json!({"intensity": 1, "fov": 180}), "rig.projector.fov: 180"),
        ] {
            spec["rig"]["projector"] = keys;
            let message = Spec::from_json(&spec.to_string(), ".").unwrap_err().to_string();
            assert!(message.contains(text), "{message}");
        }
        spec["rig"]["projector"] = json!({"intensity": 1, "picture": "no/such.png"});
        let message = made(&mut of_spec(&spec.to_string()), &mut renderer, 0).unwrap_err().to_string();
        assert!(message.contains("no/such.png"), "{message}");
    }

    #[test]
    fn rows_of_a_rolling_shutter_show_their_own_times() {
        let mut renderer = renderer();
        let rolled = changed(&mut renderer, |spec| {
            spec["outputs"] = json!(["color", "disparity", "occlusion", "object"]);
            spec["motion"]["rolling"] = json!({"readout": 0.8, "bands": 4});
            spec["motion"]["objects"] = json!({"distance": 0});
        });
        assert!(rolled.next.is_none());
        let truth = rolled.truth.as_ref().unwrap();
        let scene = Builtin::Near.scene();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let lens = rolled.pair.pose.intrinsics().unwrap();
        for band in 0..4 {
            // The whole camera at the time of the band's middle row.
            let time = 0.8 * ((f64::from(band) + 0.5) / 4.0 - 0.5);
            let pose = rolled.pair.pose;
            let step = pose.right.as_dvec3() * (0.1 * time);
            let turn = DQuat::from_axis_angle(pose.up.as_dvec3(), -(3.0 * time).to_radians());
            let ahead = rolled.camera.target_position() - rolled.camera.eye_position();
            let eye = rolled.camera.eye_position() + step;
            let camera = rolled.camera.eye(eye).target(eye + turn * ahead);
            let whole = renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap();
            let of_whole = renderer.ground_truth(&uploaded, &scene, &whole).wait().unwrap();
            let rows = band as usize * 8 * 48..(band as usize + 1) * 8 * 48;
            for (found, whole) in [(&truth.left, &of_whole.left), (&truth.right, &of_whole.right)] {
                let pixels = || rows.clone().filter(|&pixel| found.object[pixel] == whole.object[pixel]);
                assert!(pixels().count() >= rows.len() - 4, "band {band}: {}", pixels().count());
                let same = pixels().filter(|&pixel| {
                    let [one, other] = [found, whole].map(|truth| (truth.disparity[pixel], truth.occlusion[pixel]));
                    (one.0 - other.0).abs() < 2e-3 && one.1 == other.1
                });
                assert!(same.count() >= rows.len() - 8, "band {band}");
                let formula = pixels().filter(|&pixel| found.depth[pixel].is_finite()).all(|pixel| {
                    let expected = lens.fx * f64::from(pose.interaxial) / f64::from(found.depth[pixel]);
                    (f64::from(found.disparity[pixel]) - expected).abs() < 1e-3
                });
                assert!(formula, "band {band}");
            }
        }
        let plain = changed(&mut renderer, |_| {});
        assert_ne!(rolled.pair.left.primitive, plain.pair.left.primitive);
        let still = changed(&mut renderer, |spec| {
            spec["outputs"] = json!(["color", "primitive"]);
            spec["motion"] = json!({"rolling": {"readout": 0.8, "bands": 3}});
        });
        let equal = still.pair.left.primitive.iter().zip(&plain.pair.left.primitive).filter(|(a, b)| a == b).count();
        assert!(equal >= 48 * 32 - 4, "{equal}");
        let both = changed(&mut renderer, |spec| {
            spec["outputs"] = json!(["color", "primitive"]);
            spec["motion"]["rolling"] = json!({"readout": 0.8, "bands": 4});
            spec["motion"]["shutter"] = json!({"open": 0.5, "times": 2});
        });
        assert_eq!(both.pair.left.primitive.len(), 48 * 32);
        let message = |text: &str| Spec::from_json(text, ".").unwrap_err().to_string();
        let flow = MOVING.replace(r#""objects""#, r#""rolling": {"readout": 1}, "objects""#);
        assert!(message(&flow).contains("left.flow needs a next pair: leave out motion.rolling"), "{}", message(&flow));
        let layers = flow.replace(r#""flow", "next.color""#, r#""layer_count""#);
        assert!(message(&layers).contains("layer_count is for one time: leave out motion.rolling"));
    }

    #[test]
    fn shutter_and_sensor_change_colours_alone() {
        let mut renderer = renderer();
        let plain = changed(&mut renderer, |_| {});
        let blurred = changed(&mut renderer, |spec| spec["motion"]["shutter"] = json!({"open": 0.6, "times": 4}));
        let noisy = changed(&mut renderer, |spec| spec["sensor"] = json!({"full_well": 2000, "read_noise": 6}));
        let next = |made: &MadePair| made.next.clone().unwrap();
        for other in [&blurred, &noisy] {
            for (pair, same) in [(&other.pair, &plain.pair), (&next(other).pair, &next(&plain).pair)] {
                assert_eq!((&pair.left.depth, &pair.right.primitive), (&same.left.depth, &same.right.primitive));
                assert!(pair.left.rgba8 != same.left.rgba8 && pair.right.rgba8 != same.right.rgba8);
            }
            assert_eq!(next(other).forward, next(&plain).forward);
            assert_eq!(other.record, plain.record);
        }
        // In the dark, pictures are read noise alone. Each eye and each picture has its own.
        let dark = changed(&mut renderer, |spec| {
            spec["sensor"] = json!({"full_well": 2000, "read_noise": 6});
            spec["randomise"] = json!({"exposure": -60});
        });
        let dark_next = next(&dark).pair;
        let noise = [&dark.pair.left, &dark.pair.right, &dark_next.left, &dark_next.right].map(|view| &view.linear);
        assert!((1..4).all(|other| (0..other).all(|one| noise[one] != noise[other])));
        let again = changed(&mut renderer, |spec| spec["sensor"] = json!({"full_well": 2000, "read_noise": 6}));
        assert_eq!(again.pair.left.rgba8, noisy.pair.left.rgba8);
    }

    /// While the shutter is open from a pair to the next one, its blurred picture is also that of a closed shutter at
    /// each time, taken from data sets of these times.
    #[test]
    fn a_blurred_picture_is_the_mean_of_pictures_along_the_motion() {
        let mut renderer = renderer();
        let open = |spec: &mut serde_json::Value| spec["motion"]["shutter"] = json!({"open": 1, "times": 2});
        let linear = |made: &MadePair| made.next.as_ref().unwrap().pair.left.linear.clone();
        let blurred = linear(&changed(&mut renderer, open));
        let [before, after] = [0.75, 1.25].map(|time| {
            let made = changed(&mut renderer, |spec| {
                spec["motion"]["camera"] = json!({"right": 0.1 * time, "turn": 3.0 * time});
                spec["motion"]["objects"] = json!({"distance": 0.2 * time});
                // It keeps linear light and changes it little.
                spec["sensor"] = json!({"full_well": 1e7});
            });
            linear(&made)
        });
        let mean = before.iter().zip(&after).map(|(before, after)| (before[1] + after[1]) / 2.0);
        let off = blurred.iter().zip(mean).map(|(blurred, mean)| (blurred[1] - mean).abs()).fold(0.0, f32::max);
        // The noise of 1e7 electrons is 3e-4, and the largest of 1,536 pixels about four times as far off.
        assert!(off < 2e-3, "{off}");
    }

    #[test]
    fn sizes_are_drawn_among_those_given() {
        let mut renderer = renderer();
        let spec = r#"{"pairs": 9, "size": {"choice": [[40, 30], [24, 48]]}, "scenes": [{"builtin": "near"}]}"#;
        let mut maker = of_spec(spec);
        let sizes = Vec::from_iter((0..9).map(|item| {
            let made = made(&mut maker, &mut renderer, item).unwrap();
            assert_eq!(made.pair.left.depth.len() as u32, made.pair.left.width * made.pair.left.height);
            made.camera.pose().unwrap().size
        }));
        assert!([[40, 30], [24, 48]].iter().all(|size| sizes.contains(size)), "{sizes:?}");
        assert_eq!(made(&mut of_spec(spec), &mut renderer, 5).unwrap().camera.pose().unwrap().size, sizes[5]);
        let text = maker.spec().to_json();
        assert_eq!(Spec::from_json(&text, ".").unwrap().to_json(), text);
        let message = Spec::from_json(&spec.replace("[24, 48]", "[24, 0]"), ".").unwrap_err().to_string();
        assert!(message.starts_with("size.choice[1][1]: 0 must be a whole number"), "{message}");
    }

    #[test]
    fn items_of_a_path_have_its_cameras_and_so_have_their_next_pairs() {
        let (folder, mut renderer) = (Folder::new("path"), renderer());
        let camera = |frame: u32, eye: [f32; 3], target: [f32; 3]| {
            json!({
                "frame": frame, "eye": eye, "target": target, "up": [0, 1, 0],
                "eye_separation": 0.1, "vfov_deg": 50, "screen_distance": 4,
            })
        };
        let keys = |x: f32| {
            json!([camera(0, [0.0, 1.0, 4.0], [0.0; 3]), camera(4, [x, 1.0, 4.0], [0.0, 0.5, 0.0])]).to_string()
        };
        let file = folder.write("walk.json", keys(2.0));
        let spec = |pairs: u32, motion: &str| {
            let poses = r#""poses": {"kind": "path", "file": "walk.json"}"#;
            let text = format!(
                r#"{{"pairs": {pairs}, "size": [32, 24], {poses}, "scenes": [{{"builtin": "near"}}]{motion}}}"#
            );
            Spec::from_json(&text, file.parent().unwrap())
        };
        let path = CameraPath::from_json_within(&file, 32, 24, &Limits::default()).unwrap();
        let mut maker = PairMaker::new(spec(4, r#", "motion": {}"#).unwrap());
        for item in [2, 0, 3] {
            let made = made(&mut maker, &mut renderer, item).unwrap();
            let of = |camera: StereoCamera| (camera.eye_position(), camera.target_position(), camera.up_direction());
            assert_eq!(of(made.camera), of(path.at(item as f32)));
            assert_eq!(of(made.next.unwrap().camera), of(path.at(item as f32 + 1.0)));
            assert_eq!(made.camera.pose().unwrap().interaxial, 0.1);
        }
        let hash = maker.scene_sha256(0).unwrap();
        let message = |pairs, motion| spec(pairs, motion).unwrap_err().to_string();
        assert_eq!(message(6, ""), "pairs: 6, but 'walk.json' has 5 frames");
        assert!(message(5, r#", "motion": {}"#).contains("has 5 frames, and motion needs one more"));
        assert!(
            message(2, r#", "motion": {"camera": {"up": 1}}"#).starts_with("motion.camera: the path of poses.file")
        );
        folder.write("walk.json", keys(3.0));
        assert_ne!(PairMaker::new(spec(4, r#", "motion": {}"#).unwrap()).scene_sha256(0).unwrap(), hash);
        folder.write("walk.json", "[");
        assert!(message(2, "").contains("walk.json"), "{}", message(2, ""));
    }

    #[test]
    fn shutters_and_sensors_out_of_range_are_refused_by_name() {
        let message = |key: &str, value: serde_json::Value| {
            let mut spec: serde_json::Value = serde_json::from_str(MOVING).unwrap();
            match key {
                "sensor" => spec["sensor"] = value,
                key => spec["motion"][key] = value,
            }
            Spec::from_json(&spec.to_string(), ".").unwrap_err().to_string()
        };
        assert!(message("shutter", json!({"open": 1.5})).starts_with("motion.shutter.open: 1.5 must be 0 to 1"));
        assert!(message("shutter", json!({"times": 1})).starts_with("motion.shutter.times: 1 must be a whole number"));
        assert!(message("sensor", json!({})).starts_with("sensor.full_well: it is missing"));
        assert!(message("sensor", json!({"full_well": 0})).starts_with("sensor.full_well: 0 must be 1 to 10000000"));
        let noise = json!({"full_well": 9, "read_noise": {"uniform": [-1, 2]}});
        assert!(message("sensor", noise).starts_with("sensor.read_noise.uniform[0]: -1 must be 0 to"));
    }

    #[test]
    fn a_generated_scenes_hash_covers_its_options_but_no_item() {
        let hash = |text: &str| of_spec(text).scene_sha256(0).unwrap();
        let plain = r#"{"pairs": 2, "scenes": [{"generate": "rooms"}]}"#;
        let first = hash(plain);
        assert_ne!(first, hash(r#"{"pairs": 2, "scenes": [{"generate": "outdoors"}]}"#));
        assert_ne!(first, hash(r#"{"pairs": 2, "scenes": [{"generate": {"kind": "rooms", "glass": 0.5}}]}"#));
        assert_ne!(first, hash(r#"{"pairs": 2, "scenes": [{"generate": "rooms", "sky": 0.5}]}"#));
        assert_eq!(first, hash(r#"{"pairs": 9, "seed": 4, "scenes": [{"generate": "rooms"}]}"#));
        let text = of_spec(plain).spec().to_json();
        assert_eq!(Spec::from_json(&text, ".").unwrap().to_json(), text);
        let mut other = of_spec(plain);
        other.expect_hashes(&[Some("0".repeat(64))]);
        let message = other.scene(0).err().unwrap().to_string();
        assert_eq!(message, "scenes[0]: generate:rooms: it has changed since the data set was begun");
    }

    #[test]
    fn rejected_pairs_are_drawn_again_and_recorded() {
        let mut renderer = renderer();
        // About half of the outdoor pictures show more sky than this.
        let text = r#"{"pairs": 8, "size": [64, 48],
            "scenes": [{"generate": "outdoors", "checks": {"max_sky": 0.3, "redraws": 60}}]}"#;
        let mut one = of_spec(text);
        let records: Vec<_> = (0..8).map(|item| made(&mut one, &mut renderer, item).unwrap().record).collect();
        assert!(records.iter().all(|record| record.sky_percent <= 30.0));
        let rejects: Vec<&String> = records.iter().flat_map(|record| &record.rejects).collect();
        assert!(
            !rejects.is_empty() && rejects.iter().any(|reason| reason.contains("of it is sky, over 30%")),
            "{rejects:?}"
        );
        let rejected = records.iter().position(|record| !record.rejects.is_empty()).unwrap();
        let again = made(&mut of_spec(text), &mut renderer, rejected as u32).unwrap();
        assert_eq!(again.record, records[rejected]);
        let never = r#"{"pairs": 1, "size": [64, 48],
            "scenes": [{"builtin": "near", "checks": {"max_plain": 0, "redraws": 2}}], "poses": {"kind": "fixed"}}"#;
        let message = made(&mut of_spec(never), &mut renderer, 0).unwrap_err().to_string();
        assert!(message.starts_with("scenes[0].checks: item 0 was rejected 3 times: "), "{message}");
        assert!(message.contains("of it is one object without texture, over 0%"), "{message}");
        let unchecked = never.replace(r#"{"max_plain": 0, "redraws": 2}"#, "false");
        assert!(made(&mut of_spec(&unchecked), &mut renderer, 0).unwrap().record.rejects.is_empty());
    }
}
