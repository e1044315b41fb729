//! Forms of single objects: vases, balls, gears, knots, and other shapes that float or stand on surfaces.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::{dice::Dice, form::Form};

/// A form, and whether it is closed, so that it can be glass.
pub(super) struct Shape {
    pub(super) name: &'static str,
    pub(super) form: Form,
    pub(super) is_closed: bool,
}

fn shape(name: &'static str, is_closed: bool, build: impl FnOnce(&mut Form)) -> Shape {
    let mut form = Form::default();
    build(&mut form);
    Shape { name, form, is_closed }
}

/// Returns a line of points from a function of 0 to 1.
pub(super) fn line(count: usize, point: impl Fn(f32) -> Vec2) -> Vec<Vec2> {
    (0..=count).map(|step| point(step as f32 / count as f32)).collect()
}

/// Returns a vase, bottle, bowl or cup of a random profile, with an inner wall.
pub(super) fn vessel(dice: &mut Dice, height: f32) -> Shape {
    let foot = height * dice.between(0.14, 0.3);
    let belly = height * dice.between(0.05, 0.3);
    let neck = height * dice.between(-0.08, 0.12);
    let peak = dice.between(0.55, 1.6);
    let radius = |t: f32| (foot + belly * (PI * t.powf(peak)).sin() + neck * t * t).max(0.06 * height);
    let wall = 0.035 * height;
    let rim = radius(1.0).max(1.5 * wall);
    let outside = line(10, |t| Vec2::new(if t == 1.0 { rim } else { radius(t) }, height * t));
    let inside = line(10, |t| {
        let t = 1.0 - t;
        Vec2::new((radius(t) - wall).max(0.02 * height), wall + (height - wall) * t)
    });
    shape("vessel", true, |form| {
        let top = vec![outside[10], inside[0]];
        let base = vec![Vec2::ZERO, outside[0]];
        let bottom = vec![inside[10], Vec2::new(0.0, wall)];
        form.lathe(&[base, outside, top, inside, bottom], 20, 0);
    })
}

pub(super) fn ball(_: &mut Dice) -> Shape {
    shape("ball", true, |form| form.body(Vec3::ZERO, [26, 15], |_| 0.5, 0))
}

/// Returns a lump whose radius changes smoothly with the direction.
pub(super) fn lump(dice: &mut Dice) -> Shape {
    let waves: Vec<(Vec3, f32, f32)> = (0..6)
        .map(|_| {
            let axis = dice.turn() * Vec3::X * dice.between(1.0, 5.5);
            (axis, dice.angle(), dice.between(0.04, 0.16))
        })
        .collect();
    shape("lump", true, |form| {
        let reach =
            |d: Vec3| 1.0 + waves.iter().map(|(axis, phase, size)| size * (axis.dot(d) + phase).sin()).sum::<f32>();
        form.body(Vec3::ZERO, [28, 16], reach, 0);
    })
}

/// Returns a body between a box, a ball and a star, by the exponents of a superquadric.
pub(super) fn superquadric(dice: &mut Dice) -> Shape {
    let exponents = [dice.between(0.8, 5.0), dice.between(0.8, 5.0)];
    let radii = Vec3::new(1.0, dice.between(0.4, 1.4), dice.between(0.5, 1.2));
    shape("superquadric", true, |form| {
        let reach = |d: Vec3| {
            let d = (d / radii).abs().max(Vec3::splat(1e-6));
            let flat = (d.x.powf(exponents[0]) + d.z.powf(exponents[0])).powf(exponents[1] / exponents[0]);
            (flat + d.y.powf(exponents[1])).powf(-1.0 / exponents[1])
        };
        form.body(Vec3::ZERO, [28, 16], reach, 0);
    })
}

pub(super) fn ring(dice: &mut Dice) -> Shape {
    let (radius, thick) = (1.0, dice.log_between(0.03, 0.35));
    let squash = dice.between(0.6, 1.0);
    let circle: Vec<Vec3> = (0..36)
        .map(|step| {
            let (sin, cos) = (TAU * step as f32 / 36.0).sin_cos();
            Vec3::new(radius * cos, 0.0, squash * radius * sin)
        })
        .collect();
    shape("ring", true, |form| form.tube(&circle, |_| thick, 14, true, 0))
}

/// Returns a tube along a torus knot.
pub(super) fn knot(dice: &mut Dice) -> Shape {
    let (p, q) = dice.pick(&[(2.0, 3.0), (3.0, 2.0), (2.0, 5.0), (3.0, 4.0), (1.0, 4.0)]);
    let (thick, inner) = (dice.log_between(0.04, 0.14), dice.between(0.3, 0.5));
    let line: Vec<Vec3> = (0..90)
        .map(|step| {
            let t = TAU * step as f32 / 90.0;
            let out = 1.0 + inner * (q * t).cos();
            Vec3::new(out * (p * t).cos(), inner * (q * t).sin(), out * (p * t).sin())
        })
        .collect();
    shape("knot", true, |form| form.tube(&line, |_| thick, 7, true, 0))
}

/// Returns a spring.
pub(super) fn spring(dice: &mut Dice) -> Shape {
    let (turns, thick) = (dice.between(3.0, 8.0), dice.between(0.03, 0.09));
    let line: Vec<Vec3> = (0..=100)
        .map(|step| {
            let t = step as f32 / 100.0;
            let (sin, cos) = (TAU * turns * t).sin_cos();
            Vec3::new(0.5 * cos, 2.0 * t - 1.0, 0.5 * sin)
        })
        .collect();
    shape("spring", true, |form| form.tube(&line, |_| thick, 6, false, 0))
}

