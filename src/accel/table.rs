//! The shading table: the scene data that shading reads, as texels (`shaders/shared/{shade,materials,textures}.wgsl`).

use std::{iter, sync::OnceLock};

use glam::{Vec3, Vec4};
use half::f16;

use super::{emitters::Emitters, facets};
use crate::{
    Cone, Falloff, Finish, Light, LightShape, Material, Principled, Projector, Scene, Sky, SkyMap, Texture, TextureId,
    TextureKind, Wrap,
    gpu::Texel,
    kernel::variant::{light_texels, material_texels},
    srgb::BRIGHTNESS,
    srgb::linear_of,
};

/// Number of texels before the lights.
const HEAD: usize = 3;

/// Kind of a checkerboard texture; `CHECKERBOARD` in textures.wgsl.
const CHECKERBOARD: u32 = 1;

/// Sky and textures of a shading table, and their offset. They follow the lights and materials in the table. A change
/// of lighting does not change them.
#[derive(Clone, Debug)]
pub(crate) struct Pictures {
    at: usize,
    sky: Option<SkyMap>,
    textures: Vec<Texture>,
    /// Set as soon as the texels of the sky map contain their sampling weights.
    weighed: OnceLock<()>,
}

impl Pictures {
    pub(crate) fn of(scene: &Scene) -> Self {
        let sky = if let Sky::Map(map) = &scene.sky { Some(map.clone()) } else { None };
        let table = ShadingTable::of(scene);
        let textures = table.textures().to_vec();
        Self { at: table.before_pictures(), sky, textures, weighed: OnceLock::new() }
    }

    /// Returns the index of the sky map's first texel, and its texels with their sampling weights. Returns `None`
    /// without a sky map, or if the uploaded texels already have weights.
    pub(crate) fn sky_to_weigh(&self) -> Option<(usize, impl Iterator<Item = Texel> + Send + use<'_>)> {
        let sky = self.sky.as_ref().filter(|_| self.weighed.get().is_none())?;
        let weights = weights_of(sky);
        let weighed = |(pixel, weight): (&Vec3, f32)| texel(*pixel, weight.to_bits());
        Some((self.at, sky.pixels().iter().zip(weights).map(weighed)))
    }

    pub(crate) fn set_weighed(&self) {
        let _ = self.weighed.set(());
    }

    /// Returns whether the scene's table has the same sky and textures at the same offset.
    pub(crate) fn are_those_of(&self, scene: &Scene) -> bool {
        let other = Self::of(scene);
        let same_sky = match (&self.sky, &other.sky) {
            (Some(sky), Some(other)) => sky.shares_pixels(other),
            (None, None) => true,
            _ => false,
        };
        same_sky && self.at == other.at && self.textures == other.textures
    }
}

/// The shading table of a scene.
pub(crate) struct ShadingTable<'a> {
    scene: &'a Scene,
    /// Number of texels per material.
    each: usize,
    /// Number of texels per light.
    each_light: usize,
    /// Emitting primitives, found when they are first needed.
    emitters: OnceLock<Emitters>,
}

impl<'a> ShadingTable<'a> {
    pub(crate) fn of(scene: &'a Scene) -> Self {
        let more = |material: &Material| material.shines() || material.sends_rays();
        let each = material_texels(scene.materials().iter().any(more), scene.has_principled(), scene.has_coats());
        Self {
            scene,
            each,
            each_light: light_texels(
                scene.soft_lights().next().is_some(),
                scene.has_fading_lights(),
                scene.has_projectors(),
            ),
            emitters: OnceLock::new(),
        }
    }

    fn emitters(&self) -> &Emitters {
        self.emitters.get_or_init(|| Emitters::of(self.scene))
    }

    /// Returns the number of texels before the sky's pixels.
    pub(crate) fn before_pictures(&self) -> usize {
        HEAD + self.each_light * self.scene.lights.len() + self.each * self.scene.materials().len()
    }

    fn before_textures(&self) -> usize {
        self.before_pictures() + sky_pixels(self.scene).len()
    }

    /// Returns the number of all texels.
    pub(crate) fn count(&self) -> usize {
        self.before_paths()
            + self.for_paths().map_or(0, |_| 1 + facets::SIDE * facets::SIDE + self.emitters().texels.len())
    }

    /// Returns the first texel that only paths read, which says where the others are; `None` if paths need none.
    fn for_paths(&self) -> Option<Texel> {
        let facets = self.before_paths() + 1;
        let emitters = facets + facets::SIDE * facets::SIDE;
        let head = [facets as u32, emitters as u32, self.emitters().count() as u32, self.emitters().power.to_bits()];
        (self.each > 1).then_some(head)
    }

