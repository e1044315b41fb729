//! Four scenes that are hard for stereo methods, on a common stage.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::{
    INTERAXIAL_SHARE, add, lamp, paint,
    shapes::{Shading, Shape},
};
use crate::{
    Scene, Sky, Sphere, StereoCamera,
    random::{Random, pcg},
};

/// The stage: eyes above a tiled floor, in front of a wall.
pub(crate) const EYE: Vec3 = Vec3::new(0.0, 2.13, 0.0);
pub(crate) const SCREEN: f32 = 8.0;
pub(crate) const WALL: f32 = 12.0;
/// Ratio of the screen's width to its distance. It replaces a field of view, so that the interaxial in world units is
/// the same in every picture.
pub(crate) const WIDTH: f32 = 1.0;

pub(crate) fn camera() -> StereoCamera {
    StereoCamera::look_at(EYE, EYE - Vec3::Z).screen_distance(SCREEN).screen_width(WIDTH * SCREEN)
}

/// Returns the same view, with the screen distance of the near scene.
pub(crate) fn near_camera() -> StereoCamera {
    StereoCamera::look_at(EYE, EYE - Vec3::Z).screen_distance(NEAR_SCREEN).screen_width(WIDTH * NEAR_SCREEN)
}

/// Interaxial on the stage, in world units.
pub(crate) const INTERAXIAL: f32 = INTERAXIAL_SHARE * WIDTH * SCREEN;

/// Builds floor, wall, lights and sky.
pub(crate) fn stage() -> Scene {
    let mut scene = Scene::new();
    scene.sky = Sky::Gradient { nadir: Vec3::splat(0.3), zenith: Vec3::new(0.25, 0.45, 0.8) };
    let tiles = [[206, 194, 172], [122, 116, 110]].map(|color| paint(&mut scene, "tile", color));
    let bricks = [[186, 106, 82], [170, 92, 72], [198, 122, 96]].map(|color| paint(&mut scene, "brick", color));
    const HALF_WIDTH: f32 = 10.0;
    let mut floor = Shape::new("floor", Vec3::ZERO);
    let on_floor = |s: f32, t: f32| Vec3::new(HALF_WIDTH * (2.0 * s - 1.03), 0.0, 2.0 - (2.0 + WALL) * t);
    floor.sheet([20, 14], Shading::Flat, on_floor, |column, row| tiles[(column + row) % 2]);
    add(&mut scene, floor);
    let mut wall = Shape::new("wall", Vec3::new(0.0, 0.0, -WALL));
    let on_wall = |s: f32, t: f32| Vec3::new(HALF_WIDTH * (2.0 * s - 1.03), -0.12 + 9.1 * t, 0.0);
    // A brick has two patches, and every second row is shifted by one.
    wall.sheet([40, 26], Shading::Flat, on_wall, |column, row| {
        let brick = (column + row % 2) / 2;
        bricks[(pcg((brick * 53 + row) as u32) % 3) as usize]
    });
    add(&mut scene, wall);
    scene.ambient = Some(Vec3::splat(0.15));
    scene.lights = vec![
        lamp([-4.0, 6.0, 1.0], 0.4, [1.0, 0.96, 0.9]),
        lamp([5.0, 5.0, 0.0], 0.3, [1.0, 0.95, 0.88]),
        lamp([0.0, 7.0, -4.0], 0.2, [1.0, 1.0, 1.0]),
        lamp([-7.0, 3.0, -6.0], 0.15, [0.9, 0.95, 1.0]),
        lamp([7.0, 4.0, -8.0], 0.15, [1.0, 0.9, 0.8]),
    ];
    scene
}

pub(crate) fn fence() -> Scene {
    const DISTANCE: f32 = 5.2;
    const SLATS: usize = 60;
    const SLAT_WIDTH: f32 = 0.09;
    const PITCH: f32 = 0.15;
    const THICKNESS: f32 = 0.03;
    let mut scene = stage();
    let white = paint(&mut scene, "white paint", [236, 234, 226]);
    let mut random = Random(7);
    for slat in 0..SLATS {
        let x = (slat as f32 - 0.5 * (SLATS - 1) as f32) * PITCH;
        let mut shape = Shape::new(format!("slat {slat}"), Vec3::new(x, 0.0, -DISTANCE));
        let (half, height) = (0.5 * SLAT_WIDTH, 2.5 + random.between(-0.06, 0.06));
        let point = |x, y, z| Vec3::new(x, y, z);
        shape.cuboid(point(-half, 0.08, -THICKNESS), point(half, height, 0.0), white);
        // The pointed top has two slopes and two gables.
        let tip = height + SLAT_WIDTH;
        let [front, back] = [0.0, -THICKNESS];
        for side in [-half, half] {
            let edge =
                [point(side, height, front), point(0.0, tip, front), point(0.0, tip, back), point(side, height, back)];
            shape.quad(edge, white);
        }
        for z in [front, back] {
            shape
                .quad([point(-half, height, z), point(half, height, z), point(0.0, tip, z), point(0.0, tip, z)], white);
        }
        add(&mut scene, shape);
    }
    let half_length = 0.5 * SLATS as f32 * PITCH;
    for (name, y) in [("lower rail", 0.5), ("upper rail", 1.9)] {
        let mut rail = Shape::new(name, Vec3::new(0.0, y, -DISTANCE - THICKNESS - 0.001));
        rail.cuboid(Vec3::new(-half_length, 0.0, -0.04), Vec3::new(half_length, 0.1, 0.0), white);
        add(&mut scene, rail);
    }
    scene
}

