//! Furnished rooms.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Affine3A, DVec3, Quat, Vec2, Vec3};

use super::{
    TRIES, World, clutter,
    form::Form,
    furniture::{self, Piece},
    materials::Stuff,
    plants, shapes,
    shell::{Wall, walls},
    skies::heaven,
    standing,
    textures::Pattern,
};
use crate::{Error, Light};

/// Distance of cameras from surfaces in metres.
const CLEARANCE: f32 = 0.35;

/// Builds a room, and returns cameras at eye height.
pub(super) fn build(world: &mut World<'_>, objects: Option<usize>) -> Result<Vec<[DVec3; 2]>, Error> {
    let dice = &mut world.dice;
    let size = Vec3::new(dice.between(3.2, 7.5), dice.between(2.4, 3.3), dice.between(3.2, 7.5));
    let walls = walls(size, dice);
    let count = objects.unwrap_or_else(|| dice.whole(9, 18));
    world.limits = size;
    world.shell(size, &walls)?;
    world.rug(size)?;
    for index in 0..count {
        match (index, world.dice.below(10)) {
            (0, _) | (_, 0) => world.dining(size)?,
            (_, 1..=5) => world.against(&walls)?,
            (_, 6 | 7) => world.hang(&walls, size)?,
            _ => world.on_floor(size)?,
        }
    }
    world.lights(size)?;
    let height = world.dice.between(1.05, 1.75);
    Ok(world.views(CLEARANCE, |dice| {
        let (low, high) = (Vec3::splat(0.45), size - 0.45);
        let eye = Vec3::new(dice.between(low.x, high.x), height.min(size.y - 0.5), dice.between(low.z, high.z));
        // Targets across the room show more of it than the nearest wall does.
        let across = size * Vec3::new(1.0, 0.0, 1.0) - eye * Vec3::new(1.0, 0.0, 1.0);
        let aside = Vec3::new(dice.between(-1.3, 1.3), dice.between(-1.1, 0.25), dice.between(-1.3, 1.3));
        [eye, across.with_y(height) + aside]
    }))
}