    /// Returns the number of texels before those that only paths read.
    pub(crate) fn before_paths(&self) -> usize {
        self.before_textures() + self.textures().iter().map(|texture| 1 + body_texels(texture)).sum::<usize>()
    }

    /// Returns the scene's textures, or an empty list if neither a surface nor a projector needs them.
    fn textures(&self) -> &'a [Texture] {
        if self.scene.is_textured() || self.scene.has_projectors() { self.scene.textures() } else { &[] }
    }

    pub(crate) fn texels(&self) -> impl Iterator<Item = Texel> + use<'a> {
        let scene = self.scene;
        let plain = |vector| texel(vector, 0);
        let [mut nadir, mut zenith] = match &scene.sky {
            Sky::Constant(color) => [*color; 2].map(plain),
            Sky::Gradient { nadir, zenith } => [*nadir, *zenith].map(plain),
            Sky::Map(map) => [[self.before_pictures() as u32, map.size()[0], map.size()[1], 0], [0; 4]],
        };
        nadir[3] = self.before_textures() as u32;
        zenith[3] = self.before_paths() as u32;
        let head: [_; HEAD] = [texel(scene.rendered_ambient(), scene.lights.len() as u32), nadir, zenith];
        let (each, each_light) = (self.each, self.each_light);
        let lights = scene.lights.iter();
        let lights = lights.flat_map(move |light| {
            let projector = projector_of(light.projector, scene.textures());
            light_of(light, scene.local_position(light)).into_iter().chain(projector).take(each_light)
        });
        let materials = scene.materials().iter().flat_map(move |material| material_of(material).into_iter().take(each));
        let sky = sky_pixels(scene).iter().copied().map(plain);
        let heads = self.placed_textures().map(|(at, texture)| head_of(texture, at));
        let bodies = self.placed_textures().flat_map(|(at, texture)| body_of(texture, at));
        let pictures = sky.chain(heads).chain(bodies);
        head.into_iter().chain(lights).chain(materials).chain(pictures).chain(self.path_texels())
    }

    /// Returns the texels that only paths read. They are the last ones, from [`ShadingTable::before_paths`] on.
    pub(crate) fn path_texels(&self) -> impl Iterator<Item = Texel> + use<> {
        let texels = self.for_paths().map(|head| {
            let facets = facets::reflected_shares().iter().copied();
            [head].into_iter().chain(facets).chain(self.emitters().texels.iter().copied()).collect::<Vec<_>>()
        });
        texels.into_iter().flatten()
    }

    /// Returns the textures, each with the index of its first body texel.
    fn placed_textures(&self) -> impl Iterator<Item = (u32, &'a Texture)> + use<'a> {
        let textures = self.textures();
        let begin = self.before_textures() + textures.len();
        textures.iter().scan(begin, |next, texture| {
            let at = *next;
            *next += body_texels(texture);
            Some((at as u32, texture))
        })
    }
}

pub(crate) fn texel(vector: Vec3, word: u32) -> Texel {
    let [x, y, z] = vector.to_array().map(f32::to_bits);
    [x, y, z, word]
}

/// Returns the pixels of a sky map.
fn sky_pixels(scene: &Scene) -> &[Vec3] {
    if let Sky::Map(map) = &scene.sky { map.pixels() } else { &[] }
}

/// Returns the sampling weights of a sky map's pixels (`sky_light.wgsl`). A pixel holds the cumulative share of its
/// row's weight, up to and including the pixel. That share is always 1 in the last column. Pixels there hold the
/// cumulative share of the total weight instead, up to and including their row. The last pixel, where that share is 1
/// too, holds the mean weight.
fn weights_of(sky: &SkyMap) -> Vec<f32> {
    let [width, height] = sky.size().map(|side| side as usize);
    let mut shares = Vec::with_capacity(width * height);
    let mut rows = Vec::with_capacity(height);
    let mut total = 0.0;
    for (row, pixels) in sky.pixels().chunks(width).enumerate() {
        let first = shares.len();
        let mut sum = 0.0;
        let weight = row_weight(row, height);
        let sums = pixels.iter().map(|pixel| {
            sum += weight * pixel.as_dvec3().dot(BRIGHTNESS);
            sum
        });
        let sums: Vec<f64> = sums.collect();
        shares.extend(sums.iter().map(|upto| share_of(*upto, sum)));
        debug_assert_eq!(shares.len(), first + width);
        total += sum;
        rows.push(total);
    }
    for (row, upto) in rows.iter().enumerate() {
        shares[row * width + width - 1] = share_of(*upto, total);
    }
    if let Some(last) = shares.last_mut() {
        *last = (total / (width * height) as f64) as f32;
    }
    shares
}

