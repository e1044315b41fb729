use super::*;
use crate::dataset::spec::Spec;

fn options(text: &str) -> Spec {
    Spec::from_json(&format!(r#"{{"pairs": 1, "scenes": [{{"generate": {text}}}]}}"#), ".").unwrap()
}

fn made(spec: &Spec, item: u32, attempt: u32) -> Generated {
    let options = spec.generator(0).unwrap();
    let assets = Assets::open(spec, options).unwrap();
    generate(options, &assets, &Draws { seed: 3, item, attempt }).unwrap()
}

/// Objects may touch these, which are surfaces to stand on or to hang at, or many small parts on the ground.
const BACKGROUND: [&str; 13] = [
    "floor",
    "ceiling",
    "wall",
    "skirting",
    "window frame",
    "window pane",
    "curtain",
    "door",
    "rug",
    "ground",
    "road",
    "grass",
    "grove",
];

/// Returns the objects of a scene that must not overlap, made anew from the scene's triangles.
fn solids(scene: &Scene) -> Vec<(String, Solid)> {
    let mut forms: Vec<Form> = Vec::new();
    forms.resize_with(scene.object_count(), Form::default);
    for (index, triangle) in scene.triangles().iter().enumerate() {
        let form = &mut forms[scene.object_of(index as u32) as usize];
        let corners = triangle.corners.map(|corner| {
            form.positions.push(corner);
            form.positions.len() as u32 - 1
        });
        let (normals, uv) = ([Vec3::ZERO; 3], [glam::Vec2::ZERO; 3]);
        form.faces.push(form::Face { corners, normals, uv, slot: 0 });
    }
    let name = |object: usize| scene.object_name(object as u32).to_owned();
    let all = forms.iter().enumerate().filter(|(_, form)| !form.faces.is_empty());
    let named = all.map(|(object, form)| (name(object), Solid::of(form, &Affine3A::IDENTITY)));
    named.filter(|(name, _)| !BACKGROUND.contains(&name.as_str())).collect()
}

#[test]
fn every_kind_gives_valid_scenes_whose_objects_do_not_overlap() {
    for (kind, fewest) in [("rooms", 15), ("floating", 8), ("outdoors", 12)] {
        let spec = options(&format!("\"{kind}\""));
        for item in 0..100 {
            let Generated { scene, views, camera, can_move } = made(&spec, item, 0);
            assert_eq!(can_move.len(), scene.object_count(), "{kind} {item}");
            for (object, can_move) in (0..).zip(can_move) {
                let name = scene.object_name(object);
                assert_eq!(can_move, !BACKGROUND.contains(&name), "{kind} {item}: {name}");
            }
            scene.check().unwrap_or_else(|error| panic!("{kind} {item}: {error}"));
            assert!((2_000..140_000).contains(&scene.triangles().len()), "{kind} {item}: {}", scene.triangles().len());
            assert!((fewest..700).contains(&scene.object_count()), "{kind} {item}: {}", scene.object_count());
            assert!(scene.textures().len() < 40, "{kind} {item}: {}", scene.textures().len());
            assert!(!scene.lights.is_empty() && camera.pose().is_ok(), "{kind} {item}");
            assert!(views.len() <= VIEWS && (item > 20 || !views.is_empty()), "{kind} {item}: {}", views.len());
            let finite = |at: Vec3| at.is_finite() && at.abs().max_element() < 500.0;
            assert!(scene.triangles().iter().all(|triangle| triangle.corners.into_iter().all(finite)), "{kind} {item}");
            assert_eq!(scene.degenerate_count(), 0, "{kind} {item}");
            if item < 12 {
                assert_apart(&solids(&scene), kind, item);
            }
        }
    }
}

fn assert_apart(solids: &[(String, Solid)], kind: &str, item: u32) {
    for (index, (name, solid)) in solids.iter().enumerate() {
        for (other_name, other) in &solids[..index] {
            assert!(!solid.overlaps(other), "{kind} {item}: {name} and {other_name}");
        }
    }
}

#[test]
fn a_scene_depends_on_seed_item_and_attempt_only() {
    for kind in ["rooms", "floating", "outdoors"] {
        let spec = options(&format!("\"{kind}\""));
        let hash = |item, attempt| made(&spec, item, attempt).scene.sha256();
        let first = hash(5, 0);
        assert_ne!(first, hash(6, 0), "{kind}");
        assert_ne!(first, hash(5, 1), "{kind}");
        assert_eq!(first, hash(5, 0), "{kind}");
    }
}

#[test]
fn shares_and_counts_are_those_of_the_spec() {
    let count = |text: &str, is_kind: fn(&Material) -> bool| {
        made(&options(text), 2, 0).scene.materials().iter().filter(|material| is_kind(material)).count()
    };
    let is_glass: fn(&Material) -> bool = |material| matches!(material.finish, crate::Finish::Glass { .. });
    assert_eq!(count(r#"{"kind": "floating", "glass": 0}"#, is_glass), 0);
    assert!(count(r#"{"kind": "floating", "glass": 1, "mirrors": 0}"#, is_glass) > 5);
    let is_textured: fn(&Material) -> bool = |material| material.texture.is_some();
    let [some, none] =
        ["0", "1"].map(|plain| count(&format!(r#"{{"kind": "rooms", "plain": {plain}, "metals": 0}}"#), is_textured));
    // Posters, leaves, books and the like keep their pictures.
    assert!(some > 12 && none < some / 2, "{some} {none}");
    let objects = |count: u32| {
        let spec = options(&format!(r#"{{"kind": "floating", "objects": {count}}}"#));
        made(&spec, 2, 0).scene.object_count()
    };
    let background = objects(0);
    assert!((1..=21).contains(&background), "{background}");
    assert!((background + 4..=background + 8).contains(&objects(8)), "{}", objects(8));
}
