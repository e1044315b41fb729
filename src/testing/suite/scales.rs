//! Sizes and positions with large rounding errors in f32.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::on_sphere;
use crate::{
    StereoCamera,
    random::Random,
    scene::{
        Scene, Sky, Sphere,
        builtin::{
            add, lamp, paint,
            shapes::{Shading, Shape},
            stage::{self, EYE, SCREEN, stage},
        },
    },
};

/// Scale and position of a copy of the composition.
pub(super) struct Placement {
    scale: f32,
    offset: Vec3,
}

pub(super) const SMALL: Placement = Placement { scale: 1e-3, offset: Vec3::ZERO };
pub(super) const LARGE: Placement = Placement { scale: 1e6, offset: Vec3::ZERO };
pub(super) const FAR_OFF: Placement = Placement { scale: 1.0, offset: Vec3::splat(1e5) };

impl Placement {
    fn of(&self, point: Vec3) -> Vec3 {
        point * self.scale + self.offset
    }

    pub(super) fn scene(&self) -> Scene {
        let mut scene = composition();
        for triangle in &mut scene.triangles {
            triangle.corners = triangle.corners.map(|corner| self.of(corner));
        }
        for sphere in &mut scene.spheres {
            (sphere.center, sphere.radius) = (self.of(sphere.center), sphere.radius * self.scale);
        }
        for light in &mut scene.lights {
            light.position = self.of(light.position.as_vec3()).as_dvec3();
        }
        scene
    }

    pub(super) fn camera(&self) -> StereoCamera {
        let eye = self.of(EYE);
        StereoCamera::look_at(eye, eye - Vec3::Z * (SCREEN * self.scale))
            .screen_distance(SCREEN * self.scale)
            .screen_width(stage::WIDTH * SCREEN * self.scale)
    }
}

/// Builds floor, wall, a sphere of triangles, spheres and a box.
fn composition() -> Scene {
    let mut scene = stage();
    let [ball_color, box_color] = [[210, 90, 70], [90, 140, 110]].map(|srgb| paint(&mut scene, "", srgb));
    let colors =
        [[236, 184, 72], [70, 128, 190], [228, 222, 206], [140, 96, 160]].map(|srgb| paint(&mut scene, "", srgb));
    let mut ball = Shape::new("ball", Vec3::new(-1.2, 1.1, -6.4));
    ball.lathe([64, 32], |t| 1.1 * Vec2::new((PI * t).sin(), -(PI * t).cos()), |_, _| ball_color);
    add(&mut scene, ball);
    let mut block = Shape::new("box", Vec3::new(1.7, 0.0, -7.6));
    block.cuboid(Vec3::new(-0.8, 0.0, -0.8), Vec3::new(0.8, 2.0, 0.8), box_color);
    add(&mut scene, block);
    for (k, (x, y, z, radius)) in [
        (0.6, 0.4, 5.4, 0.4),
        (1.5, 2.5, 7.4, 0.5),
        (-2.9, 0.7, 8.6, 0.7),
        (3.4, 3.4, 9.8, 0.6),
        (-0.3, 3.6, 8.0, 0.45),
    ]
    .into_iter()
    .enumerate()
    {
        let sphere = Sphere::new(Vec3::new(x, y, -z), radius, colors[k % colors.len()]);
        scene.add_sphere(sphere).expect("it has a radius");
    }
    scene
}

/// Screen distance of the mixed sizes; small objects are close to it.
const MIXED_SCREEN: f32 = 0.25;

pub(super) fn mixed_sizes_camera() -> StereoCamera {
    StereoCamera::look_at(EYE, EYE - Vec3::Z).screen_distance(MIXED_SCREEN).screen_width(stage::WIDTH * MIXED_SCREEN)
}

