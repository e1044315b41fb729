//! Trees, bushes, potted plants and grass, with leaves cut out of quads.

use std::f32::consts::TAU;

use glam::{Quat, Vec2, Vec3};

use super::{dice::Dice, form::Form, shapes::line};

/// Slots of a plant.
pub(super) const WOOD: u16 = 0;
pub(super) const LEAF: u16 = 1;
pub(super) const POT: u16 = 2;

/// Adds a quad that shows the whole leaf texture, with its stem at `base`.
fn leaf(form: &mut Form, base: Vec3, turn: Quat, size: Vec2) {
    let at = |x: f32, y: f32| base + turn * Vec3::new(x * size.x, y * size.y, 0.0);
    let uv = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    form.quad_with([at(-0.5, 0.0), at(0.5, 0.0), at(0.5, 1.0), at(-0.5, 1.0)], uv, LEAF);
}

/// Adds a branch that bends at random, and returns its points.
fn branch(form: &mut Form, from: Vec3, along: Vec3, thick: f32, dice: &mut Dice) -> Vec<Vec3> {
    let mut points = vec![from];
    let (mut at, mut step) = (from, along / 4.0);
    for _ in 0..4 {
        at += step;
        let bend = Vec3::new(dice.between(-0.3, 0.3), dice.between(-0.1, 0.25), dice.between(-0.3, 0.3));
        step = (step + bend * step.length()).normalize_or(Vec3::Y) * step.length();
        points.push(at);
    }
    form.tube(&points, |t| thick * (1.0 - 0.75 * t), 6, false, WOOD);
    points
}

/// Returns a tree of this height with branches and some hundred quads of leaves.
pub(super) fn tree(dice: &mut Dice, height: f32) -> Form {
    let mut form = Form::default();
    let thick = height * dice.between(0.02, 0.035);
    let lean = Vec3::new(dice.between(-0.08, 0.08), 1.0, dice.between(-0.08, 0.08));
    let bare = dice.between(0.25, 0.45);
    let trunk = branch(&mut form, Vec3::Y * -0.1, lean * height * 0.85, thick, dice);
    let spread = height * dice.between(0.25, 0.45);
    let count = dice.whole(9, 16);
    let size = dice.between(0.45, 0.75) * (height / 5.0).sqrt();
    let fullness = dice.whole(16, 32);
    for limb in 0..count {
        let along = bare + (1.0 - bare) * limb as f32 / count as f32;
        let place = along * (trunk.len() - 1) as f32;
        let low = (place as usize).min(trunk.len() - 2);
        let from = trunk[low].lerp(trunk[low + 1], place - low as f32);
        let around = limb as f32 * 2.4 + dice.between(-0.4, 0.4);
        let out = Vec3::new(around.cos(), dice.between(0.2, 0.9), around.sin()).normalize();
        let length = spread * (1.15 - 0.65 * along) * dice.between(0.7, 1.1);
        let points = branch(&mut form, from, out * length, thick * (0.5 - 0.3 * along), dice);
        for _ in 0..fullness {
            let t = dice.between(0.35, 1.0) * (points.len() - 1) as f32;
            let low = (t as usize).min(points.len() - 2);
            let at = points[low].lerp(points[low + 1], t - low as f32);
            let scatter = Vec3::new(dice.between(-1.0, 1.0), dice.between(-0.7, 1.0), dice.between(-1.0, 1.0));
            let scale = size * dice.between(0.7, 1.3);
            leaf(&mut form, at + scatter * 0.28 * size * 2.0, dice.turn(), Vec2::splat(scale));
        }
    }
    form
}

