//! Random materials of a scene.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};

use super::{
    Shares,
    assets::Assets,
    dice::Dice,
    textures::{Pattern, SIDE, texture},
};
use crate::{Error, Finish, Material, MaterialId, Scene, Texture, TextureId};

/// Maximum number of textures that a scene has made for it.
const MOST_TEXTURES: usize = 13;
/// Maximum number of leaf textures of a kind in a scene.
const MOST_LEAVES: usize = 3;
/// Share of patterned surfaces that show a picture of the user's folder, if there is one.
const PICTURES: f32 = 0.5;

/// A material, and how its texture lies on surfaces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Paint {
    pub(super) material: MaterialId,
    /// Length in metres that the texture's width takes, or 0 for a texture that fills the surface's 0 to 1.
    tile: f32,
    is_textured: bool,
}

impl Paint {
    /// Returns the paint with its texture enlarged by this factor.
    pub(super) fn enlarged(self, factor: f32) -> Self {
        Self { tile: self.tile * factor, ..self }
    }

    /// Returns texture coordinates for a place in metres.
    pub(super) fn coordinates(&self, metres: Vec2) -> Vec2 {
        if self.tile > 0.0 { metres / self.tile } else { metres }
    }
}

/// The kind of a surface's material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Stuff {
    Wall,
    Floor,
    Ceiling,
    Wood,
    Cloth,
    Ceramic,
    Metal,
    Stone,
    Card,
    Soil,
    Grass,
    Bark,
    /// Anything, such as for toys and floating objects.
    Any,
}

/// Makes the materials of a scene. Later surfaces of a kind often get the material of an earlier one.
pub(super) struct Palette<'a> {
    pub(super) scene: Scene,
    assets: &'a Assets,
    shares: Shares,
    dice: Dice,
    /// Hues of this scene in turns.
    hues: [f32; 3],
    known: BTreeMap<Stuff, Vec<Paint>>,
    leaves: Vec<(Pattern, Paint)>,
    made: usize,
    pictures: BTreeMap<usize, TextureId>,
}

impl<'a> Palette<'a> {
    pub(super) fn new(assets: &'a Assets, shares: Shares, mut dice: Dice) -> Self {
        let hue = dice.unit();
        let hues = [hue, hue + dice.between(0.08, 0.5), hue + dice.between(0.3, 0.9)];
        let (known, pictures) = (BTreeMap::new(), BTreeMap::new());
        Self { scene: prepared(), assets, shares, dice, hues, known, leaves: Vec::new(), made: 0, pictures }
    }

    /// Returns a paint for a surface of an object, which may be metal, glass or a mirror by the scene's shares. Only
    /// closed objects can be glass.
    pub(super) fn object(&mut self, stuff: Stuff, is_closed: bool) -> Result<Paint, Error> {
        let kind = self.dice.unit();
        let Shares { metals, glass, mirrors, .. } = self.shares;
        if kind < mirrors {
            return Ok(self.mirror());
        }
        if kind < mirrors + glass && is_closed {
            return Ok(self.glass());
        }
        if kind < mirrors + glass + metals && kind >= mirrors + glass {
            return Ok(self.metal());
        }
        self.paint(stuff)
    }

    /// Returns a paint for a surface.
    pub(super) fn paint(&mut self, stuff: Stuff) -> Result<Paint, Error> {
        let known = self.known.get(&stuff).map_or(&[][..], |known| known);
        let reuse = if self.made >= MOST_TEXTURES { 1.0 } else { (0.25 * known.len() as f32).min(0.75) };
        if !known.is_empty() && self.dice.chance(reuse) {
            return Ok(self.dice.pick(known));
        }
        let paint = if stuff == Stuff::Metal { self.metal() } else { self.fresh(stuff, true)? };
        self.known.entry(stuff).or_default().push(paint);
        Ok(paint)
    }

    /// Returns a paint with a texture.
    pub(super) fn textured(&mut self, stuff: Stuff) -> Result<Paint, Error> {
        let textured: Vec<Paint> =
            self.known.get(&stuff).into_iter().flatten().copied().filter(|paint| paint.is_textured).collect();
        if self.made >= MOST_TEXTURES && !textured.is_empty() {
            return Ok(self.dice.pick(&textured));
        }
        let paint = self.fresh(stuff, false)?;
        self.known.entry(stuff).or_default().push(paint);
        Ok(paint)
    }

