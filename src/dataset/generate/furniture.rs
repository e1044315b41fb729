//! Furniture. Backs are towards -z, and all pieces stand on the plane y = 0.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::{
    dice::Dice,
    form::{Form, Top},
    materials::Stuff,
    shapes::line,
};

/// A piece of furniture, and what its slots are made of.
pub(super) struct Piece {
    pub(super) name: &'static str,
    pub(super) form: Form,
    pub(super) stuff: &'static [Stuff],
}

fn piece(name: &'static str, stuff: &'static [Stuff], build: impl FnOnce(&mut Form)) -> Piece {
    let mut form = Form::default();
    build(&mut form);
    Piece { name, form, stuff }
}

fn top(form: &mut Form, half: Vec2, y: f32, room: f32) {
    form.tops.push(Top { low: Vec3::new(-half.x, y, -half.y), high: Vec3::new(half.x, y, half.y), room });
}

/// Adds four legs below a rectangle, round or square, straight or splayed.
fn legs(form: &mut Form, half: Vec2, height: f32, thick: f32, dice: &mut Dice, slot: u16) {
    let (is_round, splay) = (dice.chance(0.5), dice.between(0.0, 0.06));
    for (x, z) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let high = Vec3::new(x * (half.x - thick), height, z * (half.y - thick));
        let low = Vec3::new(high.x + x * splay, 0.0, high.z + z * splay);
        match is_round {
            true => form.tube(&[low, high], |t| 0.5 * thick * (0.7 + 0.5 * t), 8, false, slot),
            false => {
                let half = Vec3::new(0.5 * thick, 0.0, 0.5 * thick);
                let foot = Vec3::new(high.x, 0.0, high.z);
                form.cuboid(foot - half, high + half, slot);
            }
        }
    }
}

/// Returns a table with a rectangular or a round top.
pub(super) fn table(dice: &mut Dice, size: Vec3) -> Piece {
    let thick = dice.between(0.02, 0.05);
    let half = Vec2::new(0.5 * size.x, 0.5 * size.z);
    let is_round = dice.chance(0.35);
    piece("table", &[Stuff::Wood, Stuff::Wood, Stuff::Metal], |form| {
        let under = size.y - thick;
        if is_round {
            let radius = half.min_element();
            form.cylinder(radius, [under, size.y], 36, 0);
            if dice.chance(0.5) {
                form.cylinder(0.04, [0.03, under], 12, 1);
                form.cylinder(0.55 * radius, [0.0, 0.03], 28, 1);
            } else {
                legs(form, Vec2::splat(0.68 * radius), under, 0.045, dice, 1);
            }
            top(form, Vec2::splat(0.66 * radius), size.y, 0.6);
        } else {
            form.block(Vec3::new(size.x, thick, size.z), under, 0);
            let slot = dice.pick(&[1, 2]);
            legs(form, half - 0.03, under, dice.between(0.035, 0.08), dice, slot);
            if dice.chance(0.5) {
                form.block(Vec3::new(size.x - 0.16, 0.08, size.z - 0.16), under - 0.08, 1);
            }
            top(form, half - 0.04, size.y, 0.6);
        }
    })
}