/// Returns a prism with the outline of a gear, a star, a cross or a polygon.
pub(super) fn prism(dice: &mut Dice) -> Shape {
    let count = dice.whole(3, 12);
    let (kind, depth) = (dice.below(3), dice.between(0.25, 0.75));
    let height = dice.log_between(0.12, 1.6);
    let outline: Vec<Vec2> = match kind {
        0 => (0..count).map(|step| on_circle(step as f32 / count as f32, 1.0)).collect(),
        1 => (0..2 * count)
            .map(|step| on_circle(step as f32 / (2 * count) as f32, if step % 2 == 0 { 1.0 } else { depth }))
            .collect(),
        _ => (0..4 * count)
            .map(|step| on_circle(step as f32 / (4 * count) as f32, if step % 4 < 2 { 1.0 } else { 0.5 + 0.5 * depth }))
            .collect(),
    };
    shape("prism", true, |form| form.prism(&outline, [0.0, height], 0))
}

fn on_circle(turn: f32, radius: f32) -> Vec2 {
    let (sin, cos) = (TAU * turn).sin_cos();
    radius * Vec2::new(cos, sin)
}

/// Returns a turned body with creases, such as a chess piece or a spindle.
pub(super) fn spindle(dice: &mut Dice) -> Shape {
    let (mut runs, mut at) = (Vec::new(), Vec2::new(0.0, 0.0));
    let parts = dice.whole(3, 7);
    for part in 0..=parts {
        let to = Vec2::new(if part == parts { 0.0 } else { dice.between(0.12, 0.6) }, at.y + dice.between(0.05, 0.5));
        let bulge = dice.between(-0.2, 0.25);
        let from = at;
        runs.push(line(6, |t| {
            let straight = from.lerp(to, t);
            Vec2::new((straight.x + bulge * (PI * t).sin()).clamp(0.0, 0.8), straight.y)
        }));
        at = to;
    }
    shape("spindle", true, |form| form.lathe(&runs, 20, 0))
}

/// Returns a lattice of thin bars: a box's edges, or a grid.
pub(super) fn lattice(dice: &mut Dice) -> Shape {
    let counts = [dice.whole(1, 4), dice.whole(1, 4)];
    let (thick, depth) = (dice.log_between(0.012, 0.05), dice.between(0.3, 1.0));
    shape("lattice", false, |form| {
        let at = |place: usize, count: usize| place as f32 / count as f32 - 0.5;
        for z in [-0.5 * depth, 0.5 * depth] {
            for column in 0..=counts[0] {
                let x = at(column, counts[0]);
                form.bar(Vec3::new(x, -0.5, z), Vec3::new(x, 0.5, z), thick, 6, 0);
            }
            for row in 0..=counts[1] {
                let y = at(row, counts[1]);
                form.bar(Vec3::new(-0.5, y, z), Vec3::new(0.5, y, z), thick, 6, 0);
            }
        }
        for (x, y) in [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)] {
            form.bar(Vec3::new(x, y, -0.5 * depth), Vec3::new(x, y, 0.5 * depth), thick, 6, 1);
        }
    })
}

/// Returns a bent sheet, such as a leaf of paper or a flag.
pub(super) fn sheet(dice: &mut Dice) -> Shape {
    let (bend, wave, phase) = (dice.between(0.0, 0.5), dice.between(0.0, 0.15), dice.angle());
    let size = Vec2::new(1.0, dice.between(0.5, 1.5));
    shape("sheet", false, |form| {
        let point = |s: f32, t: f32| {
            let x = s - 0.5;
            Vec3::new(x * size.x, bend * x * x + wave * (TAU * (s + 0.4 * t) + phase).sin(), -size.y * (t - 0.5))
        };
        form.sheet([16, 16], false, size, point, 0);
    })
}

/// Returns a box with a lid of another material.
pub(super) fn carton(dice: &mut Dice) -> Shape {
    let size = Vec3::new(dice.between(0.5, 1.2), dice.between(0.2, 1.0), dice.between(0.4, 1.0));
    let lid = dice.chance(0.5);
    shape("box", true, |form| {
        form.block(size, 0.0, 0);
        if lid {
            form.block(size * Vec3::new(1.04, 0.18, 1.04), size.y, 1);
        }
    })
}

/// Returns bodies on the ends of bars, such as a jack or a molecule.
pub(super) fn jack(dice: &mut Dice) -> Shape {
    let count = dice.whole(3, 7);
    let (ball, thick) = (dice.between(0.12, 0.3), dice.between(0.03, 0.1));
    shape("jack", true, |form| {
        form.body(Vec3::ZERO, [14, 8], |_| 1.3 * ball, 1);
        for _ in 0..count {
            let end = dice.turn() * Vec3::X;
            form.bar(Vec3::ZERO, end, thick, 8, 0);
            form.body(end, [14, 8], |_| ball, 1);
        }
    })
}

/// Returns a shape of any kind, in a frame of its own size.
pub(super) fn any(dice: &mut Dice) -> Shape {
    const KINDS: [fn(&mut Dice) -> Shape; 13] =
        [ball, lump, superquadric, superquadric, ring, knot, spring, prism, prism, spindle, lattice, sheet, jack];
    match dice.below(KINDS.len() + 2) {
        place if place < KINDS.len() => KINDS[place](dice),
        place if place == KINDS.len() => carton(dice),
        _ => vessel(dice, 1.0),
    }
}
