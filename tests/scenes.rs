//! Real meshes, where they have been unpacked: against obvhs's own traversal, and by their triangle counts.

mod common;

use std::{io::Write, path::PathBuf};

use common::{is_exact, renderer};
use obvhs::{BvhBuildParams, aabb::Aabb, bvh2::builder::build_bvh2, ray::Ray, ray::RayHit};
use stereotrace::{
    FAR, Method, Options, Scene, StereoCamera,
    cpu::{Eye, Frame, intersect::intersect_triangle},
};

/// The folder of unpacked scenes with this one in it, or a word on how to get it.
fn find(name: &str) -> Option<PathBuf> {
    let fallback = || concat!(env!("CARGO_MANIFEST_DIR"), "/target/scenes").into();
    let folder: PathBuf = std::env::var_os("STEREOTRACE_SCENES").map_or_else(fallback, PathBuf::from);
    if folder.join(name).join(format!("{name}.obj")).is_file() {
        return Some(folder);
    }
    // Not through println: the test harness would keep it to itself.
    let folder = folder.display();
    let _ = writeln!(
        std::io::stderr(),
        "skipped: scene not found, run with {name}/{name}.obj and cameras.json under {folder}"
    );
    None
}

fn check(name: &str, triangles: usize) {
    let Some(folder) = find(name) else { return };
    let scene = Scene::from_obj(folder.join(name).join(format!("{name}.obj"))).unwrap();
    assert_eq!(scene.primitive_count(), triangles);
    let camera = StereoCamera::from_json(folder.join("cameras.json"), name, 201, 151).unwrap();
    let pair = {
        let mut renderer = renderer();
        let uploaded = renderer.upload(&scene).unwrap();
        let pair = renderer.render(&uploaded, &camera, &Options::new(Method::Naive)).unwrap();
        if !is_exact(&renderer) {
            println!("skipped: bit-exact comparison on an adapter that may contract f32");
            return;
        }
        pair
    };

    // obvhs's tree and traversal, with our triangle test as its closure. Its box test has no margin, so now and then it
    // loses a hit at a box's very edge.
    let boxes: Vec<Aabb> = scene
        .triangles()
        .iter()
        .map(|t| {
            Aabb::new(
                t.corners[0].min(t.corners[1]).min(t.corners[2]).into(),
                t.corners[0].max(t.corners[1]).max(t.corners[2]).into(),
            )
        })
        .collect();
    let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut std::time::Duration::default());
    let frame = Frame::new(&pair.pose);
    let [width, height] = frame.size();
    let (mut lost, mut hits) = (0, 0);
    for (eye, view) in [(Eye::Left, &pair.left), (Eye::Right, &pair.right)] {
        for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
            let (origin, direction) = (frame.eye(eye), frame.direction(eye, column, row));
            let ray = Ray::new(origin.into(), direction.into(), 0.0, FAR);
            let mut hit = RayHit::none();
            tree.ray_traverse(ray, &mut hit, |_, index| {
                let triangle = &scene.triangles()[tree.primitive_indices[index] as usize];
                let t = (!triangle.is_degenerate()).then(|| intersect_triangle(origin, direction, triangle.corners));
                t.flatten().filter(|t| *t >= 0.0).unwrap_or(f32::INFINITY)
            });
            let found = view.depth[row * width + column].min(FAR);
            let theirs = hit.t.min(FAR); // infinite where the ray misses the whole tree, else its t_max
            assert!(found <= theirs, "({column}, {row}): obvhs hits at {theirs}, the kernel at {found}");
            lost += usize::from(found < theirs);
            hits += usize::from(found < FAR);
        }
    }
    // Measured 0 of 60,702 rays on sponza_4x and dragon.
    assert!(lost <= 6, "{lost} of {} rays differ from obvhs's", 2 * width * height);
    assert!(hits > width * height / 2, "{hits}");
}

#[test]
fn sponza_is_hit_as_by_obvhs() {
    check("sponza_4x", 265_816);
}

#[test]
fn the_dragon_is_hit_as_by_obvhs() {
    check("dragon", 871_414);
}
