//! A BVH as the one texture or storage buffer that kernels read it from (`shaders/shared/fetch.wgsl`).
//!
//! The root's pair comes first, then the primitives, then all other pairs. So the primitives begin at the same place whatever
//! the scene's size, and kernels need neither a text of their own for it nor an addition; where the other pairs begin only
//! the links say, which are indices of pairs from the first texel on.

use std::iter;

use crate::{
    bvh::{LEAF, PackedBvh, Texel},
    gpu::TEXTURE_WIDTH,
    traversal::Fetch,
};

const WIDTH: usize = TEXTURE_WIDTH as usize;

/// The texels of a BVH in the order of a texture or a buffer.
pub(crate) struct GeometryTexels<'a> {
    packed: &'a PackedBvh,
    fetch: Fetch,
    /// Texels of a primitive.
    each: usize,
}

impl<'a> GeometryTexels<'a> {
    pub(crate) fn new(packed: &'a PackedBvh, fetch: Fetch) -> Self {
        Self { packed, fetch, each: packed.primitives.len() / packed.ids.len().max(1) }
    }

    /// How many they are.
    pub(crate) fn count(&self) -> usize {
        self.primitives_begin() + self.primitive_span() + self.packed.nodes.len() - self.packed.pair_texels
    }

    /// The texels, one by one.
    pub(crate) fn texels(&self) -> impl Iterator<Item = Texel> {
        let pair = self.packed.pair_texels;
        let moved = ((self.primitives_begin() + self.primitive_span()) / pair - 1) as u32;
        let relinked = move |(index, mut texel): (usize, Texel)| {
            // A box's first texel has the link.
            if index % (pair / 2) == 0 && texel[3] & LEAF == 0 {
                texel[3] += moved;
            }
            texel
        };
        let nodes = || self.packed.nodes.iter().copied().enumerate().map(relinked);
        let root = nodes().take(pair).chain(iter::repeat([0; 4])).take(self.primitives_begin());
        root.chain(self.primitives()).chain(nodes().skip(pair))
    }

    fn primitives_begin(&self) -> usize {
        match self.fetch {
            Fetch::Texture => WIDTH,
            Fetch::Buffer => self.packed.pair_texels,
        }
    }

    /// Texels from the first primitive's to the first pair's behind them.
    fn primitive_span(&self) -> usize {
        match self.fetch {
            Fetch::Texture => self.packed.ids.len().div_ceil(WIDTH) * self.each * WIDTH,
            Fetch::Buffer => self.packed.primitives.len().next_multiple_of(self.packed.pair_texels),
        }
    }

    /// In a texture the first texels of the primitives of a row stand in that row, their second ones in the next, and so on, so
    /// that a primitive's texels stand in one column.
    fn primitives(&self) -> impl Iterator<Item = Texel> {
        let (width, each) = match self.fetch {
            Fetch::Texture => (WIDTH, self.each),
            Fetch::Buffer => (self.primitive_span().max(1), 1),
        };
        (0..self.primitive_span() / width).flat_map(move |row| {
            let first = row / each * each * width + row % each;
            (0..width).map(move |column| self.packed.primitives.get(first + column * each).copied().unwrap_or_default())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Boxes, BvhBuild, MaterialId, Scene, Sphere, bvh, random::Random};

    /// Reads as `shaders/shared/fetch.wgsl` does.
    fn primitive_texel(texels: &[Texel], fetch: Fetch, pair: usize, each: usize, slot: usize, texel: usize) -> Texel {
        texels[match fetch {
            Fetch::Texture => ((slot >> 13) * each + 1 + texel) * 8192 + (slot & 8191),
            Fetch::Buffer => pair + slot * each + texel,
        }]
    }

    #[test]
    fn kernels_find_every_pair_and_primitive_of_what_was_packed() {
        for (count, boxes) in
            [(0, Boxes::F32), (1, Boxes::Grid16), (9, Boxes::F32), (20_000, Boxes::F32), (20_000, Boxes::Grid16)]
        {
            let mut random = Random::new(3);
            let mut scene = Scene::new();
            for _ in 0..count {
                scene.add_sphere(Sphere::new(random.point(9.0), 0.1, MaterialId(0))).unwrap();
            }
            let packed = bvh::build(&scene, BvhBuild::Fast, boxes).unwrap();
            for fetch in [Fetch::Texture, Fetch::Buffer] {
                let geometry = GeometryTexels::new(&packed, fetch);
                let texels: Vec<Texel> = geometry.texels().collect();
                assert_eq!(texels.len(), geometry.count(), "{count} {boxes:?} {fetch:?}");
                let pair = packed.pair_texels;
                for slot in 0..packed.ids.len() {
                    for texel in 0..3 {
                        let found = primitive_texel(&texels, fetch, pair, 3, slot, texel);
                        assert_eq!(found, packed.primitives[3 * slot + texel], "{slot} {fetch:?}");
                    }
                }
                // Both trees from their roots: as packed, and as laid out.
                let mut pending = if count == 0 { vec![] } else { vec![(0, 0)] };
                let mut visited = 0;
                while let Some((ours, theirs)) = pending.pop() {
                    visited += pair;
                    assert!(fetch == Fetch::Buffer || theirs * pair % WIDTH + pair <= WIDTH, "in one row");
                    for texel in 0..pair {
                        let (mut expected, mut found) =
                            (packed.nodes[ours * pair + texel], texels[theirs * pair + texel]);
                        if texel % (pair / 2) == 0 && expected[3] & LEAF == 0 {
                            pending.push((expected[3] as usize, found[3] as usize));
                            (expected[3], found[3]) = (0, 0);
                        }
                        assert_eq!(found, expected, "{ours} {theirs} {fetch:?}");
                    }
                }
                assert!(count == 0 || visited == packed.nodes.len(), "{visited}");
            }
        }
    }
}