impl World<'_> {
    fn rug(&mut self, size: Vec3) -> Result<(), Error> {
        if !self.dice.chance(0.55) {
            return Ok(());
        }
        let half =
            Vec2::new(size.x, size.z) * 0.5 * Vec2::new(self.dice.between(0.35, 0.7), self.dice.between(0.35, 0.7));
        let mut rug = Form::default();
        if self.dice.chance(0.3) {
            rug.cylinder(half.min_element(), [0.0, 0.008], 48, 0);
        } else {
            rug.block(Vec3::new(2.0 * half.x, 0.008, 2.0 * half.y), 0.0, 0);
        }
        let paint = self.palette.paint(Stuff::Cloth)?;
        self.add("rug", &rug, &standing(Vec3::new(0.5 * size.x, 0.0, 0.5 * size.z), 0.0), &[paint])
    }

    /// Puts a table with chairs on the floor, or a low table.
    fn dining(&mut self, size: Vec3) -> Result<(), Error> {
        let is_low = self.dice.chance(0.35);
        let mut dice = self.dice.fork();
        let extent = match is_low {
            true => Vec3::new(dice.between(0.6, 1.2), dice.between(0.35, 0.48), dice.between(0.45, 0.7)),
            false => Vec3::new(dice.between(0.9, 2.0), dice.between(0.71, 0.77), dice.between(0.75, 1.0)),
        };
        let table = furniture::table(&mut dice, extent);
        let paints = self.paints(table.stuff, false)?;
        for _ in 0..TRIES {
            let at = self.on_ground(size, 0.5 * extent.x.max(extent.z) + 0.15);
            let turn = self.dice.pick(&[0.0, FRAC_PI_2]) + self.dice.between(-0.06, 0.06);
            let place = standing(at, turn);
            if self.put(table.name, &table.form, &place, &paints)? {
                self.fill(&table.form, &place, 4.5)?;
                if !is_low {
                    self.chairs(extent, &place)?;
                }
                break;
            }
        }
        Ok(())
    }

    /// Puts chairs around a table, some drawn back or turned.
    fn chairs(&mut self, table: Vec3, place: &Affine3A) -> Result<(), Error> {
        let chair = furniture::chair(&mut self.dice.fork());
        let paints = self.paints(chair.stuff, false)?;
        let per_side = ((table.x / 0.65) as usize).max(1);
        for (side, index) in [0.0, PI].into_iter().flat_map(|side| (0..per_side).map(move |index| (side, index))) {
            if !self.dice.chance(0.8) {
                continue;
            }
            let x = ((index as f32 + 0.5) / per_side as f32 - 0.5) * table.x;
            let out = 0.5 * table.z + self.dice.between(0.02, 0.4);
            let local = Quat::from_rotation_y(side) * Vec3::new(x, 0.0, -out);
            let turn = side + self.dice.between(-0.35, 0.35);
            self.put_inside(&chair, &(*place * standing(local, turn)), &paints)?;
        }
        Ok(())
    }

    fn put_inside(
        &mut self,
        piece: &Piece,
        place: &Affine3A,
        paints: &[super::materials::Paint],
    ) -> Result<bool, Error> {
        let solid = super::Solid::of(&piece.form, place);
        let inside = solid.low.min_element() >= -1e-3 && solid.high.cmple(self.limits).all();
        Ok(inside && self.put(piece.name, &piece.form, place, paints)?)
    }

    /// Puts a piece of furniture with its back to a wall.
    fn against(&mut self, walls: &[Wall]) -> Result<(), Error> {
        let mut dice = self.dice.fork();
        let piece = match dice.below(9) {
            0 | 1 => {
                let extent = Vec3::new(dice.between(0.6, 1.4), dice.between(1.2, 2.2), dice.between(0.25, 0.36));
                furniture::bookcase(&mut dice, extent)
            }
            2 | 3 => {
                let extent = Vec3::new(dice.between(0.6, 1.8), dice.between(0.5, 1.0), dice.between(0.38, 0.5));
                furniture::cabinet(&mut dice, extent)
            }
            4 => {
                let extent = Vec3::new(dice.between(0.9, 1.6), dice.between(1.7, 2.1), dice.between(0.5, 0.62));
                furniture::cabinet(&mut dice, extent)
            }
            5 | 6 => {
                let width = dice.between(0.85, 2.3);
                furniture::sofa(&mut dice, width)
            }
            7 => {
                let extent = Vec3::new(dice.between(0.9, 1.7), 1.0, dice.between(1.9, 2.1));
                furniture::bed(&mut dice, extent)
            }
            _ => {
                let extent = Vec3::new(dice.between(0.9, 1.5), dice.between(0.71, 0.76), dice.between(0.5, 0.7));
                furniture::table(&mut dice, extent)
            }
        };
        let paints = self.paints(piece.stuff, false)?;
        let (low, high) = piece.form.bounds();
        for _ in 0..TRIES {
            let wall = &walls[self.dice.below(4)];
            let half = 0.5 * (high.x - low.x);
            let x = self.dice.between(half, wall.width - half);
            let is_tall = high.y > 0.9;
            let clear = wall.opening.is_none_or(|opening| {
                let beside = x + half < opening.low.x || x - half > opening.high.x;
                beside || (wall.is_window && !is_tall && high.y < opening.low.y + 0.1)
            });
            let place = wall.to_world * standing(Vec3::new(x, 0.0, 0.02 - low.z), 0.0);
            if clear && half < 0.5 * wall.width && self.put_inside(&piece, &place, &paints)? {
                let fullness = if piece.name == "bookcase" { 7.0 } else { 4.0 };
                self.fill(&piece.form, &place, fullness)?;
                break;
            }
        }
        Ok(())
    }

    /// Hangs a picture, a mirror, shelves or a lamp.
    fn hang(&mut self, walls: &[Wall], size: Vec3) -> Result<(), Error> {
        match self.dice.below(7) {
            0 => return self.hang_lamp(size),
            1 | 2 => return self.hang_shelf(walls),
            _ => {}
        }
        let extent = Vec2::new(self.dice.between(0.3, 1.2), self.dice.between(0.3, 0.9));
        let border = self.dice.between(0.015, 0.06);
        let mut form = Form::default();
        let half = 0.5 * extent;
        let inner = half - border;
        for (low, high) in [
            (Vec2::new(-half.x, -half.y), Vec2::new(half.x, -inner.y)),
            (Vec2::new(-half.x, inner.y), Vec2::new(half.x, half.y)),
            (Vec2::new(-half.x, -inner.y), Vec2::new(-inner.x, inner.y)),
            (Vec2::new(inner.x, -inner.y), Vec2::new(half.x, inner.y)),
        ] {
            form.cuboid(low.extend(0.0), high.extend(0.025), 0);
        }
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let points = corners.map(|(x, y)| Vec3::new(x * inner.x, y * inner.y, 0.008));
        form.quad_with(points, corners.map(|(x, y)| Vec2::new(0.5 + 0.5 * x, 0.5 + 0.5 * y)), 1);
        let frame = self.palette.object(Stuff::Wood, false)?;
        let image = match self.dice.below(6) {
            0 => self.palette.mirror(),
            1 => self.palette.poster(Pattern::Glyphs)?,
            _ => self.palette.poster(Pattern::Painting)?,
        };
        for _ in 0..TRIES {
            let wall = &walls[self.dice.below(4)];
            let x = self.dice.between(half.x, wall.width - half.x);
            let y = self.dice.between(1.1 + half.y, (size.y - 0.15 - half.y).max(1.15 + half.y));
            let place = wall.to_world * Affine3A::from_translation(Vec3::new(x, y, 0.014));
            let is_apart = wall
                .opening
                .is_none_or(|opening| x + half.x < opening.low.x - 0.1 || x - half.x > opening.high.x + 0.1);
            if is_apart && y + half.y < size.y && self.put("picture", &form, &place, &[frame, image])? {
                break;
            }
        }
        Ok(())
    }

    fn hang_shelf(&mut self, walls: &[Wall]) -> Result<(), Error> {
        let shelf = furniture::wall_shelf(&mut self.dice.fork());
        let paints = self.paints(shelf.stuff, false)?;
        let (low, high) = shelf.form.bounds();
        for _ in 0..TRIES {
            let wall = &walls[self.dice.below(4)];
            let x = self.dice.between(high.x, wall.width - high.x);
            let is_apart = wall.opening.is_none_or(|opening| x + high.x < opening.low.x || x + low.x > opening.high.x);
            let place = wall.to_world * standing(Vec3::new(x, self.dice.between(1.1, 1.5), 0.005 - low.z), 0.0);
            if is_apart && self.put_inside(&shelf, &place, &paints)? {
                self.fill(&shelf.form, &place, 6.0)?;
                break;
            }
        }
        Ok(())
    }

    fn hang_lamp(&mut self, size: Vec3) -> Result<(), Error> {
        let lamp = furniture::pendant(&mut self.dice.fork(), size.y);
        let metal = self.palette.metal();
        let paints = [metal, self.palette.glowing()];
        let at = self.on_ground(size, 0.7);
        self.put(lamp.name, &lamp.form, &standing(at, 0.0), &paints).map(drop)
    }

    /// Puts a plant, a lamp, a stool, a box, a ball or a cable on the floor.
    fn on_floor(&mut self, size: Vec3) -> Result<(), Error> {
        let mut dice = self.dice.fork();
        let (name, form, paints) = match dice.below(8) {
            0 | 1 => {
                let height = dice.between(0.5, 1.7);
                ("plant", plants::potted(&mut dice, height), self.plant_paints()?)
            }
            2 => {
                let height = dice.between(1.3, 1.8);
                let lamp = furniture::lamp(&mut dice, height);
                (lamp.name, lamp.form, self.paints(lamp.stuff, false)?)
            }
            3 => {
                let stool = furniture::stool(&mut dice);
                (stool.name, stool.form, self.paints(stool.stuff, false)?)
            }
            4 => {
                let length = dice.between(0.8, 2.2);
                ("cable", clutter::cable(&mut dice, length), vec![self.palette.plain(Vec3::splat(0.08), 0.1)])
            }
            5 if self.palette.assets().mesh_count() > 0 => match self.model([0.4, 1.2])? {
                Some((form, paints)) => ("mesh", form, paints),
                None => return Ok(()),
            },
            _ => {
                let shape = shapes::any(&mut dice);
                let paints = self.paints(&[Stuff::Any, Stuff::Any], shape.is_closed)?;
                (shape.name, clutter::grounded(shape.form, dice.between(0.2, 0.55)), paints)
            }
        };
        for _ in 0..TRIES {
            let (low, high) = form.bounds();
            let reach = low.abs().max(high.abs()).with_y(0.0).max_element();
            let at = self.on_ground(size, reach.min(1.2) + 0.03) + Vec3::Y * 0.009;
            let place = standing(at, self.dice.angle());
            let piece = Piece { name, form: form.clone(), stuff: &[] };
            if self.put_inside(&piece, &place, &paints)? {
                self.fill(&form, &place, 4.0)?;
                break;
            }
        }
        Ok(())
    }

    /// Returns a place on the floor, at least this far from the walls.
    fn on_ground(&mut self, size: Vec3, inset: f32) -> Vec3 {
        let mut along = |length: f32| {
            let inset = inset.min(0.5 * length);
            self.dice.between(inset, length - inset)
        };
        Vec3::new(along(size.x), 0.0, along(size.z))
    }

    /// Lights the room: lamps near the ceiling, and a sky and sometimes the sun through the windows.
    fn lights(&mut self, size: Vec3) -> Result<(), Error> {
        let heaven = heaven(self.palette.assets(), &mut self.dice.fork())?;
        let dice = &mut self.dice;
        let count = 2;
        let total = dice.between(0.7, 0.95);
        let warmth = dice.between(0.0, 0.3);
        let warm = Vec3::new(1.0, 1.0 - 0.4 * warmth, 1.0 - warmth);
        let shares: Vec<f32> = (0..count).map(|_| dice.between(0.3, 1.0)).collect();
        let sum: f32 = shares.iter().sum();
        let mut lights = Vec::new();
        for share in shares {
            let at = Vec3::new(dice.between(0.15, 0.85), 0.0, dice.between(0.15, 0.85)) * size;
            let at = at.with_y(size.y - dice.between(0.12, 0.4));
            lights.push(Light::point(at, warm * total * share / sum));
        }
        let has_sun = dice.chance(0.5);
        let ambient = dice.between(0.3, 0.44);
        if has_sun {
            lights.push(heaven.sun.light(size.max_element()));
        }
        let scene = &mut self.palette.scene;
        (scene.lights, scene.sky, scene.ambient) = (lights, heaven.sky, Some(ambient * warm.lerp(Vec3::ONE, 0.5)));
        Ok(())
    }
}