pub(crate) fn hidden() -> Scene {
    const BOARD: f32 = 4.4;
    const PILLAR: f32 = 11.0;
    /// x of the board's right edge.
    const EDGE: f32 = 0.3;
    let mut scene = stage();
    let board_color = paint(&mut scene, "board", [60, 110, 130]);
    let stripes = [[226, 60, 40], [244, 232, 210]].map(|color| paint(&mut scene, "stripe", color));
    let mut board = Shape::new("board", Vec3::new(0.0, 0.0, -BOARD));
    board.cuboid(Vec3::new(-1.3, -0.1, -0.05), Vec3::new(EDGE, 3.4, 0.0), board_color);
    add(&mut scene, board);

    // The lines from the eyes over the board's edge meet the pillar's plane at two points. Only the right eye sees
    // between them.
    let behind = |eye: f32| eye + (EDGE - eye) * PILLAR / BOARD;
    let [right_limit, left_limit] = [behind(0.5 * INTERAXIAL), behind(-0.5 * INTERAXIAL)];
    let center = right_limit.midpoint(left_limit);
    let radius = 0.42 * (left_limit - right_limit);
    let mut pillar = Shape::new("hidden", Vec3::new(center, 0.0, -PILLAR));
    pillar.lathe([24, 16], |t| Vec2::new(radius, 3.2 * t), |column, row| stripes[(row + column / 6) % 2]);
    add(&mut scene, pillar);
    scene
}

/// Screen distance of the near scene, and its ratio to the distance of the sphere's front.
const NEAR_SCREEN: f32 = 7.0;
pub(crate) const NEAR_FACTOR: f32 = 7.0;

pub(crate) fn near() -> Scene {
    const RADIUS: f32 = 0.09;
    let mut scene = stage();
    let ball = paint(&mut scene, "ball", [240, 180, 50]);
    let posts = [[70, 130, 90], [60, 90, 150]].map(|color| paint(&mut scene, "post", color));
    let center = EYE - Vec3::Z * (NEAR_SCREEN / NEAR_FACTOR + RADIUS);
    scene.add_sphere(Sphere::new(center, RADIUS, ball)).expect("the ball has a radius");
    for (k, (x, z)) in [(-2.2, 6.0), (1.6, 7.0), (-0.7, 9.0), (3.0, 9.5)].into_iter().enumerate() {
        let mut post = Shape::new(format!("post {k}"), Vec3::new(x, 0.0, -z));
        post.lathe([32, 1], |t| Vec2::new(0.25, 3.3 * t), |_, _| posts[k % 2]);
        post.lathe(
            [32, 8],
            |t| Vec2::new(0.25 * (0.5 * PI * t).cos(), 3.3 + 0.25 * (0.5 * PI * t).sin()),
            |_, _| posts[k % 2],
        );
        add(&mut scene, post);
    }
    scene
}

pub(crate) fn grazing() -> Scene {
    const SHEETS: usize = 12;
    /// Offset of a sheet's far edge from the line through the left eye and its near edge: a third of a pixel of 600.
    const MISS: f32 = 0.004;
    let mut scene = stage();
    let colors = [[220, 70, 60], [240, 200, 70], [70, 150, 190]].map(|color| paint(&mut scene, "sheet", color));
    let left_eye = Vec3::new(-0.5 * INTERAXIAL, 0.0, 0.0);
    for sheet in 0..SHEETS {
        let slope = 0.42 * (2.0 * sheet as f32 / (SHEETS - 1) as f32 - 1.0);
        let direction = Vec3::new(slope, 0.0, -1.0);
        let near = left_eye + direction * (4.4 + 0.5 * (sheet % 3) as f32);
        let side = if sheet % 2 == 0 { MISS } else { -MISS };
        let far = left_eye + direction * 10.5 + Vec3::X * side;
        let mut shape = Shape::new(format!("sheet {sheet}"), Vec3::ZERO);
        let color = |_: usize, row: usize| colors[(sheet + row) % 3];
        shape.sheet([6, 8], Shading::Flat, |s, t| near.lerp(far, s) + Vec3::Y * (0.3 + 2.9 * t), color);
        add(&mut scene, shape);
    }
    scene
}
