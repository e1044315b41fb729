//! Unusual positions of the eyes: on two sides of a wall, over an endless floor, far apart, inside objects, or beside
//! an object that one eye misses.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::on_sphere;
use crate::{
    random::{Random, pcg},
    scene::{
        Scene, Sky, Sphere,
        builtin::{
            add, lamp, paint,
            shapes::{Shading, Shape},
            stage::{EYE, INTERAXIAL, SCREEN, WIDTH, stage},
        },
    },
};

/// Builds a wall in the plane between the eyes, with columns and spheres on either side.
pub(super) fn septum() -> Scene {
    const HALF_THICKNESS: f32 = 0.005;
    const NEAR: f32 = 0.05;
    const FAR: f32 = 10.0;
    const HALF_HEIGHT: f32 = 8.0;
    let mut scene = stage();
    let rim = paint(&mut scene, "rim", [90, 88, 84]);
    for (name, side, palette) in [
        ("left", -1.0, [[70, 120, 190], [120, 180, 220], [40, 80, 130]]),
        ("right", 1.0, [[214, 110, 60], [240, 190, 90], [150, 60, 40]]),
    ] {
        let colors = palette.map(|srgb| paint(&mut scene, name, srgb));
        let mut face = Shape::new(format!("septum, {name}"), EYE);
        // Patches shrink towards the eyes, so that all look about equally large.
        let point = |s: f32, t: f32| {
            let depth = NEAR * (FAR / NEAR).powf(s);
            Vec3::new(side * HALF_THICKNESS, HALF_HEIGHT * (2.0 * t - 1.0), -depth)
        };
        face.sheet([64, 96], Shading::Flat, point, |column, row| {
            colors[(pcg((column * 96 + row) as u32) % 2) as usize]
        });
        add(&mut scene, face);
        for (k, (x, z, radius)) in
            [(1.2, 4.6, 0.35), (2.6, 6.4, 0.5), (0.9, 8.2, 0.4), (3.6, 9.6, 0.7)].into_iter().enumerate()
        {
            let mut column = Shape::new(format!("column {k}, {name}"), Vec3::new(side * x, 0.0, -z));
            column.lathe([32, 12], |t| Vec2::new(0.5 * radius, 3.0 * t), |_, row| colors[1 + row % 2]);
            add(&mut scene, column);
            let center = Vec3::new(side * x, 3.0 + radius, -z);
            scene.add_sphere(Sphere::new(center, radius, colors[0])).expect("it has a radius");
        }
    }
    let mut edges = Shape::new("septum, edges", EYE);
    for z in [-NEAR, -FAR] {
        let corner = |x: f32, y: f32| Vec3::new(x * HALF_THICKNESS, y * HALF_HEIGHT, z);
        edges.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], rim);
    }
    add(&mut scene, edges);
    scene
}

/// Builds light tiles on dark ground, with a few objects on them.
pub(super) fn checkerboard() -> Scene {
    const TILES: usize = 200;
    const TILE: f32 = 1.25;
    /// Height of the light tiles. The dark ones are the ground between them, which saves half of the triangles.
    const RELIEF: f32 = 0.01;
    /// The nearest row begins below the picture.
    const NEAR_CORNER: Vec3 = Vec3::new(-0.5 * TILE * TILES as f32, 0.0, -2.0);
    let mut scene = open_air();
    let [light, dark] = [[226, 220, 204], [44, 48, 56]].map(|srgb| paint(&mut scene, "tile", srgb));
    let colors = [[200, 60, 50], [60, 130, 190], [230, 180, 60]].map(|srgb| paint(&mut scene, "thing", srgb));
    let mut ground = Shape::new("ground", NEAR_CORNER - Vec3::Y * RELIEF);
    let on_ground = |s: f32, t: f32| Vec3::new(s, 0.0, -t) * (TILE * TILES as f32);
    ground.sheet([20, 20], Shading::Flat, on_ground, |_, _| dark);
    add(&mut scene, ground);
    let mut tiles = Shape::new("tiles", NEAR_CORNER);
    for row in 0..TILES {
        for column in (row % 2..TILES).step_by(2) {
            let corner =
                |right: usize, back: usize| Vec3::new((column + right) as f32, 0.0, -((row + back) as f32)) * TILE;
            tiles.quad([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)], light);
        }
    }
    add(&mut scene, tiles);
    for (k, (x, z)) in
        [(-1.6, 6.0), (1.9, 7.5), (-4.0, 13.0), (5.0, 16.0), (0.3, 24.0), (-9.0, 30.0)].into_iter().enumerate()
    {
        let material = colors[k % colors.len()];
        let radius = 0.06 * z;
        if k % 2 == 0 {
            let center = Vec3::new(x, radius, -z);
            scene.add_sphere(Sphere::new(center, radius, material)).expect("it has a radius");
        } else {
            let mut block = Shape::new(format!("block {k}"), Vec3::new(x, 0.0, -z));
            block.cuboid(Vec3::new(-radius, 0.0, -radius), Vec3::new(radius, 3.0 * radius, radius), material);
            add(&mut scene, block);
        }
    }
    scene
}