/// Returns a chair with slats, bars or a board as its back.
pub(super) fn chair(dice: &mut Dice) -> Piece {
    let (width, depth) = (dice.between(0.38, 0.48), dice.between(0.38, 0.46));
    let (seat, back) = (dice.between(0.42, 0.48), dice.between(0.8, 1.1));
    let kind = dice.below(4);
    piece("chair", &[Stuff::Wood, Stuff::Cloth], |form| {
        let half = Vec2::new(0.5 * width, 0.5 * depth);
        let slot = dice.pick(&[0, 1]);
        form.block(Vec3::new(width, 0.035, depth), seat - 0.035, slot);
        legs(form, half, seat - 0.035, 0.035, dice, 0);
        let lean = dice.between(0.0, 0.12);
        let at = |x: f32, y: f32| Vec3::new(x, y, 0.02 - half.y - lean * (y - seat) / (back - seat));
        for x in [0.02 - half.x, half.x - 0.02] {
            form.bar(at(x, seat - 0.02), at(x, back), 0.017, 8, 0);
        }
        match kind {
            0 => (0..dice.whole(3, 6)).for_each(|bar| {
                let y = back - 0.03 - bar as f32 * 0.08;
                form.bar(at(-half.x, y), at(half.x, y), 0.012, 6, 0);
            }),
            1 => {
                form.bar(at(-half.x, back - 0.02), at(half.x, back - 0.02), 0.02, 8, 0);
                let count = dice.whole(3, 7);
                for bar in 1..count {
                    let x = (bar as f32 / count as f32 - 0.5) * width;
                    form.bar(at(x, seat), at(x, back - 0.02), 0.009, 6, 0);
                }
            }
            _ => {
                let corners = [(-half.x, seat + 0.15), (half.x, seat + 0.15), (half.x, back), (-half.x, back)];
                let front = corners.map(|(x, y)| at(x, y) + Vec3::Z * 0.012);
                let [a, b, c, d] = corners.map(|(x, y)| at(x, y) - Vec3::Z * 0.012);
                form.quad(front, slot);
                form.quad([b, a, d, c], slot);
                form.quad([front[3], front[2], c, d], slot);
                form.quad([a, d, front[3], front[0]], slot);
                form.quad([b, front[1], front[2], c], slot);
            }
        }
    })
}

/// Returns a bookcase with boards to stand things on.
pub(super) fn bookcase(dice: &mut Dice, size: Vec3) -> Piece {
    let board = 0.02;
    let rows = ((size.y / dice.between(0.28, 0.42)) as usize).max(2);
    let has_back = dice.chance(0.7);
    piece("bookcase", &[Stuff::Wood, Stuff::Wood], |form| {
        let half = Vec2::new(0.5 * size.x, 0.5 * size.z);
        for x in [-half.x, half.x - board] {
            form.cuboid(Vec3::new(x, 0.0, -half.y), Vec3::new(x + board, size.y, half.y), 0);
        }
        if has_back {
            let low = Vec3::new(board - half.x, 0.05, -half.y);
            form.cuboid(low, Vec3::new(half.x - board, size.y - board, 0.008 - half.y), 1);
        }
        let step = (size.y - 0.08 - board) / rows as f32;
        for row in 0..=rows {
            let y = 0.08 + row as f32 * step;
            let (low, high) =
                (Vec3::new(board - half.x, y, 0.01 - half.y), Vec3::new(half.x - board, y + board, half.y));
            form.cuboid(low, high, 0);
            let room = if row < rows { step - board - 0.01 } else { 0.4 };
            top(form, half - Vec2::new(0.03, 0.03), y + board, room);
        }
    })
}

/// Returns a cabinet, chest of drawers or wardrobe with doors and knobs.
pub(super) fn cabinet(dice: &mut Dice, size: Vec3) -> Piece {
    let columns = ((size.x / dice.between(0.4, 0.6)).round() as usize).max(1);
    let rows = if size.y > 1.4 { 1 } else { dice.whole(1, 4) };
    piece("cabinet", &[Stuff::Wood, Stuff::Wood, Stuff::Metal], |form| {
        let foot = 0.06;
        let half = Vec2::new(0.5 * size.x, 0.5 * size.z);
        form.block(Vec3::new(size.x - 0.06, foot, size.z - 0.06), 0.0, 0);
        form.block(Vec3::new(size.x, size.y - foot, size.z), foot, 0);
        let cell = Vec2::new(size.x / columns as f32, (size.y - foot) / rows as f32);
        for (column, row) in (0..columns).flat_map(|column| (0..rows).map(move |row| (column, row))) {
            let corner = Vec3::new(column as f32 * cell.x - half.x, foot + row as f32 * cell.y, half.y);
            form.cuboid(
                corner + Vec3::new(0.012, 0.012, 0.0),
                corner + Vec3::new(cell.x - 0.012, cell.y - 0.012, 0.018),
                1,
            );
            let knob = corner + Vec3::new(if rows > 1 { 0.5 } else { 0.88 } * cell.x, 0.55 * cell.y, 0.035);
            form.body(knob, [10, 6], |_| 0.014, 2);
        }
        top(form, half - 0.03, size.y, 0.7);
    })
}

