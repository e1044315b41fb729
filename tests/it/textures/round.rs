//! Tests textures on spheres and ellipsoids.

use std::f64::consts::{PI, TAU};

use stereotrace::{
    Ellipsoid, Material, Scene, Sphere, StereoCamera, Texture, Wrap,
    glam::{DMat3, DVec2, DVec3, Mat3, Vec3},
    testing::cpu::{Eye, Frame},
};

use super::{noise, sampled_as};

/// Returns the texture coordinates of a direction. Seen from outside, a picture's middle is at +z, its right side at +x
/// and its top at +y.
fn uv_of(outward: DVec3) -> DVec2 {
    DVec2::new(0.5 + outward.x.atan2(outward.z) / TAU, 0.5 + outward.y.clamp(-1.0, 1.0).asin() / PI)
}

/// Returns where each ray of the left view meets the mapped unit sphere, as a point of the unit sphere. Returns `None`
/// for rays that miss or graze it.
fn points(camera: &StereoCamera, axes: DMat3) -> Vec<Option<DVec3>> {
    let frame = Frame::new(&camera.pose().unwrap());
    let [width, height] = frame.size();
    let inverse = axes.inverse();
    let point = |index: usize| {
        let direction = inverse * frame.direction(Eye::Left, index % width, index / width).as_dvec3();
        let origin = inverse * frame.eye(Eye::Left).as_dvec3();
        let (a, b, c) = (direction.length_squared(), origin.dot(direction), origin.length_squared() - 1.0);
        let root = (b * b - a * c).max(0.0).sqrt();
        (root > 0.15 * a.sqrt()).then(|| origin + direction * ((-b - root) / a))
    };
    (0..width * height).map(point).collect()
}

fn views() -> Vec<StereoCamera> {
    let eyes =
        [Vec3::new(0.3, 0.2, 4.0), Vec3::new(-1.0, 0.4, -4.0), Vec3::new(0.1, 4.0, 0.2), Vec3::new(4.0, -2.0, 0.3)];
    eyes.map(|eye| StereoCamera::look_at(eye, Vec3::ZERO).screen_distance(4.0).size(160, 160).interaxial(0.0)).to_vec()
}

fn material(scene: &mut Scene, texture: &Texture) -> stereotrace::MaterialId {
    let texture = scene.add_texture(texture.clone());
    scene.add_material(Material::new(Vec3::ONE).texture(texture))
}

/// Returns the largest error. It leaves out the poles and rays that graze the surface.
fn worst(scene: &Scene, camera: &StereoCamera, axes: DMat3, texture: &Texture) -> f64 {
    let found = super::left(scene, camera);
    let points = points(camera, axes);
    let seen = points.iter().flatten().count();
    assert!(seen > found.len() / 20, "{seen}");
    let expected = |index: usize| {
        let outward = points[index]?.normalize();
        // The texture repeats around the sphere, and is clamped at the poles.
        let far = outward.x.hypot(outward.z) > 0.1;
        far.then(|| sampled_as(texture, [Wrap::Repeat, Wrap::Clamp], uv_of(outward)))
    };
    super::worst(&found, expected)
}

#[test]
fn a_sphere_s_picture_reads_from_outside_its_middle_at_z() {
    let texture = noise(8, 4, 4);
    let mut scene = Scene::new();
    let material = material(&mut scene, &texture);
    scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, material)).unwrap();
    for camera in views() {
        let error = worst(&scene, &camera, DMat3::IDENTITY, &texture);
        println!("sphere {error}");
        assert!(error < 5e-4, "{error}");
    }
}

#[test]
fn an_ellipsoid_s_picture_goes_with_its_axes() {
    let texture = noise(8, 4, 4);
    let turn = Mat3::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.7);
    for axes in [
        Mat3::from_diagonal(Vec3::new(1.0, 0.4, 0.7)),
        Mat3::from_diagonal(Vec3::new(0.5, 1.0, 0.5)),
        turn * Mat3::from_diagonal(Vec3::new(0.5, 1.0, 0.7)),
    ] {
        let mut scene = Scene::new();
        let material = material(&mut scene, &texture);
        scene.add_ellipsoid(Ellipsoid::new(Vec3::ZERO, axes, material)).unwrap();
        for camera in views() {
            let error = worst(&scene, &camera, axes.as_dmat3(), &texture);
            println!("ellipsoid {error}");
            assert!(error < 1e-3, "{axes:?}: {error}");
        }
    }
}

/// Tests a fine picture in the distance, with colours between 0.2 and 0.5 in one channel and 0 in another. Other
/// colours must not appear, not even at the seam and the poles.
#[test]
fn seams_and_poles_show_nothing_but_the_texture() {
    let pixels: Vec<[u8; 4]> =
        (0..512 * 256).map(|index: u32| [if index.is_multiple_of(3) { 124 } else { 188 }, 0, 255, 255]).collect();
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        let texture = Texture::image(512, 256, pixels.clone()).unwrap().wrap(wrap);
        let mut scene = Scene::new();
        let material = material(&mut scene, &texture);
        scene.add_sphere(Sphere::new(Vec3::new(-1.1, 0.0, 0.0), 1.0, material)).unwrap();
        scene.add_ellipsoid(Ellipsoid::aligned(Vec3::new(1.1, 0.0, 0.0), Vec3::new(0.9, 0.4, 0.8), material)).unwrap();
        for camera in views() {
            let view = super::render(&scene, &camera, stereotrace::Method::Naive).left;
            let colors = super::colors(&view.linear);
            let hits = view.primitive.iter().zip(&colors).filter(|(id, _)| **id != stereotrace::MISS);
            for (_, color) in hits {
                let between = (0.2..=0.51).contains(&color.x) && color.y == 0.0 && color.z == 1.0;
                assert!(between, "{wrap:?}: {color}");
            }
        }
    }
}
