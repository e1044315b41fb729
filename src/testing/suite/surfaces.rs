//! Surfaces inside, close behind, coincident with and adjacent to each other.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::on_sphere;
use crate::{
    random::pcg,
    scene::{
        MaterialId, Scene, Sphere,
        builtin::{
            add, paint,
            shapes::{Shading, Shape},
            stage::{EYE, stage},
        },
    },
};

/// Builds two nests of open spheres, each with a solid sphere at its centre.
pub(super) fn shells() -> Scene {
    const SHELLS: usize = 5;
    const PATCHES: [usize; 2] = [64, 32];
    let mut scene = stage();
    let palette = [[206, 84, 64], [234, 176, 72], [90, 156, 104], [66, 128, 184], [140, 96, 160]];
    let colors = palette.map(|srgb| paint(&mut scene, "shell", srgb));
    let heart = paint(&mut scene, "heart", [244, 240, 226]);
    for (nest, (center, radius)) in
        [(Vec3::new(-0.75, 0.05, -5.6), 1.5), (Vec3::new(2.5, -0.3, -8.4), 1.6)].into_iter().enumerate()
    {
        for shell in 0..SHELLS {
            let radius = radius * (1.0 - 0.17 * shell as f32);
            let mut shape = Shape::new(format!("shell {nest} {shell}"), EYE + center);
            let point = |column: usize, row: usize| {
                on_sphere(radius, column as f32 / PATCHES[0] as f32, PI * row as f32 / PATCHES[1] as f32)
            };
            // Windows have 4x4 patches and differ between spheres.
            let is_open = |column: usize, row: usize| {
                let window = (nest * SHELLS + shell) * 1024 + row / 4 * 32 + column / 4;
                pcg(window as u32) % 5 < 2
            };
            for row in 0..PATCHES[1] {
                for column in (0..PATCHES[0]).filter(|&column| !is_open(column, row)) {
                    let corners = [(0, 0), (0, 1), (1, 1), (1, 0)];
                    let quad = corners.map(|(right, down)| point(column + right, row + down));
                    shape.quad(quad, colors[(shell + nest) % SHELLS]);
                }
            }
            add(&mut scene, shape);
        }
        let core = Sphere::new(EYE + center, 0.2 * radius, heart);
        scene.add_sphere(core).expect("it has a radius");
    }
    scene
}

/// Builds two pairs of slanted plates, the front ones with holes.
pub(super) fn plates() -> Scene {
    const DISTANCE: f32 = 7.0;
    /// Gaps between the plates, as shares of their distance.
    const GAPS: [f32; 2] = [1e-3, 1e-5];
    const SIZE: Vec2 = Vec2::new(2.9, 4.6);
    const SLANT: f32 = 0.35;
    const FRONT: [usize; 2] = [58, 92];
    const BACK: [usize; 2] = [7, 5];
    let mut scene = stage();
    let front = [[52, 96, 160], [64, 112, 180]].map(|srgb| paint(&mut scene, "front", srgb));
    let back = [[240, 160, 50], [226, 142, 40]].map(|srgb| paint(&mut scene, "back", srgb));
    for (pair, (gap, left)) in GAPS.into_iter().zip([-3.05, 0.15]).enumerate() {
        let corner = EYE + Vec3::new(left, -2.0, -DISTANCE);
        let on_plate = |s: f32, t: f32| Vec3::new(SIZE.x * s, SIZE.y * t, -SLANT * SIZE.x * s);
        let mut behind = Shape::new(format!("back {pair}"), corner - Vec3::Z * (gap * DISTANCE));
        behind.sheet(BACK, Shading::Flat, on_plate, |column, row| back[(column + row) % 2]);
        add(&mut scene, behind);
        let mut before = Shape::new(format!("front {pair}"), corner);
        for row in 0..FRONT[1] {
            for column in 0..FRONT[0] {
                // Holes have 2x2 patches.
                if pcg((row / 2 * 64 + column / 2 + 4096 * pair) as u32).is_multiple_of(4) {
                    continue;
                }
                let quad = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(right, up)| {
                    on_plate((column + right) as f32 / FRONT[0] as f32, (row + up) as f32 / FRONT[1] as f32)
                });
                before.quad(quad, front[(column / 8 + row / 8) % 2]);
            }
        }
        add(&mut scene, before);
    }
    scene
}