/// Returns a sofa or an armchair.
pub(super) fn sofa(dice: &mut Dice, width: f32) -> Piece {
    let (depth, arm) = (dice.between(0.75, 0.95), dice.between(0.1, 0.2));
    let (seat, back) = (dice.between(0.36, 0.44), dice.between(0.7, 0.95));
    piece("sofa", &[Stuff::Cloth, Stuff::Cloth, Stuff::Wood], |form| {
        let half = Vec2::new(0.5 * width, 0.5 * depth);
        form.block(Vec3::new(width - 0.02, seat - 0.22, depth - 0.02), 0.1, 0);
        let back_front = 0.22 - half.y;
        form.cuboid(Vec3::new(-half.x, 0.1, -half.y), Vec3::new(half.x, back, back_front), 0);
        for x in [-half.x, half.x - arm] {
            let high = Vec3::new(x + arm, seat + 0.2, half.y);
            form.cuboid(Vec3::new(x, 0.1, back_front), high, 0);
        }
        let inner = width - 2.0 * arm;
        let cushions = ((inner / 0.65).round() as usize).max(1);
        for cushion in 0..cushions {
            let pitch = inner / cushions as f32;
            let center =
                Vec3::new(arm - half.x + (cushion as f32 + 0.5) * pitch, seat - 0.05, 0.5 * (back_front + half.y));
            pillow(form, center, Vec3::new(0.49 * pitch, 0.08, 0.5 * (half.y - back_front)), 1);
            let center = Vec3::new(center.x, 0.5 * (seat + back) + 0.06, back_front + 0.07);
            pillow(form, center, Vec3::new(0.47 * pitch, 0.5 * (back - seat), 0.08), 1);
        }
        legs(form, half, 0.1, 0.05, dice, 2);
    })
}

/// Adds a cushion with rounded edges.
fn pillow(form: &mut Form, center: Vec3, half: Vec3, slot: u16) {
    let begin = form.positions.len();
    let reach = |d: Vec3| {
        let d = d.abs().max(Vec3::splat(1e-6));
        (d.x.powf(5.0) + d.y.powf(5.0) + d.z.powf(5.0)).powf(-0.2)
    };
    form.body(Vec3::ZERO, [24, 12], reach, slot);
    form.positions[begin..].iter_mut().for_each(|at| *at = center + *at * half);
}

pub(super) fn bed(dice: &mut Dice, size: Vec3) -> Piece {
    let board = dice.between(0.7, 1.2);
    piece("bed", &[Stuff::Wood, Stuff::Cloth, Stuff::Cloth], |form| {
        let half = Vec2::new(0.5 * size.x, 0.5 * size.z);
        form.block(Vec3::new(size.x, 0.16, size.z), 0.14, 0);
        legs(form, half, 0.14, 0.07, dice, 0);
        form.cuboid(Vec3::new(-half.x, 0.1, -half.y - 0.05), Vec3::new(half.x, board, -half.y), 0);
        pillow(form, Vec3::new(0.0, 0.42, 0.0), Vec3::new(0.97 * half.x, 0.13, 0.97 * half.y), 1);
        let count = if size.x > 1.2 { 2 } else { 1 };
        for pillow_at in 0..count {
            let x = (pillow_at as f32 + 0.5) / count as f32 * size.x - half.x;
            let size = Vec3::new(0.42 * size.x / count as f32, 0.09, 0.2);
            pillow(form, Vec3::new(x, 0.58, 0.3 - half.y), size, 2);
        }
    })
}

