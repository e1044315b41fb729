//! Tests infinite planes: hits and light against double precision, pictures against closed forms, methods against
//! `Naive` of the same run.

mod changes;
use crate::common;
mod hits;
mod looks;
mod methods;
mod shadows;
use crate::truth;

use common::{ball, random::Random, random_ellipsoid};
use stereotrace::{
    Ellipsoid, Light, Material, MaterialId, Plane, Scene, Sky, Sphere, StereoCamera,
    glam::{Quat, Vec3},
};

/// Objects on a ground.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Things {
    Nothing,
    Spheres,
    Mesh,
    Ellipsoids,
    All,
}

const THINGS: [Things; 5] = [Things::Nothing, Things::Spheres, Things::Mesh, Things::Ellipsoids, Things::All];

/// Returns a rotation from the level world to one in which no normal is along an axis.
fn tilt() -> Quat {
    Quat::from_axis_angle(Vec3::new(1.0, 0.2, 0.3).normalize(), 0.5)
}

/// Returns objects on a ground under two lamps, all rotated by `turn`. The point that defines the ground's plane is far
/// away.
fn stage(things: Things, turn: Quat) -> Scene {
    let mut scene = Scene::new();
    let red = scene.add_material(Material::new(Vec3::new(0.7, 0.2, 0.1)));
    if matches!(things, Things::Mesh | Things::All) {
        let mut mesh = ball(Vec3::new(-1.2, 0.7, 0.2), 0.8, 9).materials(vec![red]);
        mesh.positions.iter_mut().for_each(|position| *position = turn * *position);
        scene.add_mesh(&mesh).unwrap();
    }
    if matches!(things, Things::Spheres | Things::All) {
        for (x, y, z, radius) in [(0.0, 0.6, 0.0, 0.6), (1.1, 0.35, 0.6, 0.35), (0.9, 1.4, -2.0, 0.7)] {
            scene.add_sphere(Sphere::new(turn * Vec3::new(x, y, z), radius, red)).unwrap();
        }
    }
    if matches!(things, Things::Ellipsoids | Things::All) {
        let mut random = Random::new(5);
        for index in 0..6 {
            let one = random_ellipsoid(&mut random, index % 2 == 1, 0.5);
            scene.add_ellipsoid(Ellipsoid::new(turn * (one.center + 0.7 * Vec3::Y), one.axes, red)).unwrap();
        }
    }
    let aside = turn * Vec3::new(3000.0, 0.0, -2000.0);
    scene.add_plane(Plane::new(aside, 2.0 * (turn * Vec3::Y), MaterialId(0))).unwrap();
    scene.ambient = Some(Vec3::splat(0.1));
    scene.sky = Sky::Constant(Vec3::new(0.2, 0.4, 0.9));
    let lamps = [Vec3::new(2.0, 5.0, 3.0), Vec3::new(-4.0, 3.0, 1.0)];
    scene.lights = lamps.map(|lamp| Light::point(turn * lamp, Vec3::splat(0.4))).to_vec();
    scene
}

/// Returns a camera with the horizon in the picture.
fn camera(turn: Quat) -> StereoCamera {
    StereoCamera::look_at(turn * Vec3::new(0.7, 1.2, 5.3), turn * Vec3::new(0.0, 0.7, 0.0))
        .up(turn * Vec3::Y)
        .screen_distance(5.0)
        .size(93, 62)
        .interaxial_pixels(7.0)
}