/// Builds columns and spheres from a third of the screen's distance to seven times it.
pub(super) fn half_width() -> Scene {
    const THINGS: usize = 70;
    const DEPTHS: [f32; 2] = [2.6, 56.0];
    let mut scene = open_air();
    let tiles = [[206, 194, 172], [122, 116, 110]].map(|srgb| paint(&mut scene, "tile", srgb));
    let colors = [[198, 72, 58], [236, 168, 64], [84, 150, 96], [62, 124, 182], [136, 92, 158], [230, 224, 208]]
        .map(|srgb| paint(&mut scene, "thing", srgb));
    let mut floor = Shape::new("floor", Vec3::ZERO);
    let on_floor = |s: f32, t: f32| Vec3::new(90.0 * (2.0 * s - 1.0), 0.0, 2.0 - 92.0 * t);
    floor.sheet([90, 46], Shading::Flat, on_floor, |column, row| tiles[(column + row) % 2]);
    add(&mut scene, floor);
    let mut random = Random(300);
    for thing in 0..THINGS {
        // Depths are spaced logarithmically, so there are as many near objects as far ones.
        let depth = DEPTHS[0] * (DEPTHS[1] / DEPTHS[0]).powf(thing as f32 / (THINGS - 1) as f32);
        // x covers the range that either eye sees at this depth.
        let x = random.between(-0.5, 0.5) * (depth + 2.0);
        let radius = random.between(0.1, 0.3) + 0.006 * depth;
        let material = colors[thing % colors.len()];
        if thing % 2 == 0 {
            let center = Vec3::new(x, random.between(radius, 0.6 * depth), -depth);
            scene.add_sphere(Sphere::new(center, radius, material)).expect("it has a radius");
        } else {
            let mut column = Shape::new(format!("column {thing}"), Vec3::new(x, 0.0, -depth));
            let height = random.between(1.2, 4.0);
            column.lathe(
                [24, 6],
                |t| Vec2::new(0.7 * radius, height * t),
                |_, row| colors[(thing + row) % colors.len()],
            );
            add(&mut scene, column);
        }
    }
    scene
}

/// Builds a sphere with a window around the left eye, and a sphere around everything.
pub(super) fn inside() -> Scene {
    /// Radius below the interaxial, so that the right eye is outside.
    const BALL: f32 = 0.6 * INTERAXIAL;
    /// Half the angle of the window, in radians.
    const WINDOW: f32 = 0.36;
    /// Radius that reaches beyond the stage's lights, but not its wall.
    const SKY: f32 = 11.4;
    let mut scene = stage();
    let sky = paint(&mut scene, "sphere around it all", [120, 150, 190]);
    let lining = [[150, 40, 50], [220, 180, 150], [90, 60, 110]].map(|srgb| paint(&mut scene, "lining", srgb));
    let colors = [[60, 140, 110], [230, 190, 70], [70, 110, 180]].map(|srgb| paint(&mut scene, "thing", srgb));
    scene.add_sphere(Sphere::new(EYE, SKY, sky)).expect("it has a radius");
    let mut ball = Shape::new("ball around the left eye", EYE - Vec3::X * (0.5 * INTERAXIAL));
    // t runs from the window's rim in front of the eye to the point behind it.
    let point = |s: f32, t: f32| {
        let polar = WINDOW + (PI - WINDOW) * t;
        let at = on_sphere(BALL, s, polar);
        Vec3::new(at.x, at.z, -at.y)
    };
    ball.sheet([48, 40], Shading::Flat, point, |column, row| lining[(pcg((column * 40 + row) as u32) % 3) as usize]);
    add(&mut scene, ball);
    for (k, (x, z)) in [(-1.7, 5.0), (0.4, 6.2), (2.2, 7.4), (-0.9, 9.0), (3.4, 10.4)].into_iter().enumerate() {
        let mut post = Shape::new(format!("post {k}"), Vec3::new(x, 0.0, -z));
        post.lathe([32, 10], |t| Vec2::new(0.3, 3.4 * t), |_, row| colors[(k + row) % colors.len()]);
        add(&mut scene, post);
        let center = Vec3::new(x + 0.8, 2.3, -z + 0.4);
        scene.add_sphere(Sphere::new(center, 0.35, colors[k % colors.len()])).expect("it has a radius");
    }
    scene
}

/// Builds a post in the wedge in front of the screen's right edge that only the right eye's picture contains.
pub(super) fn wings() -> Scene {
    /// Over half the screen's distance; the paper excludes nearer objects.
    const DEPTH: f32 = 4.4;
    let mut scene = stage();
    let stripes = [[214, 60, 120], [250, 230, 140]].map(|srgb| paint(&mut scene, "stripe", srgb));
    // These lines run from the eyes to the screen's right edge. Only the right eye's picture reaches beyond the left
    // eye's line.
    let line = |eye: f32| eye + (0.5 * WIDTH * SCREEN - eye) * DEPTH / SCREEN;
    let [of_left, of_right] = [line(-0.5 * INTERAXIAL), line(0.5 * INTERAXIAL)];
    let radius = 0.42 * (of_right - of_left);
    let mut post = Shape::new("post in the wings", Vec3::new(of_left.midpoint(of_right), 0.0, -DEPTH));
    post.lathe([24, 16], |t| Vec2::new(radius, 3.4 * t), |column, row| stripes[(row + column / 6) % 2]);
    add(&mut scene, post);
    scene
}

/// Builds sky and lights without a stage.
fn open_air() -> Scene {
    let mut scene = Scene::new();
    scene.sky = Sky::Gradient { nadir: Vec3::splat(0.3), zenith: Vec3::new(0.2, 0.42, 0.85) };
    scene.ambient = Some(Vec3::splat(0.15));
    scene.lights = vec![
        lamp([-14.0, 20.0, 6.0], 0.45, [1.0, 0.96, 0.9]),
        lamp([16.0, 14.0, -4.0], 0.3, [1.0, 0.94, 0.86]),
        lamp([0.0, 30.0, -40.0], 0.25, [1.0, 1.0, 1.0]),
        lamp([-30.0, 12.0, -50.0], 0.15, [0.9, 0.95, 1.0]),
    ];
    scene
}