    fn fresh(&mut self, stuff: Stuff, may_be_plain: bool) -> Result<Paint, Error> {
        let (patterns, tile, gloss) = kinds(stuff);
        let tile = self.dice.log_between(tile[0], tile[1]);
        let plain = may_be_plain && matches!(stuff, Stuff::Ceramic | Stuff::Any) && self.dice.chance(0.15);
        let mut material = Material::new(Vec3::ONE);
        let takes_pictures = !matches!(stuff, Stuff::Grass | Stuff::Soil | Stuff::Bark | Stuff::Ceiling);
        if self.shares.plain > 0.0 && self.dice.chance(self.shares.plain) {
            material.albedo = self.color(stuff);
        } else if takes_pictures && self.assets.has_textures() && self.dice.chance(PICTURES) {
            material = material.texture(self.picture()?);
        } else if plain || (may_be_plain && self.made >= MOST_TEXTURES) {
            material.albedo = self.color(stuff);
        } else {
            let colors = [self.color(stuff), self.color(stuff)];
            let pattern = self.dice.pick(patterns);
            material = material.texture(self.made_texture(pattern, colors));
        }
        if self.dice.chance(gloss) {
            let shine = self.dice.between(0.04, 0.3);
            material = material.specular(Vec3::splat(shine)).exponent(self.dice.log_between(12.0, 120.0));
        }
        // Whitest paint returns some 85% of the light.
        material.albedo *= 0.88;
        let is_textured = material.texture.is_some();
        Ok(Paint { material: self.scene.add_material(material), tile, is_textured })
    }

    fn made_texture(&mut self, pattern: Pattern, colors: [Vec3; 2]) -> TextureId {
        self.made += 1;
        self.scene.add_texture(texture(pattern, colors, SIDE, &mut self.dice))
    }

    /// Returns a picture of the user's folder.
    fn picture(&mut self) -> Result<TextureId, Error> {
        let index = self.dice.below(self.assets.texture_count());
        if let Some(known) = self.pictures.get(&index) {
            return Ok(*known);
        }
        let texture = self.scene.add_texture(self.assets.texture(index)?);
        self.pictures.insert(index, texture);
        Ok(texture)
    }

    /// Returns a paint that shows one pattern or picture over texture coordinates from 0 to 1.
    pub(super) fn poster(&mut self, pattern: Pattern) -> Result<Paint, Error> {
        let picture = if self.assets.has_textures() && self.dice.chance(PICTURES) {
            self.picture()?
        } else {
            let colors = [self.color(Stuff::Any), self.color(Stuff::Card)];
            self.made_texture(pattern, colors)
        };
        let material = Material::new(Vec3::splat(0.9)).texture(picture);
        Ok(Paint { material: self.scene.add_material(material), tile: 0.0, is_textured: true })
    }

    /// Returns a paint with a repeating pattern, whose width takes `tile` metres.
    pub(super) fn patterned(&mut self, pattern: Pattern, stuff: Stuff, tile: f32) -> Paint {
        let colors = [self.color(stuff), self.color(stuff)];
        let texture = self.made_texture(pattern, colors);
        let material = Material::new(Vec3::splat(0.88)).texture(texture);
        Paint { material: self.scene.add_material(material), tile, is_textured: true }
    }

    /// Returns a paint of the ground, with a larger texture.
    pub(super) fn ground(&mut self, pattern: Pattern, stuff: Stuff, tile: f32) -> Paint {
        let colors = [self.color(stuff), self.color(stuff)];
        self.made += 1;
        let texture = self.scene.add_texture(texture(pattern, colors, 2 * SIDE, &mut self.dice));
        let material = Material::new(Vec3::splat(0.88)).texture(texture);
        Paint { material: self.scene.add_material(material), tile, is_textured: true }
    }

