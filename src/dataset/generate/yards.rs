//! Buildings, fences, poles and wires.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Affine3A, Vec2, Vec3};

use super::{World, dice::Dice, form::Form, materials::Stuff, outdoors::Ground, standing, textures::Pattern};
use crate::Error;

/// Width of a facade's picture in metres; it shows four by four windows.
const FACADE: f32 = 11.0;

/// Returns a street lamp, a sign, a bollard or a bare pole, and what its slots are made of.
pub(super) fn post(dice: &mut Dice) -> (Form, &'static [Stuff]) {
    let mut form = Form::default();
    let height = dice.between(2.2, 4.5);
    let thick = dice.between(0.03, 0.07);
    match dice.below(4) {
        0 => {
            form.cylinder(thick, [-0.1, height], 12, 0);
            let arm = Vec3::new(0.9, 0.25, 0.0);
            form.bar(Vec3::Y * (height - 0.1), Vec3::Y * (height - 0.1) + arm, 0.6 * thick, 8, 0);
            form.cuboid(Vec3::new(0.7, height + 0.08, -0.12), Vec3::new(1.3, height + 0.18, 0.12), 1);
        }
        1 => {
            form.cylinder(thick, [-0.1, height], 12, 0);
            let half = Vec2::new(dice.between(0.25, 0.6), dice.between(0.2, 0.45));
            let middle = height - half.y;
            form.cuboid(
                Vec3::new(-half.x, middle - half.y, thick),
                Vec3::new(half.x, middle + half.y, thick + 0.03),
                1,
            );
        }
        2 => {
            let height = 0.3 * height;
            form.cylinder(0.09, [-0.1, height], 20, 0);
            form.body(Vec3::Y * height, [20, 12], |_| 0.11, 1);
        }
        _ => {
            form.cylinder(1.5 * thick, [-0.1, 1.3 * height], 12, 0);
        }
    }
    (form, &[Stuff::Metal, Stuff::Card])
}

pub(super) fn bench(dice: &mut Dice) -> (Form, &'static [Stuff]) {
    let mut form = Form::default();
    let width = dice.between(1.2, 2.0);
    let has_back = dice.chance(0.7);
    for slat in 0..4 {
        let z = -0.16 + 0.11 * slat as f32;
        form.cuboid(Vec3::new(-0.5 * width, 0.42, z), Vec3::new(0.5 * width, 0.45, z + 0.085), 0);
    }
    for slat in 0..if has_back { 3 } else { 0 } {
        let y = 0.55 + 0.13 * slat as f32;
        form.cuboid(Vec3::new(-0.5 * width, y, -0.24), Vec3::new(0.5 * width, y + 0.09, -0.21), 0);
    }
    for x in [-0.4 * width, 0.4 * width] {
        form.cuboid(Vec3::new(x - 0.03, -0.1, -0.2), Vec3::new(x + 0.03, 0.42, 0.26), 1);
        if has_back {
            form.cuboid(Vec3::new(x - 0.03, 0.42, -0.205), Vec3::new(x + 0.03, 0.92, -0.17), 1);
        }
    }
    (form, &[Stuff::Wood, Stuff::Metal])
}

