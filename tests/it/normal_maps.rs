//! Tests normal textures against closed forms of tilted floors, and coarse balls against fine ones.

use crate::common::renderer;
use stereotrace::{
    Light, Lighting, Material, Mesh, Method, Options, Principled, Renderer, Scene, Sky, StereoCamera, Texture,
    TextureId,
    blocking::Wait,
    glam::{Affine3A, Quat, Vec2, Vec3, Vec4},
};

/// Tilt of the textures' normals in x and y.
const TILT: [f32; 2] = [0.45, 0.25];

/// Returns the scene's texture of one tilted normal.
fn tilted(scene: &mut Scene) -> TextureId {
    let z = (1.0 - TILT[0] * TILT[0] - TILT[1] * TILT[1]).sqrt();
    let byte = |value: f32| (127.5 * (value + 1.0)).round() as u8;
    let pixel = [byte(TILT[0]), byte(TILT[1]), byte(z), 255];
    scene.add_texture(Texture::image(1, 1, vec![pixel]).unwrap().data(true))
}

/// Returns a surface that reflects light diffusely only.
fn matte(scene: &mut Scene) -> Material {
    let mut surface = Principled::new(Vec3::splat(0.8), 0.0, 1.0);
    (surface.specular, surface.grazing, surface.normal_texture) = (Vec3::ZERO, 0.0, Some(tilted(scene)));
    Material::new(Vec3::ZERO).principled(surface)
}

fn options() -> Options {
    Options::new(Method::Naive).linear(true).lighting(Lighting::Paths { bounces: 0, samples: 1 })
}

/// Returns the green of the picture's middle.
fn middle(renderer: &mut Renderer, scene: &Scene, camera: &StereoCamera) -> f32 {
    let uploaded = renderer.upload(scene).wait().unwrap();
    let pair = renderer.pair(&uploaded, camera).options(&options()).read().wait().unwrap();
    pair.left.linear[pair.left.linear.len() / 2][1]
}

/// Returns a floor whose u and v grow along these vectors, lit by the sun from `sun`.
fn floor(along_u: Vec3, along_v: Vec3, sun: Vec3) -> Scene {
    let mut scene = Scene::new();
    let material = matte(&mut scene);
    let material = scene.add_material(material);
    let corners = vec![-Vec3::X - Vec3::Z, -Vec3::X + Vec3::Z, Vec3::X + Vec3::Z, Vec3::X - Vec3::Z];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let place = |corner: u32| Vec2::new(along_u.dot(corners[corner as usize]), along_v.dot(corners[corner as usize]));
    let uv = triangles.iter().map(|triangle: &[u32; 3]| triangle.map(place)).collect();
    scene.add_mesh(&Mesh::new(corners, triangles).uv(uv).materials(vec![material])).unwrap();
    scene.lights = vec![Light::directional(sun, 0.0, Vec3::ONE)];
    scene.sky = Sky::Constant(Vec3::ZERO);
    scene
}

#[test]
fn a_floor_is_lit_as_its_tilted_normals_say() {
    let mut renderer = renderer();
    let camera = StereoCamera::look_at(Vec3::new(0.1, 3.0, 0.2), Vec3::new(0.1, 0.0, 0.2)).up(Vec3::NEG_Z);
    let camera = camera.size(3, 3).vertical_fov_degrees(5.0).interaxial(0.0);
    let sun = Vec3::new(0.5, 0.8, -0.3).normalize();
    let turn = Quat::from_rotation_y(0.8);
    for (along_u, along_v) in [
        (Vec3::X, Vec3::NEG_Z),
        (Vec3::NEG_X, Vec3::Z),
        (Vec3::X, Vec3::Z),
        (Vec3::Z, Vec3::X),
        (turn * Vec3::X, turn * Vec3::NEG_Z),
        (turn * Vec3::NEG_X, turn * Vec3::NEG_Z),
    ] {
        let tilt = along_u * TILT[0] + along_v * TILT[1];
        let normal = (tilt + Vec3::Y * (1.0 - tilt.length_squared()).sqrt()).normalize();
        let expected = 0.8 * normal.dot(sun);
        let mut scene = floor(along_u, along_v, sun);
        assert_eq!(scene.tangents().len(), 2);
        let found = middle(&mut renderer, &scene, &camera);
        assert!((found - expected).abs() < 0.01, "{along_u} {along_v}: {found} is not {expected}");
        // Without tangents, those of the triangles' texture coordinates are used.
        let mut bare = Scene::new();
        let material = matte(&mut bare);
        bare.add_material(Material::new(Vec3::ZERO));
        let corners = scene.triangles().iter().flat_map(|triangle| triangle.corners).collect();
        let mesh = Mesh::new(corners, vec![[0, 1, 2], [3, 4, 5]]).uv(scene.uv().to_vec());
        bare.add_mesh(&mesh.materials(vec![stereotrace::MaterialId(1)])).unwrap();
        bare.set_material(stereotrace::MaterialId(1), material).unwrap();
        (bare.lights, bare.sky) = (scene.lights.clone(), scene.sky.clone());
        assert!(bare.tangents().is_empty());
        let found = middle(&mut renderer, &bare, &camera);
        assert!((found - expected).abs() < 0.01, "{along_u} {along_v}, no tangents: {found} is not {expected}");
        // The floor and its tangents turn together. A mirrored floor shows its inner side, with reversed normals.
        for (transform, is_turn) in
            [(Affine3A::from_quat(turn), true), (Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)), false)]
        {
            scene.transform_object(0, &transform).unwrap();
            let moved = transform.transform_vector3(normal);
            let normal = if is_turn { moved } else { Vec3::new(-moved.x, moved.y, -moved.z) };
            let expected = 0.8 * normal.dot(sun);
            let found = middle(&mut renderer, &scene, &camera);
            assert!((found - expected).abs() < 0.01, "turned {is_turn}: {found} is not {expected}");
            scene.transform_object(0, &transform.inverse()).unwrap();
        }
    }
}