/// Returns a lamp with a shade on a stand: on the floor, or small on a table.
pub(super) fn lamp(dice: &mut Dice, height: f32) -> Piece {
    let shade = height.min(0.9) * dice.between(0.2, 0.32);
    let taper = dice.between(0.5, 1.0);
    piece("lamp", &[Stuff::Metal, Stuff::Cloth], |form| {
        let foot = 0.6 * shade;
        form.cylinder(foot, [0.0, 0.02], 24, 0);
        let thick = dice.between(0.008, 0.02);
        form.cylinder(thick, [0.02, height - 0.4 * shade], 10, 0);
        shade_of(form, shade, taper, height, 1);
    })
}

/// Adds a lamp shade that is open above and below, with its upper rim at the height `y`.
fn shade_of(form: &mut Form, radius: f32, taper: f32, y: f32, slot: u16) {
    let wall = |offset: f32| [Vec2::new(radius + offset, y - radius), Vec2::new(taper * radius + offset, y)];
    let [outside, mut inside] = [wall(0.0).to_vec(), wall(-0.006).to_vec()];
    inside.reverse();
    let rims = [vec![outside[1], inside[0]], vec![inside[1], outside[0]]];
    let [above, below] = rims;
    form.lathe(&[outside, above, inside, below], 28, slot);
}

/// Returns a lamp that hangs by a wire from the height `ceiling`.
pub(super) fn pendant(dice: &mut Dice, ceiling: f32) -> Piece {
    let (drop, radius) = (dice.between(0.4, 1.0), dice.between(0.12, 0.28));
    let kind = dice.below(3);
    piece("pendant", &[Stuff::Metal, Stuff::Cloth], |form| {
        let y = ceiling - drop;
        form.bar(Vec3::Y * (ceiling - 0.001), Vec3::Y * y, 0.004, 6, 0);
        form.cylinder(0.05, [ceiling - 0.03, ceiling - 0.001], 16, 0);
        match kind {
            0 => form.body(Vec3::Y * (y - radius), [28, 16], |_| radius, 1),
            1 => shade_of(form, radius, 0.6, y + 0.02, 1),
            _ => {
                let bell =
                    line(10, |t| Vec2::new(radius * (0.5 * PI * (1.0 - t)).sin().max(0.02), y - radius * (1.0 - t)));
                form.lathe(&[bell], 28, 0);
                form.body(Vec3::Y * (y - 0.7 * radius), [14, 8], |_| 0.25 * radius, 1);
            }
        }
    })
}

/// Returns a flight of shelves on a wall, with things standing on it.
pub(super) fn wall_shelf(dice: &mut Dice) -> Piece {
    let (width, depth) = (dice.between(0.5, 1.3), dice.between(0.16, 0.26));
    let rows = dice.whole(1, 3);
    piece("wall shelf", &[Stuff::Wood, Stuff::Metal], |form| {
        for row in 0..rows {
            let y = row as f32 * 0.32;
            form.block(Vec3::new(width, 0.022, depth), y, 0);
            for x in [-0.35 * width, 0.35 * width] {
                form.cuboid(Vec3::new(x - 0.01, y - 0.1, -0.5 * depth), Vec3::new(x + 0.01, y, 0.012 - 0.5 * depth), 1);
            }
            top(form, Vec2::new(0.5 * width - 0.02, 0.5 * depth - 0.015), y + 0.022, 0.26);
        }
    })
}

pub(super) fn stool(dice: &mut Dice) -> Piece {
    let (radius, height) = (dice.between(0.15, 0.22), dice.between(0.42, 0.75));
    piece("stool", &[Stuff::Wood, Stuff::Cloth], |form| {
        form.cylinder(radius, [height - 0.05, height], 28, 1);
        legs(form, Vec2::splat(0.8 * radius), height - 0.05, 0.03, dice, 0);
        top(form, Vec2::splat(0.5 * radius), height, 0.4);
    })
}