/// Builds spheres of millimetres in front of spheres of metres, on a ground of kilometres.
pub(super) fn mixed_sizes() -> Scene {
    const HUGE: f32 = 1e4;
    /// Radius of a sphere whose triangles have sides of about 0.0003. There are only a few, since the traversal
    /// separates them poorly in so large a scene. More of them would approach a driver's bound on a thread's loops.
    const BALL_RADIUS: f32 = 0.002;
    const GRAINS: usize = 1500;
    let mut scene = Scene::new();
    let [ground, mountain, shade] =
        [[134, 142, 104], [150, 140, 150], [96, 92, 110]].map(|srgb| paint(&mut scene, "huge", srgb));
    let stripes = [[214, 70, 60], [240, 222, 190]].map(|srgb| paint(&mut scene, "tiny", srgb));
    let colors = [[66, 130, 190], [236, 184, 72], [120, 84, 150]].map(|srgb| paint(&mut scene, "middle", srgb));

    let mut land = Shape::new("land", Vec3::ZERO);
    let corner = |x: f32, z: f32| Vec3::new(x * HUGE, 0.0, z * HUGE);
    land.quad([corner(-1.0, 0.1), corner(1.0, 0.1), corner(1.0, -1.0), corner(-1.0, -1.0)], ground);
    // Each slope is one triangle.
    for (peak, (x, height)) in [(-0.45, 0.22), (0.05, 0.15), (0.5, 0.26)].into_iter().enumerate() {
        let top = Vec3::new(x, height, -0.9) * HUGE;
        let [left, middle, right] = [(x - 0.5, -0.95), (x + 0.05, -0.8), (x + 0.5, -0.95)].map(|(x, z)| corner(x, z));
        land.quad([left, middle, top, top], if peak == 1 { shade } else { mountain });
        land.quad([middle, right, top, top], shade);
    }
    add(&mut scene, land);
    for (k, (x, y, depth)) in
        [(-0.05, 0.03, 0.16), (0.03, -0.03, 0.2), (0.055, 0.05, 0.24), (-0.06, -0.05, 0.27), (0.0, 0.075, 0.32)]
            .into_iter()
            .enumerate()
    {
        let mut ball = Shape::new(format!("tiny ball {k}"), EYE + Vec3::new(x, y, -depth));
        let point = |s: f32, t: f32| on_sphere(BALL_RADIUS, s, PI * t);
        ball.sheet([40, 20], Shading::Flat, point, |column, row| stripes[(column / 5 + row / 5) % 2]);
        add(&mut scene, ball);
    }
    for (k, (x, depth)) in [(-1.6, 5.0), (1.2, 6.0), (3.4, 9.0), (-6.0, 16.0), (5.0, 40.0)].into_iter().enumerate() {
        let radius = 0.7 + 0.05 * depth;
        let sphere = Sphere::new(Vec3::new(x, radius, -depth), radius, colors[k % colors.len()]);
        scene.add_sphere(sphere).expect("it has a radius");
    }
    // Triangles have sides of 0.0001 to 0.0005: from an eighth of a pixel of 600 to one and a half.
    let mut random = Random(90);
    let mut dust = Shape::new("dust", EYE);
    for grain in 0..GRAINS {
        let depth = random.between(0.2, 0.5);
        let at = Vec3::new(random.between(-0.5, 0.5) * depth, random.between(-0.5, 0.5) * depth, -depth);
        let size = 0.5 * random.between(1e-4, 5e-4);
        let [a, b, c] = [Vec3::new(-size, -size, 0.0), Vec3::new(size, -size, size), Vec3::new(0.0, size, 0.0)];
        dust.quad([at + a, at + b, at + c, at + c], colors[grain % colors.len()]);
    }
    add(&mut scene, dust);
    scene.sky = Sky::Constant(Vec3::new(0.42, 0.6, 0.85));
    scene.ambient = Some(Vec3::splat(0.2));
    scene.lights = vec![
        lamp([-6.0, 9.0, 3.0], 0.5, [1.0, 0.95, 0.88]),
        lamp([400.0, 900.0, 300.0], 0.4, [1.0, 1.0, 0.96]),
        lamp([7.0, 5.0, 4.0], 0.2, [0.9, 0.95, 1.0]),
    ];
    scene
}