fn share_of(part: f64, whole: f64) -> f32 {
    if whole > 0.0 { (part / whole) as f32 } else { 0.0 }
}

/// Returns the approximate solid angle of a pixel in a row, relative to a pixel at the horizon. `row_weight` of
/// `sky_light.wgsl` computes the same.
fn row_weight(row: usize, rows: usize) -> f64 {
    let down = (row as f64 + 0.5) / rows as f64;
    let arc = 4.0 * down * (1.0 - down);
    arc * (0.775 + 0.225 * arc)
}

/// Returns the texels of a light (soft.wgsl). `place` is its position relative to the scene's origin.
fn light_of(light: &Light, place: Vec3) -> [Texel; 4] {
    let (scale, offset, axis) = cone_of(light.cone);
    let (kind, size, sides) = match light.shape {
        LightShape::Point => (0, 0.0, [axis, offset]),
        LightShape::Sphere { radius } => (1, radius, [axis, offset]),
        LightShape::Rectangle { half_width, half_height } => (2, 1.0, [half_width, half_height]),
        LightShape::Directional { radius } => (3, radius.tan(), [axis, offset]),
    };
    let range = match light.falloff {
        Falloff::None => 0.0,
        Falloff::Quadratic { range } => range.unwrap_or(f32::INFINITY),
    };
    let [width, height] = [(sides[0], scale), (sides[1], range)].map(|(side, word)| texel(side, word.to_bits()));
    [texel(place, kind), texel(light.intensity, f32::to_bits(size)), width, height]
}

/// Returns a cone's scale, its offset in x, and its unit axis. Scale and offset map the cosine of an angle from the
/// axis to the root of the light's share there. Without a cone the share is 1 everywhere.
fn cone_of(cone: Option<Cone>) -> (f32, Vec3, Vec3) {
    let Some(Cone { direction, inner, outer }) = cone else { return (0.0, Vec3::X, Vec3::ZERO) };
    // The extension's lower limit of the difference.
    let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-3);
    (scale, Vec3::X * (-outer.cos() * scale), direction.as_dvec3().normalize_or_zero().as_vec3())
}

/// Returns the texels of a projector (projectors.wgsl): vectors to the right and up, and the unit direction. Their
/// lengths make the picture's edges lie at -1 and 1 where the direction is 1. The first w is the texture's number plus
/// one, or 0.
fn projector_of(projector: Option<Projector>, textures: &[Texture]) -> [Texel; 3] {
    let Some(Projector { texture, direction, up, fov }) = projector else { return [[0; 4]; 3] };
    let aspect = match textures[texture.0 as usize].kind() {
        TextureKind::Image { size: [width, height], .. } => f64::from(*width) / f64::from(*height),
        TextureKind::Checkerboard { .. } => 1.0,
    };
    let direction = direction.as_dvec3().normalize_or_zero();
    let right = direction.cross(up.as_dvec3()).normalize_or_zero();
    let scale = 1.0 / (0.5 * f64::from(fov)).tan();
    let vectors = [right * scale, right.cross(direction) * (scale * aspect), direction];
    let [right, up, direction] = vectors.map(|vector| texel(vector.as_vec3(), 0));
    [[right[0], right[1], right[2], texture.0 + 1], up, direction]
}

/// Returns the texels of a material (materials.wgsl).
fn material_of(material: &Material) -> Vec<Texel> {
    let texture = material.texture.map_or(0, |texture| texture.0 + 1);
    let (kind, fresnel, transmission, index) = match material.finish {
        Finish::Matte => (0, false, Vec3::ZERO, 1.0),
        Finish::Mirror { fresnel } => (1, fresnel, Vec3::ZERO, 1.0),
        Finish::Glass { index, transmission, fresnel } => (2, fresnel, transmission, index),
    };
    // The transmission of glass takes the place of opacity.
    let opacity = if kind == 2 { 1.0 } else { material.opacity };
    let (blends, chosen) = (material.blends(), material.is_chosen());
    let is_veil = opacity < 1.0 || blends;
    let flags = [fresnel, is_veil, chosen, blends].into_iter().zip(2..).map(|(is_set, bit)| u32::from(is_set) << bit);
    let finish = kind | flags.sum::<u32>();
    [
        texel(material.albedo, texture | finish << 24),
        texel(
            material.specular,
            if material.normalised { -1.0 - material.exponent } else { material.exponent }.to_bits(),
        ),
        texel(material.emission, opacity.to_bits()),
        texel(transmission, f32::to_bits(index)),
    ]
    .into_iter()
    .chain(principled_of(material.principled.as_ref()))
    .collect()
}