    /// Returns a paint of leaves with holes between them, over texture coordinates from 0 to 1.
    pub(super) fn foliage(&mut self, pattern: Pattern) -> Paint {
        let known: Vec<Paint> =
            self.leaves.iter().filter(|(other, _)| *other == pattern).map(|(_, paint)| *paint).collect();
        if known.len() >= MOST_LEAVES {
            return self.dice.pick(&known);
        }
        let colors = [self.color(Stuff::Grass), self.color(Stuff::Grass)];
        let texture = self.made_texture(pattern, colors);
        let material = Material::new(Vec3::splat(0.95)).texture(texture).cutout(texture);
        let paint = Paint { material: self.scene.add_material(material), tile: 0.0, is_textured: true };
        self.leaves.push((pattern, paint));
        paint
    }

    /// Returns a plain paint.
    pub(super) fn plain(&mut self, color: Vec3, shine: f32) -> Paint {
        let material = Material::new(color).specular(Vec3::splat(shine)).exponent(50.0);
        Paint { material: self.scene.add_material(material), tile: 1.0, is_textured: false }
    }

    /// Returns a paint that shines by itself.
    pub(super) fn glowing(&mut self) -> Paint {
        let warm = Vec3::new(1.0, self.dice.between(0.8, 1.0), self.dice.between(0.55, 0.95));
        let material = Material::new(Vec3::splat(0.5)).emission(0.75 * warm);
        Paint { material: self.scene.add_material(material), tile: 1.0, is_textured: false }
    }

    pub(super) fn metal(&mut self) -> Paint {
        let tints = [[0.92, 0.92, 0.94], [0.95, 0.75, 0.4], [0.9, 0.58, 0.42], [0.6, 0.62, 0.66], [0.42, 0.42, 0.45]];
        let tint = Vec3::from_array(self.dice.pick(&tints));
        let material = Material::new(0.42 * tint).specular(0.5 * tint);
        let material = match self.dice.chance(0.4) {
            true => material.exponent(120.0).finish(Finish::Mirror { fresnel: false }),
            false => material.exponent(self.dice.log_between(10.0, 90.0)),
        };
        Paint { material: self.scene.add_material(material), tile: 1.0, is_textured: false }
    }

    pub(super) fn mirror(&mut self) -> Paint {
        let material = Material::new(Vec3::splat(0.02)).specular(Vec3::splat(self.dice.between(0.78, 0.92)));
        let material = material.exponent(400.0).finish(Finish::Mirror { fresnel: false });
        Paint { material: self.scene.add_material(material), tile: 1.0, is_textured: false }
    }

    pub(super) fn glass(&mut self) -> Paint {
        let tint = hsv(self.dice.unit(), self.dice.between(0.0, 0.25), 0.97);
        let finish = Finish::Glass { index: self.dice.between(1.3, 1.6), transmission: tint, fresnel: true };
        let material = Material::new(Vec3::ZERO).specular(Vec3::splat(0.04)).exponent(200.0).finish(finish);
        Paint { material: self.scene.add_material(material), tile: 1.0, is_textured: false }
    }

    /// Returns a paint of thin window glass, which hides little of what is behind it.
    pub(super) fn pane(&mut self) -> Paint {
        let material = Material::new(Vec3::splat(0.5)).opacity(0.07).specular(Vec3::splat(0.1)).exponent(300.0);
        Paint { material: self.scene.add_material(material), tile: 1.0, is_textured: false }
    }

    /// Draws a linear colour.
    fn color(&mut self, stuff: Stuff) -> Vec3 {
        let dice = &mut self.dice;
        let mut around = |hue: f32, width: f32| hue + dice.between(-width, width);
        let (hue, saturation, bright) = match stuff {
            Stuff::Wood | Stuff::Bark => (around(0.075, 0.03), [0.35, 0.7], [0.25, 0.75]),
            Stuff::Stone | Stuff::Soil => (around(0.09, 0.06), [0.05, 0.3], [0.35, 0.75]),
            Stuff::Grass => (around(0.24, 0.06), [0.35, 0.7], [0.35, 0.7]),
            Stuff::Ceiling => (around(0.1, 0.1), [0.0, 0.06], [0.85, 1.0]),
            Stuff::Wall => (around(0.0, 0.5), [0.02, 0.3], [0.6, 0.95]),
            Stuff::Floor => (around(0.08, 0.05), [0.05, 0.5], [0.35, 0.8]),
            Stuff::Metal | Stuff::Card => (around(0.1, 0.1), [0.05, 0.4], [0.5, 0.9]),
            Stuff::Cloth | Stuff::Ceramic | Stuff::Any => {
                let hue = if dice.chance(0.6) { self.hues[dice.below(3)] } else { dice.unit() };
                let most = if dice.chance(0.25) { 0.9 } else { 0.55 };
                (hue + dice.between(-0.06, 0.06), [0.05, most], [0.4, 0.95])
            }
        };
        let (saturation, bright) =
            (self.dice.between(saturation[0], saturation[1]), self.dice.between(bright[0], bright[1]));
        hsv(hue, saturation, bright)
    }