impl World<'_> {
    /// Puts a building with a pitched or flat roof at the edge of the site.
    pub(super) fn house(&mut self, ground: &Ground) -> Result<(), Error> {
        let mut dice = self.dice.fork();
        let floors = dice.whole(1, 4) as f32;
        let size = Vec3::new(dice.between(5.0, 14.0), 2.75 * floors, dice.between(5.0, 10.0));
        let mut form = Form::default();
        let half = 0.5 * size;
        let corners =
            [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].map(|(x, z)| Vec2::new(x * half.x, z * half.z));
        for side in 0..4 {
            let (a, b) = (corners[side], corners[(side + 1) % 4]);
            let at = |p: Vec2, y: f32| Vec3::new(p.x, y, p.y);
            let width = a.distance(b);
            let uv = [(0.0, -0.6), (width, -0.6), (width, size.y), (0.0, size.y)].map(Vec2::from);
            form.quad_with([at(a, -0.6), at(b, -0.6), at(b, size.y), at(a, size.y)], uv, 0);
        }
        roof(&mut form, size, &mut dice);
        form.cuboid(Vec3::new(-0.5, -0.6, half.z), Vec3::new(0.5, 2.1, half.z + 0.06), 2);
        let wall = self.palette.patterned(Pattern::Facade, dice.pick(&[Stuff::Wall, Stuff::Stone]), FACADE);
        let roof = self.palette.patterned(Pattern::Bricks, Stuff::Bark, 2.0);
        let paints = [wall, roof, self.palette.paint(Stuff::Wood)?];
        for _ in 0..super::TRIES {
            let away = Vec2::from_angle(dice.angle()) * dice.between(13.0, 34.0);
            let facing = FRAC_PI_2 - away.to_angle() + PI + dice.between(-0.4, 0.4);
            if self.put("building", &form, &standing(ground.at(away.x, away.y), facing), &paints)? {
                break;
            }
        }
        Ok(())
    }

    /// Adds a fence of pickets, rails or wires along a line on the ground.
    pub(super) fn fence(&mut self, ground: &Ground) -> Result<(), Error> {
        let mut dice = self.dice.fork();
        let (turn, offset) = (dice.angle(), dice.between(2.5, 9.0));
        let along = Vec2::from_angle(turn);
        let middle = along.perp() * offset;
        let (kind, height) = (dice.below(3), dice.between(0.8, 1.5));
        let aside = Vec3::new(-along.y, 0.0, along.x);
        let count = dice.whole(7, 16);
        let pitch = 1.7;
        let place = |t: f32| {
            let at = middle + along * pitch * (t - 0.5 * count as f32);
            ground.at(at.x, at.y)
        };
        let mut form = Form::default();
        for post in 0..=count {
            let foot = place(post as f32);
            form.bar(foot - Vec3::Y * 0.2, foot + Vec3::Y * height, 0.035, 7, 0);
        }
        for section in 0..count {
            let ends = [place(section as f32), place(section as f32 + 1.0)];
            let rails = [4, 3, 2][kind];
            for rail in 0..rails {
                let y = height * (rail as f32 + 0.7) / rails as f32 - 0.05;
                let thick = if kind == 0 { 0.006 } else { 0.022 };
                form.bar(ends[0] + Vec3::Y * y, ends[1] + Vec3::Y * y, thick, 5, if kind == 0 { 1 } else { 0 });
            }
            let pickets = if kind == 2 { 9 } else { 0 };
            for picket in 0..pickets {
                let foot = ends[0].lerp(ends[1], (picket as f32 + 0.5) / pickets as f32);
                let mut board = Form::default();
                board.block(Vec3::new(0.09, 0.94 * height, 0.02), 0.05, 0);
                form.join(&board, standing(foot + aside * 0.035, -turn), 0);
            }
        }
        let paints = [self.palette.paint(Stuff::Wood)?, self.palette.metal()];
        self.put("fence", &form, &Affine3A::IDENTITY, &paints).map(drop)
    }

    /// Adds poles with sagging wires between them.
    pub(super) fn wires(&mut self, ground: &Ground) -> Result<(), Error> {
        let mut dice = self.dice.fork();
        let (turn, offset) = (dice.angle(), dice.between(3.0, 12.0));
        let along = Vec2::from_angle(turn);
        let (height, pitch) = (dice.between(4.0, 7.0), dice.between(9.0, 16.0));
        let lines = dice.whole(2, 4);
        let place = |pole: usize| {
            let at = along.perp() * offset + along * pitch * (pole as f32 - 1.5);
            ground.at(at.x, at.y)
        };
        let side = Vec3::new(-along.y, 0.0, along.x);
        let (mut poles, mut wires) = (Form::default(), Form::default());
        let hold = |pole: usize, line: usize| {
            let across = line as f32 / (lines - 1) as f32 - 0.5;
            place(pole) + Vec3::Y * (height - 0.25) + side * across * 1.5
        };
        for pole in 0..4 {
            let foot = place(pole);
            poles.bar(foot - Vec3::Y * 0.3, foot + Vec3::Y * height, 0.1, 10, 0);
            poles.bar(hold(pole, 0) - Vec3::Y * 0.06, hold(pole, lines - 1) - Vec3::Y * 0.06, 0.05, 6, 0);
        }
        let sag = dice.between(0.3, 1.0);
        for (pole, line) in (0..3).flat_map(|pole| (0..lines).map(move |line| (pole, line))) {
            let (from, to) = (hold(pole, line), hold(pole + 1, line));
            let curve: Vec<Vec3> = (0..=16)
                .map(|step| {
                    let t = step as f32 / 16.0;
                    from.lerp(to, t) - Vec3::Y * sag * 4.0 * t * (1.0 - t)
                })
                .collect();
            wires.tube(&curve, |_| 0.012, 5, false, 0);
        }
        let (wood, dark) = (self.palette.paint(Stuff::Bark)?, self.palette.plain(Vec3::splat(0.03), 0.1));
        if self.put("poles", &poles, &Affine3A::IDENTITY, &[wood])? {
            self.put("wires", &wires, &Affine3A::IDENTITY, &[dark])?;
        }
        Ok(())
    }
}

/// Adds a gabled or a flat roof with a chimney.
fn roof(form: &mut Form, size: Vec3, dice: &mut Dice) {
    let half = 0.5 * size;
    if dice.chance(0.4) {
        form.cuboid(
            Vec3::new(-half.x - 0.2, size.y, -half.z - 0.2),
            Vec3::new(half.x + 0.2, size.y + 0.3, half.z + 0.2),
            1,
        );
        return;
    }
    let (rise, over) = (size.z * dice.between(0.25, 0.5), 0.35);
    let ridge = size.y + rise;
    let eaves = size.y - over * rise / half.z;
    let at = |x: f32, y: f32, z: f32| Vec3::new(x * (half.x + over), y, z * (half.z + over));
    form.quad([at(-1.0, eaves, 1.0), at(1.0, eaves, 1.0), at(1.0, ridge, 0.0), at(-1.0, ridge, 0.0)], 1);
    form.quad([at(1.0, eaves, -1.0), at(-1.0, eaves, -1.0), at(-1.0, ridge, 0.0), at(1.0, ridge, 0.0)], 1);
    for side in [-1.0, 1.0] {
        let gable = [(-side, size.y), (side, size.y), (0.0, ridge - 0.02)];
        let [a, b, c] = gable.map(|(z, y)| Vec3::new(side * half.x, y, -z * half.z));
        let flat = |at: Vec3| Vec2::new(at.z, at.y);
        form.quad_with([a, b, c, c], [flat(a), flat(b), flat(c), flat(c)], 0);
    }
    let x = dice.between(-0.6, 0.6) * half.x;
    let stack: Vec<Vec2> = (0..4).map(|corner| Vec2::from_angle(TAU * (corner as f32 + 0.5) / 4.0) * 0.4).collect();
    let mut chimney = Form::default();
    chimney.prism(&stack, [size.y, ridge + 0.7], 1);
    form.join(&chimney, standing(Vec3::new(x, 0.0, -0.3 * half.z), 0.0), 0);
}
