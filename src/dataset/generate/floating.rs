//! Floating objects before a background.

use glam::{Affine3A, DVec3, Vec2, Vec3};

use super::{
    TRIES, World,
    dice::Dice,
    form::Form,
    furniture,
    materials::{Paint, Stuff},
    plants, shapes,
    skies::heaven,
    standing,
};
use crate::{Error, Light};

/// Distance of cameras from objects in metres.
const CLEARANCE: f32 = 0.6;
/// Height of the ground below the cameras in metres.
const DEPTH: f32 = 3.0;
/// Half the width of the ground in metres.
const REACH: f32 = 70.0;

/// Builds objects before the origin, towards -z, and returns cameras near the origin.
pub(super) fn build(world: &mut World<'_>, objects: Option<usize>) -> Result<Vec<[DVec3; 2]>, Error> {
    let heaven = heaven(world.palette.assets(), &mut world.dice.fork())?;
    world.ground()?;
    world.backdrop()?;
    let count = objects.unwrap_or_else(|| world.dice.whole(18, 40));
    for _ in 0..count {
        world.float()?;
    }
    let dice = &mut world.dice;
    let fill = Vec3::new(dice.between(-4.0, 4.0), dice.between(1.0, 6.0), dice.between(1.0, 4.0));
    let scene = &mut world.palette.scene;
    scene.ambient = Some(heaven.ambient * dice.between(0.75, 1.1));
    scene.lights = vec![heaven.sun.light(2.0 * REACH), Light::point(fill, Vec3::splat(dice.between(0.1, 0.3)))];
    scene.sky = heaven.sky;
    Ok(world.views(CLEARANCE, |dice| {
        let eye = Vec3::new(dice.between(-0.8, 0.8), dice.between(-0.6, 0.6), dice.between(-0.6, 1.2));
        let target = Vec3::new(dice.between(-1.2, 1.2), dice.between(-0.8, 0.8), dice.between(-6.0, -5.0));
        [eye, target]
    }))
}

impl World<'_> {
    fn ground(&mut self) -> Result<(), Error> {
        let paint = self.palette.paint(Stuff::Floor)?;
        // Textures of floors are too small for a plain.
        let mut form = Form::default();
        let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
        let points = corners.map(|(x, z)| Vec3::new(x * REACH, -DEPTH, z * REACH));
        let scale = self.dice.between(0.25, 0.6);
        form.quad_with(points, corners.map(|(x, z)| Vec2::new(x, -z) * REACH * scale), 0);
        self.add("ground", &form, &Affine3A::IDENTITY, &[paint])
    }

    /// Adds large boxes, columns and lumps behind the floating objects.
    fn backdrop(&mut self) -> Result<(), Error> {
        let is_wall = self.dice.chance(0.3);
        for index in 0..self.dice.whole(9, 20) {
            let mut dice = self.dice.fork();
            let size = Vec3::new(dice.between(1.5, 7.0), dice.between(3.0, 13.0), dice.between(1.0, 5.0));
            let mut form = Form::default();
            match dice.below(4) {
                0 => form.cylinder(0.4 * size.x, [0.0, size.y], 40, 0),
                1 => form = super::clutter::grounded(shapes::lump(&mut dice).form, size.y),
                _ => form.block(size, 0.0, 0),
            }
            let far = if is_wall { dice.between(11.0, 15.0) } else { dice.between(11.0, 30.0) };
            let across = (index as f32 * 0.618).fract() * 2.0 - 1.0;
            let at = Vec3::new(across * 0.95 * far, -DEPTH, -far);
            let paint = self.palette.textured(Stuff::Any)?;
            let paint = paint.enlarged(dice.between(2.0, 5.0));
            self.put("backdrop", &form, &standing(at, dice.angle()), &[paint])?;
        }
        Ok(())
    }

    /// Adds a floating object in the cone before the camera, if a free place is found.
    fn float(&mut self) -> Result<(), Error> {
        let mut dice = self.dice.fork();
        let (name, form, paints) = self.floating(&mut dice)?;
        let (low, high) = form.bounds();
        let reach = 0.5 * (high - low).length();
        for _ in 0..TRIES {
            let far = dice.between(2.4, 9.5);
            let at = Vec3::new(dice.between(-0.66, 0.66) * far, dice.between(-0.45, 0.45) * far, -far);
            let at = at.with_y(at.y.max(reach + 0.1 - DEPTH));
            let place = Affine3A::from_rotation_translation(dice.turn(), at);
            if at.length() > reach + 1.6 && self.put(name, &form, &place, &paints)? {
                break;
            }
        }
        Ok(())
    }

    /// Returns an object around the origin, with its paints.
    fn floating(&mut self, dice: &mut Dice) -> Result<(&'static str, Form, Vec<Paint>), Error> {
        let size = dice.log_between(0.35, 2.0);
        if dice.chance(0.5)
            && let Some((form, paints)) = self.model([0.4, 1.8])?
        {
            let (low, high) = form.bounds();
            return Ok(("mesh", form.centred((high - low).max_element()), paints));
        }
        Ok(match dice.below(12) {
            0 => {
                let chair = furniture::chair(dice);
                (chair.name, chair.form.centred(size.max(0.7)), self.paints(chair.stuff, false)?)
            }
            1 => {
                let table = furniture::table(dice, Vec3::new(1.2, 0.75, 0.8));
                (table.name, table.form.centred(size.max(0.8)), self.paints(table.stuff, false)?)
            }
            2 => {
                let height = size.max(0.6);
                ("plant", plants::potted(dice, height).centred(height), self.plant_paints()?)
            }
            _ => {
                let shape = shapes::any(dice);
                let paints = self.paints(&[Stuff::Any, Stuff::Any], shape.is_closed)?;
                (shape.name, shape.form.centred(size), paints)
            }
        })
    }
}
