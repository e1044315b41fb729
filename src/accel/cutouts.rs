//! Cut-out masks in the format of `shaders/shared/cutouts.wgsl`, with one bit per texture pixel. They are stored after
//! a scene's nodes and primitives, since kernels that only find hits bind no other scene data.

use std::collections::HashMap;

use crate::{
    Scene, Texture, TextureKind, accel::table::wrap_number, gpu::Texel, scene::material::MASK_ALPHA, srgb::BRIGHTNESS,
};

/// Number of texture pixels per texel of a mask.
const MASK_PIXELS: usize = 128;

/// Returns the cut-out textures, each with the index of its material.
pub(crate) fn cutouts_of(scene: &Scene) -> Vec<(usize, Texture)> {
    let materials = scene.materials().iter().enumerate();
    let cut_out = materials.filter_map(|(index, material)| Some((index, material.cutout?)));
    cut_out.map(|(index, id)| (index, scene.textures()[id.0 as usize].clone())).collect()
}

/// Returns one header texel for each material, then the masks. The list is empty if no material is cut out.
pub(crate) fn masks_of(scene: &Scene) -> Vec<Texel> {
    if !scene.is_cut_out() {
        return Vec::new();
    }
    // Materials without cut-outs share a mask of one solid pixel.
    let count = scene.materials().len();
    let mut texels = vec![[count as u32, 1, 1, 0]; count];
    texels.push([u32::MAX; 4]);
    let mut begins = HashMap::new();
    for (material, head) in scene.materials().iter().zip(0..) {
        let Some(id) = material.cutout else { continue };
        let texture = &scene.textures()[id.0 as usize];
        let begin = *begins.entry(id).or_insert_with(|| {
            let begin = texels.len();
            push_mask(&mut texels, texture);
            begin as u32
        });
        let [width, height] = size_of(texture);
        let head: usize = head;
        texels[head] = [begin, width, height, wrap_number(texture.wrap)];
    }
    texels
}

fn size_of(texture: &Texture) -> [u32; 2] {
    match texture.kind() {
        TextureKind::Image { size, .. } => *size,
        TextureKind::Checkerboard { squares, .. } => [*squares; 2],
    }
}

/// Appends a bit for each pixel of an image, or each square of a checkerboard, row by row from the bottom.
fn push_mask(texels: &mut Vec<Texel>, texture: &Texture) {
    let begin = texels.len();
    let [width, height] = size_of(texture).map(|side| side as usize);
    texels.resize(begin + (width * height).div_ceil(MASK_PIXELS), [0; 4]);
    let mut mark = |pixel: usize| texels[begin + pixel / MASK_PIXELS][pixel / 32 % 4] |= 1 << (pixel % 32);
    match texture.kind() {
        TextureKind::Image { pixels, .. } => {
            let from_below = pixels.chunks(width).rev().flatten().enumerate();
            from_below.filter(|(_, [.., alpha])| *alpha >= MASK_ALPHA).for_each(|(pixel, _)| mark(pixel));
        }
        TextureKind::Checkerboard { colors, .. } => {
            let bright = colors.map(|color| color.dot(BRIGHTNESS.as_vec3()) >= 0.5);
            let is_bright = |pixel: &usize| bright[(pixel / width + pixel % width) % 2];
            (0..width * height).filter(is_bright).for_each(mark);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::{Material, Wrap};

    /// Reads a bit of a material's mask as kernels do.
    fn bit(texels: &[Texel], material: usize, column: u32, row: u32) -> bool {
        let [begin, width, ..] = texels[material];
        let pixel = row * width + column;
        texels[(begin + pixel / 128) as usize][(pixel / 32 % 4) as usize] >> (pixel % 32) & 1 == 1
    }

    #[test]
    fn masks_have_a_bit_for_each_pixel_from_below_and_each_texture_once() {
        let mut scene = Scene::new();
        assert!(masks_of(&scene).is_empty() && cutouts_of(&scene).is_empty());
        let alpha = |column: u32, row: u32| ((column * 37 + row * 101) % 256) as u8;
        let pixels = (0..13 * 29).map(|index| [9, 9, 9, alpha(index % 13, index / 13)]).collect();
        let picture = scene.add_texture(Texture::image(13, 29, pixels).unwrap().wrap(Wrap::Mirror));
        let board = Texture::checkerboard(Vec3::new(0.0, 0.8, 0.0), Vec3::new(1.0, 0.0, 1.0), 17).unwrap();
        let board = scene.add_texture(board.wrap(Wrap::Clamp));
        for cutout in [Some(picture), None, Some(board), Some(picture)] {
            scene.add_material(Material { cutout, ..Material::new(Vec3::ONE) });
        }
        let texels = masks_of(&scene);
        assert_eq!(cutouts_of(&scene).iter().map(|(material, _)| *material).collect::<Vec<_>>(), [1, 3, 4]);
        assert_eq!(texels.len(), 5 + 1 + 3 + 3);
        assert_eq!(texels[..5], [[5, 1, 1, 0], [6, 13, 29, 1], [5, 1, 1, 0], [9, 17, 17, 2], [6, 13, 29, 1]]);
        assert!(bit(&texels, 0, 0, 0) && bit(&texels, 2, 0, 0));
        for (column, row) in (0..13).flat_map(|column| (0..29).map(move |row| (column, row))) {
            // Pictures store their top row first.
            assert_eq!(bit(&texels, 1, column, row), alpha(column, 28 - row) > 127, "{column} {row}");
        }
        for (column, row) in (0..17).flat_map(|column| (0..17).map(move |row| (column, row))) {
            // The colours have luminance 0.57 and 0.28; the first one is at u = v = 0.
            assert_eq!(bit(&texels, 3, column, row), (column + row) % 2 == 0, "{column} {row}");
        }
    }
}