/// Returns a conifer: whorls of branches with needles.
pub(super) fn conifer(dice: &mut Dice, height: f32) -> Form {
    let mut form = Form::default();
    let thick = height * dice.between(0.015, 0.025);
    form.tube(&[Vec3::Y * -0.1, Vec3::Y * height * 0.5, Vec3::Y * height], |t| thick * (1.02 - t), 7, false, WOOD);
    let (rows, spread) = (dice.whole(12, 20), height * dice.between(0.16, 0.28));
    for row in 0..rows {
        let along = row as f32 / rows as f32;
        let reach = spread * (1.0 - along) + 0.08 * height;
        let count = 7 + (8.0 * (1.0 - along)) as usize;
        for branch in 0..count {
            let around = TAU * (branch as f32 + dice.unit()) / count as f32;
            let turn = Quat::from_rotation_y(around) * Quat::from_rotation_x(dice.between(1.5, 2.0));
            let base = Vec3::Y * height * (0.1 + 0.9 * along);
            for twist in [0.0, 1.2] {
                leaf(&mut form, base, turn * Quat::from_rotation_y(twist), Vec2::new(0.65 * reach, reach));
            }
        }
    }
    form
}

/// Returns a bush of leaves without a trunk.
pub(super) fn bush(dice: &mut Dice, height: f32) -> Form {
    let mut form = Form::default();
    let size = height * dice.between(0.3, 0.45);
    for _ in 0..dice.whole(60, 140) {
        let out = dice.turn() * Vec3::X;
        let at = Vec3::new(out.x * 0.55, (0.5 + 0.42 * out.y).max(0.05), out.z * 0.55) * height;
        leaf(&mut form, at - Vec3::Y * 0.3 * size, dice.turn(), Vec2::splat(size));
    }
    form
}

/// Returns a plant in a pot.
pub(super) fn potted(dice: &mut Dice, height: f32) -> Form {
    let mut form = Form::default();
    let (pot, radius) = (height * dice.between(0.25, 0.4), height * dice.between(0.12, 0.2));
    let foot = dice.between(0.6, 0.95);
    let side = line(6, |t| Vec2::new(radius * (foot + (1.0 - foot) * t), pot * t));
    let inside = vec![Vec2::new(0.9 * radius, pot), Vec2::new(0.85 * radius, 0.9 * pot)];
    let base = vec![Vec2::ZERO, side[0]];
    let (rim, soil) = (vec![side[6], inside[0]], vec![inside[1], Vec2::new(0.0, 0.9 * pot)]);
    form.lathe(&[base, side, rim, inside, soil], 24, POT);
    let kind = dice.below(2);
    let count = dice.whole(10, 28);
    for index in 0..count {
        let around = index as f32 * 2.4 + dice.between(-0.3, 0.3);
        let rise = dice.between(0.15, 1.1);
        let length = (height - pot) * dice.between(0.6, 1.0);
        let out = Vec3::new(around.cos() * rise.cos(), rise.sin(), around.sin() * rise.cos());
        let from = Vec3::new(around.cos() * 0.3 * radius, 0.9 * pot, around.sin() * 0.3 * radius);
        match kind {
            0 => {
                form.bar(from, from + out * length * 0.6, 0.004, 5, WOOD);
                let turn = Quat::from_rotation_y(-around + TAU / 4.0) * Quat::from_rotation_x(TAU / 4.0 - rise);
                leaf(&mut form, from + out * length * 0.5, turn, Vec2::new(0.45, 0.6) * length);
            }
            _ => blade(&mut form, from, Vec2::new(around.cos(), around.sin()), length, rise),
        }
    }
    form
}

/// Adds a long leaf without a texture's holes, which bends outwards.
fn blade(form: &mut Form, from: Vec3, out: Vec2, length: f32, rise: f32) {
    let width = 0.07 * length;
    let side = Vec3::new(-out.y, 0.0, out.x);
    let point = |s: f32, t: f32| {
        let bend = rise * (1.0 - 0.9 * t);
        let along = Vec3::new(out.x * bend.cos(), bend.sin(), out.y * bend.cos());
        from + along * length * t + side * width * (2.0 * s - 1.0) * (1.0 - t).max(0.02).sqrt()
    };
    form.sheet([2, 7], false, Vec2::new(width, length), point, POT + 1);
}

/// Returns a tuft of grass of crossed quads.
pub(super) fn tuft(dice: &mut Dice, height: f32) -> Form {
    let mut form = Form::default();
    let start = dice.angle();
    for side in 0..3 {
        let turn = Quat::from_rotation_y(start + side as f32 * TAU / 6.0);
        leaf(&mut form, Vec3::Y * -0.02, turn, Vec2::new(1.1 * height, height));
    }
    form
}
