//! Things thinner than a pixel.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::PIXEL;
use crate::{
    random::Random,
    scene::{
        MaterialId, Scene, Sphere,
        builtin::{
            add, paint,
            shapes::{Shading, Shape},
            stage::{EYE, stage},
        },
    },
};

/// Ribbons, slivers that taper to a point, and chains of spheres, before the stage's wall of bricks.
pub(super) fn wires() -> Scene {
    const WIRES: usize = 90;
    /// Pixels of 600.
    const WIDTHS: [f32; 2] = [0.2, 0.9];
    const DISTANCES: [f32; 2] = [4.2, 10.0];
    let mut scene = stage();
    let colors =
        [[20, 22, 28], [240, 236, 220], [205, 60, 40], [40, 90, 170]].map(|srgb| paint(&mut scene, "wire", srgb));
    let mut random = Random(61);
    for wire in 0..WIRES {
        let distance = random.between(DISTANCES[0], DISTANCES[1]);
        let width = random.between(WIDTHS[0], WIDTHS[1]) * PIXEL * distance;
        let color = colors[wire / 3 % colors.len()];
        // The distance is also how much of the plane the picture shows.
        let middle = Vec3::new(random.between(-0.48, 0.48), random.between(-0.2, 0.3), -1.0) * distance;
        // Half of them upright, half slanted.
        let lean = if wire % 2 == 0 { 0.0 } else { random.between(-0.9, 0.9) };
        let along = Vec3::new(lean.sin(), lean.cos(), random.between(-0.2, 0.2));
        let half = along * random.between(0.1, 0.3) * distance;
        let across = Vec3::new(lean.cos(), -lean.sin(), 0.0) * (0.5 * width);
        let [low, high] = [middle - half, middle + half];
        if wire % 3 == 2 {
            chain(&mut scene, [EYE + low, EYE + high], 0.5 * width, color);
            continue;
        }
        let mut shape = Shape::new(format!("wire {wire}"), EYE);
        let tip = if wire % 3 == 0 { across } else { Vec3::ZERO };
        shape.quad([low - across, low + across, high + tip, high - tip], color);
        add(&mut scene, shape);
    }
    scene
}

/// Spheres in a row, a radius between two of them.
fn chain(scene: &mut Scene, [from, to]: [Vec3; 2], radius: f32, material: MaterialId) {
    let count = (from.distance(to) / (3.0 * radius)) as usize;
    for bead in 0..count {
        let center = from.lerp(to, bead as f32 / count as f32);
        scene.add_sphere(Sphere::new(center, radius, material)).expect("a bead has a radius");
    }
}

/// Strands that leave a ball along its normals and bend down.
pub(super) fn hair() -> Scene {
    const STRANDS: usize = 5000;
    const SEGMENTS: usize = 5;
    const RADIUS: f32 = 1.05;
    const CENTER: Vec3 = Vec3::new(0.0, 0.1, -5.2);
    /// Pixels of 600, at the ball's distance.
    const WIDTHS: [f32; 2] = [0.1, 0.5];
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    let mut scene = stage();
    let skin = paint(&mut scene, "ball", [196, 150, 120]);
    let tones =
        [[60, 34, 20], [120, 74, 36], [206, 160, 84], [232, 204, 150]].map(|srgb| paint(&mut scene, "hair", srgb));
    let mut ball = Shape::new("ball", EYE + CENTER);
    let meridian = |t: f32| Vec2::new(RADIUS * (PI * t).sin(), -RADIUS * (PI * t).cos());
    ball.lathe([48, 24], meridian, |_, _| skin);
    add(&mut scene, ball);

    let mut random = Random(5);
    // One object, as a scanned head of hair is: its strands can't be told apart by what they belong to.
    let mut hair = Shape::new("hair", EYE + CENTER);
    for strand in 0..STRANDS {
        // Points spread evenly over the ball: equal steps in height, the golden angle around.
        let y = 1.0 - 2.0 * (strand as f32 + 0.5) / STRANDS as f32;
        let (sin, cos) = ((strand as f32 * GOLDEN_ANGLE) % TAU).sin_cos();
        let ring = (1.0 - y * y).sqrt();
        let normal = Vec3::new(ring * cos, y, ring * sin);
        let length = random.between(0.3, 0.8);
        let bend = random.between(0.2, 0.6);
        let curl = Vec3::new(random.between(-0.2, 0.2), 0.0, random.between(-0.2, 0.2));
        let half_width = 0.5 * PIXEL * -CENTER.z * random.between(WIDTHS[0], WIDTHS[1]);
        let across = Vec3::new(normal.y, -normal.x, 0.0).normalize_or(Vec3::X) * half_width;
        let tone = tones[(random.unit() * tones.len() as f32) as usize];
        let point = |s: f32, t: f32| {
            let root = normal * (RADIUS + length * t);
            root + (curl - Vec3::Y * bend) * (length * t * t) + across * (2.0 * s - 1.0)
        };
        hair.sheet([1, SEGMENTS], Shading::Flat, point, |_, _| tone);
    }
    add(&mut scene, hair);
    scene
}
