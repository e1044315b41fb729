//! Tests that a changed textured scene looks like the same scene uploaded anew.

use stereotrace::{
    BvhBuild, Material, MaterialId, Mesh, Method, Options, Scene, StereoCamera, Texture, TextureId, Update,
    blocking::Wait,
    glam::{Affine3A, Vec3},
};

use super::{common::renderer, four_colors, noise, twins::everything};

type Change = (&'static str, fn(&mut Scene));

const CHANGES: &[Change] = &[
    ("a material's colour", |scene| {
        let mut changed = scene.materials()[1].clone();
        changed.albedo = Vec3::X;
        scene.set_material(MaterialId(1), changed).unwrap();
    }),
    ("another texture", |scene| {
        let changed = scene.materials()[1].clone().texture(TextureId(1));
        scene.set_material(MaterialId(1), changed).unwrap();
    }),
    ("a new texture", |scene| {
        let texture = scene.add_texture(four_colors());
        let changed = scene.materials()[2].clone().texture(texture);
        scene.set_material(MaterialId(2), changed).unwrap();
    }),
    ("a larger one, and a material more", |scene| {
        let texture = scene.add_texture(noise(300, 200, 8));
        let material = scene.add_material(Material::new(Vec3::ONE).texture(texture).exponent(3.0));
        let changed = scene.materials()[material.0 as usize].clone();
        scene.set_material(MaterialId(1), changed).unwrap();
    }),
    ("a light more", |scene| scene.lights.push(stereotrace::Light::point(Vec3::Y * 3.0, Vec3::splat(0.2)))),
    ("something moves", |scene| {
        scene.transform_object(1, &Affine3A::from_translation(Vec3::new(0.2, 0.1, 0.3))).unwrap();
    }),
    ("no highlights and no emission", |scene| {
        for index in 0..scene.materials().len() {
            let changed = scene.materials()[index].clone().specular(Vec3::ZERO).emission(Vec3::ZERO);
            scene.set_material(MaterialId(index as u32), changed).unwrap();
        }
    }),
    ("no colours of vertices", |scene| {
        let corners = scene.triangles()[4..].iter().flat_map(|triangle| triangle.corners).collect::<Vec<_>>();
        let faces = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        scene.set_mesh(2, &Mesh::new(corners, faces)).unwrap();
        assert!(scene.colors().is_empty());
    }),
    ("no textures", |scene| {
        for index in 0..scene.materials().len() {
            let mut changed = scene.materials()[index].clone();
            changed.texture = None;
            scene.set_material(MaterialId(index as u32), changed).unwrap();
        }
    }),
    ("a board again", |scene| {
        let texture = scene.add_texture(Texture::checkerboard(Vec3::X, Vec3::Y, 5).unwrap());
        let changed = Material::new(Vec3::ONE).texture(texture).specular(Vec3::ONE);
        scene.set_material(MaterialId(2), changed).unwrap();
    }),
];

#[test]
fn whatever_changes_of_its_materials_a_scene_looks_as_uploaded_anew() {
    let camera = StereoCamera::look_at(Vec3::new(0.0, 0.5, 5.0), Vec3::ZERO).size(50, 37).interaxial_pixels(6.0);
    let mut renderer = renderer();
    let mut scene = everything();
    let hows = [Update::Refit, Update::Rebuild(BvhBuild::Fast)];
    let mut states = hows.map(|how| (how, renderer.upload(&scene).wait().unwrap()));
    for (name, change) in CHANGES {
        change(&mut scene);
        let new = renderer.upload(&scene).wait().unwrap();
        for method in [Method::Naive, Method::BRACKET] {
            let options = Options::new(method).linear(true);
            let expected = renderer.pair(&new, &camera).options(&options).read().wait().unwrap();
            for (how, uploaded) in &mut states {
                renderer.update(uploaded, &scene, *how).wait().unwrap();
                let found = renderer.pair(uploaded, &camera).options(&options).read().wait().unwrap();
                assert!(found.left == expected.left && found.right == expected.right, "{name}, {how:?}, {method}");
            }
        }
    }
}