/// Builds vases twice, spheres twice, and posters that overlap in one plane.
pub(super) fn coincident() -> Scene {
    const POSTERS: usize = 14;
    let mut scene = stage();
    let mut color = |srgb| paint(&mut scene, "twice", srgb);
    let pairs = [
        [color([196, 70, 60]), color([64, 140, 120])],
        [color([236, 180, 70]), color([80, 90, 170])],
        [color([150, 90, 160]), color([230, 224, 208])],
    ];
    for (k, (x, z)) in [(-2.0, 5.6), (1.1, 6.4), (2.9, 8.0)].into_iter().enumerate() {
        for (copy, material) in pairs[k].into_iter().enumerate() {
            let mut vase = Shape::new(format!("vase {k}, copy {copy}"), Vec3::new(x, 0.0, -z));
            let profile = |t: f32| Vec2::new(0.45 + 0.2 * (1.5 * PI * t + 0.4).sin(), 1.9 * t);
            vase.lathe([48, 32], profile, |_, _| material);
            add(&mut scene, vase);
        }
    }
    for (k, (x, y, z)) in [(-0.5, 1.7, 5.0), (2.1, 3.3, 6.0), (-2.6, 3.6, 7.0)].into_iter().enumerate() {
        // The second pair is in reverse order, so that the later one does not always have the same colour.
        let [first, second] = if k == 1 { [pairs[k][1], pairs[k][0]] } else { pairs[k] };
        for material in [first, second] {
            let twin = Sphere::new(Vec3::new(x, y, -z), 0.45, material);
            scene.add_sphere(twin).expect("it has a radius");
        }
    }
    for poster in 0..POSTERS {
        let share = poster as f32 / POSTERS as f32;
        // Posters have slightly different angles in the plane of a slanted board.
        let (sin, cos) = (2.0 * share - 1.0).sin_cos();
        let middle = Vec2::new(-3.6 + 7.4 * share, 2.2 + 1.2 * (TAU * 2.0 * share).sin());
        let corners = [(-0.7, -0.5), (0.7, -0.5), (0.7, 0.5), (-0.7, 0.5)].map(|(x, y): (f32, f32)| {
            let at = middle + Vec2::new(cos * x - sin * y, sin * x + cos * y);
            Vec3::new(at.x, at.y, 0.25 * at.x)
        });
        let mut shape = Shape::new(format!("poster {poster}"), Vec3::new(0.0, 0.0, -9.5));
        shape.quad(corners, pairs[poster % 3][poster / 3 % 2]);
        add(&mut scene, shape);
    }
    scene
}

/// Builds a slanted wall and a round tower of alternately coarse and fine panels, in front of a red board.
pub(super) fn t_junctions() -> Scene {
    let mut scene = stage();
    let coarse = paint(&mut scene, "coarse", [202, 196, 180]);
    let fine = paint(&mut scene, "fine", [178, 190, 200]);
    let red = paint(&mut scene, "behind", [230, 30, 20]);
    let mut wall = Shape::new("wall of panels", EYE + Vec3::new(-3.7, -2.0, -6.3));
    // f32 does not represent these axes exactly, so rounding displaces vertices from the edges they lie on.
    let (along, up) = (Vec3::new(4.1, 0.13, -1.7), Vec3::new(0.07, 4.3, -0.31));
    panels(&mut wall, [14, 14], 8, |s, t| along * s + up * t, [coarse, fine]);
    add(&mut scene, wall);
    // A coarse panel is a chord of the circle. It is up to a third of a pixel inside the fine panels' arc.
    let mut tower = Shape::new("tower of panels", Vec3::new(2.1, -0.05, -7.2));
    let round = |s: f32, t: f32| {
        let (sin, cos) = (TAU * s).sin_cos();
        Vec3::new(1.45 * cos, 4.4 * t, 1.45 * sin)
    };
    panels(&mut tower, [42, 12], 8, round, [coarse, fine]);
    add(&mut scene, tower);
    let mut core = Shape::new("tower's core", Vec3::new(2.1, -0.05, -7.2));
    core.cuboid(Vec3::new(-0.9, 0.0, -0.9), Vec3::new(0.9, 4.3, 0.9), red);
    add(&mut scene, core);
    let mut board = Shape::new("board behind the wall", EYE + Vec3::new(-3.7, -2.0, -6.8));
    board.quad([Vec3::ZERO, along, along + up, up], red);
    add(&mut scene, board);
    scene
}

/// Adds panels of a surface `point(s, t)`, alternating as on a chessboard: one quad, or `cuts` by `cuts` quads.
fn panels(
    shape: &mut Shape,
    [columns, rows]: [usize; 2],
    cuts: usize,
    point: impl Fn(f32, f32) -> Vec3,
    [coarse, fine]: [MaterialId; 2],
) {
    for row in 0..rows {
        for column in 0..columns {
            let (count, material) = if (column + row) % 2 == 0 { (1, coarse) } else { (cuts, fine) };
            let on_panel = |s: f32, t: f32| point((column as f32 + s) / columns as f32, (row as f32 + t) / rows as f32);
            shape.sheet([count, count], Shading::Flat, on_panel, |_, _| material);
        }
    }
}
