//! Tests extreme texture coordinates and textures.

use stereotrace::{
    Mesh, Texture, Wrap,
    glam::{Affine3A, Vec2, Vec3},
};

use super::{before, left, noise, square, textured};

/// Checks that all colours are finite and from 0 to 1.
fn assert_sound(mesh: Mesh, texture: Texture, what: &str) {
    let found = left(&textured(mesh, texture), &before(64));
    let outside = found.iter().filter(|color| !(color.min_element() >= 0.0 && color.max_element() <= 1.0)).count();
    assert_eq!(outside, 0, "{what}: {:?}", found.iter().find(|color| !color.is_finite()));
}

/// Returns textures whose decoded colours are all from 0.2 to 0.8, so that values beyond them show.
fn textures() -> Vec<(String, Texture)> {
    let mut textures = Vec::new();
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        for (width, height) in [(1, 1), (1, 8192), (8192, 1), (3, 5)] {
            textures.push((format!("{width}x{height} {wrap:?}"), noise(width, height, 9).wrap(wrap)));
        }
        for squares in [1, 8192] {
            let board = Texture::checkerboard(Vec3::splat(0.8), Vec3::splat(0.2), squares).unwrap().wrap(wrap);
            textures.push((format!("{squares} squares {wrap:?}"), board));
        }
    }
    textures
}

#[test]
fn colours_are_some_whatever_the_texture_and_its_coordinates() {
    for (name, texture) in textures() {
        let ranges = [(0.0, 0.0), (0.3, 0.3), (0.0, 1.0), (1e6, 1e6 + 1.0), (-1e6, 1e6), (-3e38, 3e38), (0.0, 1e-30)];
        for (low, high) in ranges {
            let mesh = square(Vec2::splat(low), Vec2::splat(high));
            assert_sound(mesh, texture.clone(), &format!("{name}, {low} to {high}"));
        }
    }
}

#[test]
fn tiny_and_thin_triangles_have_colours_of_their_texture() {
    // If the corner weights are rounding errors alone, colours are still between the corners' colours.
    for (size, eye) in [(1e-6, 4.0), (1e-3, 4.0), (1e-6, 1e-3)] {
        for (width, height) in [(1.0, 1.0), (1.0, 1e-3)] {
            let mut mesh = Mesh::new(Vec::new(), Vec::new());
            for index in 0..400 {
                let at = Vec3::new((index % 20) as f32 - 9.5, (index / 20) as f32 - 9.5, 0.0) * size;
                let map = Affine3A::from_translation(at) * Affine3A::from_scale(Vec3::new(width, height, 1.0) * size);
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(square(Vec2::ZERO, Vec2::ONE).positions.iter().map(|p| map.transform_point3(*p)));
                mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            }
            let count = mesh.triangles.len();
            let corners = [Vec3::new(0.2, 0.5, 0.8), Vec3::new(0.8, 0.5, 0.2), Vec3::new(0.4, 0.5, 0.6)];
            let mut scene = stereotrace::Scene::new();
            scene.add_material(stereotrace::Material::new(Vec3::ONE));
            let mesh = mesh.colors(vec![corners; count]).materials(vec![stereotrace::MaterialId(1); count]);
            scene.add_mesh(&mesh).unwrap();
            let camera = stereotrace::StereoCamera::look_at(Vec3::new(0.0, eye * 0.3, eye), Vec3::ZERO)
                .screen_distance(eye)
                .screen_width(25.0 * size)
                .size(64, 64)
                .interaxial(0.0);
            let Ok(_) = camera.pose() else { continue };
            let found = super::render(&scene, &camera, stereotrace::Method::Naive).left;
            let colors = super::colors(&found.linear);
            let hits = found.primitive.iter().zip(&colors).filter(|(id, _)| **id != stereotrace::MISS);
            for (_, color) in hits {
                let between =
                    color.min_element() > 0.199 && color.max_element() < 0.801 && (color.y - 0.5).abs() < 1e-3;
                assert!(between, "size {size}, eye {eye}, {width}x{height}: {color}");
            }
        }
    }
}