/// Returns a ball of rings with smooth normals and a tilted normal everywhere.
fn ball(rings: u32) -> Scene {
    let mut scene = Scene::new();
    let material = matte(&mut scene);
    let material = scene.add_material(material);
    let columns = 2 * rings;
    let at = |row: u32, column: u32| {
        let (down, around) = (row as f32 / rings as f32, column as f32 / columns as f32);
        let (polar, turn) = (std::f32::consts::PI * down, std::f32::consts::TAU * around);
        let normal = Vec3::new(polar.sin() * turn.sin(), polar.cos(), polar.sin() * turn.cos());
        // The direction of u turns along the ball.
        (normal, Vec2::new(around, 1.0 - down + 0.1 * (3.0 * turn).sin()))
    };
    let (mut positions, mut triangles, mut normals, mut uv) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for row in 0..rings {
        for column in 0..columns {
            let corners = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                let first = positions.len() as u32;
                positions.extend([a, b, c].map(|corner: usize| corners[corner].0));
                triangles.push([first, first + 1, first + 2]);
                normals.push([a, b, c].map(|corner| corners[corner].0));
                uv.push([a, b, c].map(|corner| corners[corner].1));
            }
        }
    }
    scene.add_mesh(&Mesh::new(positions, triangles).normals(normals).uv(uv).materials(vec![material])).unwrap();
    scene.lights = vec![Light::directional(Vec3::new(0.4, 0.5, 1.0), 0.0, Vec3::ONE)];
    scene.sky = Sky::Constant(Vec3::ZERO);
    scene
}

/// Tests that tangents are smooth across triangles: a coarse ball is lit like a fine one. The measured error is 0.025,
/// and 0.038 with the tangents of each triangle's own texture coordinates.
#[test]
fn coarse_balls_are_lit_like_fine_ones() {
    let mut renderer = renderer();
    let camera = StereoCamera::look_at(Vec3::new(0.0, 4.0, 4.5), Vec3::ZERO).size(64, 64).vertical_fov_degrees(22.0);
    let picture = |scene: &Scene, renderer: &mut Renderer| {
        let uploaded = renderer.upload(scene).wait().unwrap();
        renderer.pair(&uploaded, &camera.interaxial(0.0)).options(&options()).read().wait().unwrap().left
    };
    let fine = picture(&ball(96), &mut renderer);
    let coarse = picture(&ball(10), &mut renderer);
    let mut flat = ball(10);
    let triangles = flat.triangles().to_vec();
    let corners = (0..triangles.len() as u32).map(|one| [3 * one, 3 * one + 1, 3 * one + 2]).collect();
    let bare = Mesh::new(triangles.iter().flat_map(|one| one.corners).collect(), corners);
    let bare = bare.normals(triangles.iter().map(|one| one.normals).collect()).uv(flat.uv().to_vec());
    let bare = bare.materials(vec![triangles[0].material]).tangents(vec![[Vec4::ZERO; 3]; triangles.len()]);
    flat.set_mesh(0, &bare).unwrap();
    let flat = picture(&flat, &mut renderer);
    let error = |view: &stereotrace::View| {
        // Away from the rim, where the coarse ball's outline differs.
        let is_inner =
            |index: usize| [index % 64, index / 64].iter().map(|at| at.abs_diff(32).pow(2)).sum::<usize>() < 400;
        let inner = (0..view.linear.len()).filter(|index| is_inner(*index));
        let squares = inner.map(|index| f64::from(view.linear[index][1] - fine.linear[index][1]).powi(2));
        (squares.sum::<f64>() / 1257.0).sqrt()
    };
    let errors = [error(&coarse), error(&flat)];
    assert!(errors[0] < 0.03 && errors[1] > 1.3 * errors[0], "{errors:?}");
}

/// Tests that a clear coat reflects by the surface's own normal. The tilted base is black.
#[test]
fn clear_coats_stay_smooth() {
    let mut renderer = renderer();
    let mut scene = floor(Vec3::X, Vec3::NEG_Z, Vec3::Y);
    let mut material = scene.materials()[1].clone();
    let mut surface = material.principled.unwrap().clearcoat(1.0, 0.0);
    surface.base = Vec3::ZERO;
    material.principled = Some(surface);
    scene.set_material(stereotrace::MaterialId(1), material).unwrap();
    scene.lights.clear();
    scene.sky = Sky::Gradient { nadir: Vec3::ZERO, zenith: Vec3::ONE };
    let camera = StereoCamera::look_at(Vec3::new(0.1, 3.0, 0.2), Vec3::new(0.1, 0.0, 0.2)).up(Vec3::NEG_Z);
    let found = middle(&mut renderer, &scene, &camera.size(3, 3).vertical_fov_degrees(5.0).interaxial(0.0));
    // A normal tilted by 31 degrees would mirror the sky 62 degrees from the zenith, which is a third darker.
    assert!((found - 0.04).abs() < 1e-3, "{found}");
}