    /// Returns a paint of a material that is complete.
    pub(super) fn given(&mut self, material: Material) -> Paint {
        Paint { material: self.scene.add_material(material), tile: 0.0, is_textured: true }
    }

    pub(super) fn assets(&self) -> &'a Assets {
        self.assets
    }
}

/// Returns a scene with unused materials of all kinds. So all scenes use the same pipelines, which take seconds to
/// compile.
fn prepared() -> Scene {
    let mut scene = Scene::new();
    let texture = scene.add_texture(solid());
    scene.add_material(Material::new(Vec3::ZERO).texture(texture).cutout(texture).specular(Vec3::splat(0.5)));
    scene.add_material(Material::new(Vec3::ZERO).finish(Finish::Mirror { fresnel: false }));
    scene
}

/// Returns a texture of one white pixel.
fn solid() -> Texture {
    Texture::image(1, 1, vec![[255; 4]]).unwrap_or_else(|error| unreachable!("{error}"))
}

/// Returns the patterns of a kind of surface, the smallest and largest width of a texture in metres, and the share of
/// glossy surfaces.
fn kinds(stuff: Stuff) -> (&'static [Pattern], [f32; 2], f32) {
    use Pattern::*;
    match stuff {
        Stuff::Wall => {
            (&[Plaster, Plaster, Plaster, Bricks, Stripes, Plaid, Dots, Planks, Tiles, Speckle], [0.7, 2.2], 0.1)
        }
        Stuff::Floor => (&[Planks, Planks, Tiles, Checks, Marble, Speckle, Weave, Plaid], [0.8, 2.2], 0.4),
        Stuff::Ceiling => (&[Plaster, Plaster, Tiles], [1.2, 2.4], 0.0),
        Stuff::Wood => (&[Grain, Grain, Planks], [0.4, 1.2], 0.4),
        Stuff::Cloth => (&[Weave, Plaid, Stripes, Dots, Patches, Checks], [0.25, 0.9], 0.0),
        Stuff::Ceramic => (&[Marble, Speckle, Stripes, Dots, Patches], [0.2, 0.6], 0.7),
        Stuff::Stone => (&[Marble, Speckle, Plaster, Gravel], [0.5, 1.8], 0.1),
        Stuff::Card => (&[Glyphs, Glyphs, Painting, Plaster], [0.25, 0.6], 0.1),
        Stuff::Soil => (&[Gravel, Plaster, Patches, Speckle], [1.0, 3.0], 0.0),
        Stuff::Grass => (&[Grass], [1.5, 4.0], 0.0),
        Stuff::Bark => (&[Bark], [0.4, 0.9], 0.0),
        Stuff::Metal | Stuff::Any => (
            &[Marble, Grain, Bricks, Checks, Stripes, Plaid, Speckle, Weave, Dots, Glyphs, Painting, Patches, Gravel],
            [0.3, 1.2],
            0.4,
        ),
    }
}

/// Returns a linear colour by hue in turns, saturation and encoded brightness.
pub(super) fn hsv(hue: f32, saturation: f32, bright: f32) -> Vec3 {
    let channel = |offset: f32| {
        let place = (6.0 * hue + offset).rem_euclid(6.0);
        bright * (1.0 - saturation * (place.min(4.0 - place)).clamp(0.0, 1.0))
    };
    Vec3::new(channel(5.0), channel(3.0), channel(1.0)).powf(2.2)
}