/// Returns the texels of a physically based surface (`Principled` of materials.wgsl).
fn principled_of(surface: Option<&Principled>) -> [Texel; 7] {
    let Some(surface) = surface else { return [[0; 4]; 7] };
    let number = |texture: Option<TextureId>| texture.map_or(0, |texture| texture.0 + 1);
    let shape = Vec3::new(surface.metallic, surface.roughness, surface.index);
    [
        texel(surface.base, 1 | u32::from(surface.thin) << 1 | number(surface.metallic_texture) << 8),
        texel(surface.emission, number(surface.emission_texture)),
        texel(shape, number(surface.roughness_texture)),
        [surface.grazing.to_bits(), number(surface.transmission_texture), 0, number(surface.normal_texture)],
        texel(surface.absorption, surface.normal_scale.to_bits()),
        texel(surface.specular, surface.transmission.to_bits()),
        [
            surface.clearcoat.to_bits(),
            surface.clearcoat_roughness.to_bits(),
            number(surface.clearcoat_texture),
            number(surface.clearcoat_roughness_texture),
        ],
    ]
}

/// Returns the number of a wrap mode, such as `WRAP_REPEAT` in textures.wgsl.
pub(crate) fn wrap_number(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    }
}

fn head_of(texture: &Texture, at: u32) -> Texel {
    let wrap = wrap_number(texture.wrap);
    match texture.kind() {
        TextureKind::Image { size, .. } => [wrap << 4, at, level_sizes(*size).count() as u32, 0],
        TextureKind::Checkerboard { squares, .. } => [CHECKERBOARD | wrap << 4, at, *squares, 0],
    }
}

/// Returns the number of texels that `body_of` makes.
fn body_texels(texture: &Texture) -> usize {
    match texture.kind() {
        TextureKind::Image { size, .. } => level_sizes(*size).map(|size| 1 + pixel_texels(size)).sum(),
        TextureKind::Checkerboard { .. } => 2,
    }
}

/// Returns the texels of a texture after its header. An image has a header for each mip level, then the pixels of all
/// levels. A checkerboard has two colours, whose alpha is their brightness.
fn body_of(texture: &Texture, at: u32) -> Vec<Texel> {
    let (size, pixels) = match texture.kind() {
        TextureKind::Image { size, pixels } => (*size, pixels),
        TextureKind::Checkerboard { colors, .. } => {
            let alpha = |color: Vec3| color.dot(BRIGHTNESS.as_vec3()).min(1.0);
            return colors.map(|color| texel(color, alpha(color).to_bits())).to_vec();
        }
    };
    let mut next = at + level_sizes(size).count() as u32;
    let mut texels: Vec<Texel> = level_sizes(size)
        .map(|[width, height]| {
            let head = [next, width, height, 0];
            next += pixel_texels([width, height]) as u32;
            head
        })
        .collect();
    let share = |value: u8| f32::from(value) / 255.0;
    let light = |value: u8| if texture.data { share(value) } else { linear_of(value) };
    let decoded = |&[red, green, blue, alpha]: &[u8; 4]| Vec4::new(light(red), light(green), light(blue), share(alpha));
    let mut level: Vec<Vec4> = pixels.iter().map(decoded).collect();
    for sizes in level_sizes(size).collect::<Vec<_>>().windows(2) {
        texels.extend(halves(&level));
        level = smaller(&level, sizes[0], sizes[1]);
    }
    texels.extend(halves(&level));
    texels
}

/// Returns the sizes of a picture's mip levels, from full size down to one pixel.
fn level_sizes(size: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    iter::successors(Some(size), |&size| (size != [1, 1]).then(|| size.map(|side| (side / 2).max(1))))
}

fn pixel_texels([width, height]: [u32; 2]) -> usize {
    (width as usize * height as usize).div_ceil(2)
}

