//! Tests that every traversal and `bracket-rays` give the same picture.

use stereotrace::{
    Ellipsoid, Light, Material, Mesh, Method, Options, Scene, Sky, Sphere, StereoCamera, Texture, Wrap,
    blocking::Wait,
    glam::{Mat3, Vec2, Vec3},
};

use super::{common, noise, square};
use common::{ball, compares_bits, renderer_by, traversals};

/// Returns pictures, a checkerboard, vertex colours, highlights and emission on flat and smooth triangles, spheres and
/// ellipsoids.
pub(crate) fn everything() -> Scene {
    let mut scene = Scene::new();
    let picture = scene.add_texture(noise(64, 48, 3).wrap(Wrap::Mirror));
    let board = scene.add_texture(Texture::checkerboard(Vec3::new(0.9, 0.8, 0.1), Vec3::splat(0.1), 6).unwrap());
    let lacquer = Material::new(Vec3::new(0.6, 0.5, 0.4)).texture(picture).specular(Vec3::splat(0.6)).exponent(40.0);
    let lacquer = scene.add_material(lacquer);
    let tiles = scene.add_material(Material::new(Vec3::ONE).texture(board).specular(Vec3::splat(0.2)).exponent(5.0));
    let glow = scene.add_material(Material::new(Vec3::splat(0.3)).emission(Vec3::new(0.1, 0.3, 0.0)));
    let ground = [(-6.0, 4.0), (6.0, 4.0), (6.0, -14.0), (-6.0, -14.0)].map(|(x, z)| Vec3::new(x, -1.0, z));
    let uv = [Vec2::ZERO, 3.0 * Vec2::X, 3.0 * Vec2::ONE, 3.0 * Vec2::Y];
    let ground = Mesh::new(ground.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
        .uv(vec![[uv[0], uv[1], uv[2]], [uv[0], uv[2], uv[3]]])
        .materials(vec![tiles; 2]);
    scene.add_mesh(&ground).unwrap();
    let mut wall = square(Vec2::NEG_ONE, 2.0 * Vec2::ONE);
    wall.positions.iter_mut().for_each(|point| *point = *point * 1.5 - 2.0 * Vec3::Z);
    scene.add_mesh(&wall.materials(vec![lacquer; 2])).unwrap();
    let painted = ball(Vec3::new(-0.9, -0.3, 0.4), 0.6, 12).smooth(60.0).unwrap();
    let color = |corner: u32| (painted.positions[corner as usize] * 0.5 + 0.5).clamp(Vec3::ZERO, Vec3::ONE);
    let colors = painted.triangles.iter().map(|corners| corners.map(color)).collect();
    let count = painted.triangles.len();
    scene.add_mesh(&painted.colors(colors).materials(vec![glow; count])).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(0.6, -0.4, 0.8), 0.5, lacquer)).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(0.3, 0.8, -0.5), 0.4, tiles)).unwrap();
    scene.ambient = Some(Vec3::splat(0.1));
    scene.sky = Sky::Gradient { nadir: Vec3::splat(0.2), zenith: Vec3::new(0.2, 0.4, 0.9) };
    scene.lights = [Vec3::new(3.0, 5.0, 4.0), Vec3::new(-4.0, 3.0, 2.0)]
        .map(|position| Light::point(position, Vec3::splat(0.4)))
        .to_vec();
    scene
}

fn with_ellipsoids(mut scene: Scene) -> Scene {
    let [lacquer, tiles] = [1, 2].map(stereotrace::MaterialId);
    let turn = Mat3::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.7);
    let flat = turn * Mat3::from_diagonal(Vec3::new(0.7, 0.2, 0.5));
    scene.add_ellipsoid(Ellipsoid::new(Vec3::new(1.3, 0.5, 0.0), flat, lacquer)).unwrap();
    scene.add_ellipsoid(Ellipsoid::aligned(Vec3::new(-0.8, 0.8, 0.2), Vec3::new(0.3, 0.5, 0.3), tiles)).unwrap();
    scene
}

#[test]
fn textured_scenes_look_alike_by_every_traversal_and_by_bracket() {
    let camera = StereoCamera::look_at(Vec3::new(0.2, 0.5, 5.0), Vec3::ZERO)
        .screen_distance(4.5)
        .size(93, 70)
        .interaxial_pixels(7.0);
    for (name, scene) in [("spheres", everything()), ("ellipsoids", with_ellipsoids(everything()))] {
        let mut first = None;
        for traversal in traversals() {
            let mut renderer = renderer_by(traversal);
            if !compares_bits(&renderer) {
                return;
            }
            let uploaded = renderer.upload(&scene).wait().unwrap();
            let mut shown = |method| {
                let pair = renderer
                    .pair(&uploaded, &camera)
                    .options(&Options::new(method).linear(true))
                    .read()
                    .wait()
                    .unwrap();
                assert!(
                    pair.left.linear.iter().flatten().all(|value| value.is_finite()),
                    "{name} {method} {traversal}"
                );
                (pair.left, pair.right)
            };
            let naive = shown(Method::Naive);
            assert!(shown(Method::BRACKET_RAYS) == naive, "{name} {traversal}: bracket-rays");
            let first = first.get_or_insert_with(|| naive.clone());
            assert!(naive == *first, "{name} {traversal}");
        }
    }
}