/// Packs pixels as 16-bit floats, two pixels per texel.
fn halves(pixels: &[Vec4]) -> impl Iterator<Item = Texel> + '_ {
    let words = |pixel: Vec4| {
        let [r, g, b, a] = pixel.to_array().map(|value| u32::from(f16::from_f32(value).to_bits()));
        [r | g << 16, b | a << 16]
    };
    pixels.chunks(2).map(move |two| {
        let [first, second] = [words(two[0]), words(*two.last().unwrap_or(&two[0]))];
        [first[0], first[1], second[0], second[1]]
    })
}

/// Resizes a picture; each pixel is the mean of the area that it covers.
fn smaller(pixels: &[Vec4], [width, height]: [u32; 2], [to_width, to_height]: [u32; 2]) -> Vec<Vec4> {
    let (columns, rows) = (shares(width, to_width), shares(height, to_height));
    let mean = |row: &[(usize, f32)], column: &[(usize, f32)]| {
        let across = |y: usize| column.iter().map(|&(x, share)| pixels[y * width as usize + x] * share).sum::<Vec4>();
        row.iter().map(|&(y, share)| across(y) * share).sum()
    };
    rows.iter().flat_map(|row| columns.iter().map(move |column| mean(row, column))).collect()
}

/// Returns how a row of `from` pixels is resized to `to` pixels. Each new pixel gets the indices of the old pixels that
/// it covers, and their weights.
fn shares(from: u32, to: u32) -> Vec<Vec<(usize, f32)>> {
    let scale = f64::from(from) / f64::from(to);
    let under = |pixel: u32| {
        let (begin, end) = (f64::from(pixel) * scale, f64::from(pixel + 1) * scale);
        let share = |at: usize| ((end.min(at as f64 + 1.0) - begin.max(at as f64)) / scale) as f32;
        (begin as usize..(end.ceil() as usize).min(from as usize)).map(|at| (at, share(at))).collect()
    };
    (0..to).map(under).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_shrink_to_the_mean_whatever_the_sides() {
        for [width, height] in [[1, 1], [2, 2], [5, 3], [7, 1], [64, 48]] {
            let pixel = |index: u32| Vec4::new(index as f32, 1.0, 0.5, (index % 3) as f32);
            let mut level: Vec<Vec4> = (0..width * height).map(pixel).collect();
            let mean = level.iter().sum::<Vec4>() / level.len() as f32;
            let sizes: Vec<_> = level_sizes([width, height]).collect();
            for pair in sizes.windows(2) {
                level = smaller(&level, pair[0], pair[1]);
                assert_eq!(level.len() as u32, pair[1][0] * pair[1][1]);
            }
            assert_eq!(sizes.last(), Some(&[1, 1]));
            assert!(
                level.len() == 1 && (level[0] - mean).abs().max_element() < 1e-5 * mean.x.max(1.0),
                "{width}x{height}"
            );
        }
    }

    #[test]
    fn a_table_has_as_many_texels_as_it_says_and_its_places_lead_to_them() {
        let mut scene = Scene::new();
        let pixels = (0..15).map(|index| [index * 17, 255, 0, 128]).collect();
        let image = scene.add_texture(Texture::image(5, 3, pixels).unwrap());
        let board = scene.add_texture(Texture::checkerboard(Vec3::X, Vec3::Y, 8).unwrap().wrap(Wrap::Mirror));
        scene.add_material(Material::new(Vec3::ONE).texture(board));
        scene.add_material(Material::new(Vec3::ONE).texture(image).specular(Vec3::splat(0.2)));
        scene.sky = Sky::Map(SkyMap::procedural(8).unwrap());
        let table = ShadingTable::of(&scene);
        let texels: Vec<Texel> = table.texels().collect();
        assert_eq!(texels.len(), table.count());
        assert_eq!(texels[0][3], 0);
        assert_eq!([texels[3][3], texels[7][3], texels[11][3]], [0, 2, 1]);
        let heads = texels[1][3] as usize;
        assert_eq!(texels[heads + 1][0], CHECKERBOARD | 1 << 4);
        assert_eq!(texels[texels[heads + 1][1] as usize], texel(Vec3::X, 0.2126f32.to_bits()));
        let levels = texels[heads][1] as usize;
        assert_eq!(texels[heads][2], 3);
        assert_eq!(texels[levels + 1][1..3], [2, 1]);
        let third = texels[texels[levels][0] as usize + 1];
        assert_eq!(f16::from_bits(third[0] as u16).to_f32(), f16::from_f32(linear_of(34)).to_f32());
        assert_eq!(f16::from_bits((third[1] >> 16) as u16), f16::from_f32(128.0 / 255.0));
    }
}
