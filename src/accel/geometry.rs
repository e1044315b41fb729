//! The layout of a BVH in the one texture or storage buffer that kernels read (`shaders/shared/fetch.wgsl`).
//!
//! The root's pair comes first, then the primitives, then all other pairs, then cut-out masks, and in buffers the
//! parents of all pairs but the root. Primitives thus begin at the same index for any scene size, so kernels need no
//! offset for them. Links are indices of pairs, counted from the first texel. Kernels reach all other pairs through
//! links only.

use crate::{
    accel::bvh::{LEAF, PackedBvh},
    gpu::TEXTURE_WIDTH,
    gpu::Texel,
    kernel::traversal::Fetch,
};

const WIDTH: usize = TEXTURE_WIDTH as usize;

/// The texels of a BVH in the order of a texture or a buffer.
pub(crate) struct GeometryTexels<'a> {
    packed: &'a PackedBvh,
    fetch: Fetch,
    /// Number of texels per primitive.
    each: usize,
}

impl<'a> GeometryTexels<'a> {
    pub(crate) fn new(packed: &'a PackedBvh, fetch: Fetch) -> Self {
        Self { packed, fetch, each: packed.primitives.len() / packed.ids.len().max(1) }
    }

    /// Returns the number of texels.
    pub(crate) fn count(&self) -> usize {
        self.parents_begin() + self.parents_count()
    }

    /// Returns the number of texels of parents.
    fn parents_count(&self) -> usize {
        self.other_pairs().div_ceil(4) * usize::from(self.fetch == Fetch::Buffer)
    }

    pub(crate) fn parents_bytes(&self) -> u64 {
        (self.parents_count() * size_of::<Texel>()) as u64
    }

    /// Returns the index of the first texel of parents.
    fn parents_begin(&self) -> usize {
        self.masks_begin() + self.packed.masks.len()
    }

    /// Returns the number of pairs other than the root.
    fn other_pairs(&self) -> usize {
        self.packed.nodes.len() / self.packed.pair_texels - 1
    }

    /// Returns the index of the first pair after the primitives.
    fn first_other_pair(&self) -> usize {
        (self.primitives_begin() + self.primitive_span()) / self.packed.pair_texels
    }

    /// Returns the index of the word that would hold the parent of pair 0, modulo 2³² (`parent_of` in
    /// `shaders/shared/fetch.wgsl`).
    pub(crate) fn parents_word(&self) -> u32 {
        (self.parents_begin() as u32).wrapping_mul(4).wrapping_sub(self.first_other_pair() as u32)
    }

    /// Returns the index of the first mask texel.
    pub(crate) fn masks_begin(&self) -> usize {
        self.primitives_begin() + self.primitive_span() + self.packed.nodes.len() - self.packed.pair_texels
    }

    /// Returns all texels.
    pub(crate) fn texels(&self) -> Vec<Texel> {
        let (pair, primitives) = (self.packed.pair_texels, &self.packed.primitives);
        let (root, others) = self.packed.nodes.split_at(pair);
        let mut texels = Vec::with_capacity(self.count());
        texels.extend_from_slice(root);
        texels.resize(self.primitives_begin(), [0; 4]);
        match self.fetch {
            // A row of primitives is stored as one row of their first texels, then one row of their second texels, and
            // so on. All texels of a primitive are thus in one column.
            Fetch::Texture => {
                for chunk in primitives.chunks(WIDTH * self.each.max(1)) {
                    for texel in 0..self.each {
                        texels.extend(chunk.iter().skip(texel).step_by(self.each));
                        texels.resize(texels.len().next_multiple_of(WIDTH), [0; 4]);
                    }
                }
            }
            Fetch::Buffer => {
                texels.extend_from_slice(primitives);
                texels.resize(texels.len().next_multiple_of(pair), [0; 4]);
            }
        }
        let moved = (texels.len() / pair - 1) as u32;
        let others_begin = texels.len();
        texels.extend_from_slice(others);
        let (root, rest) = texels.split_at_mut(others_begin);
        for child in root[..pair].chunks_mut(pair / 2).chain(rest.chunks_mut(pair / 2)) {
            // The first texel of each box holds the link.
            if child[0][3] & LEAF == 0 {
                child[0][3] += moved;
            }
        }
        texels.extend_from_slice(&self.packed.masks);
        if self.fetch == Fetch::Buffer {
            let parents = self.parents(&texels);
            texels.extend(parents);
        }
        texels
    }

    /// Returns the parents of all pairs but the root, from the texels of all pairs.
    fn parents(&self, texels: &[Texel]) -> Vec<Texel> {
        let (pair, first, count) = (self.packed.pair_texels, self.first_other_pair(), self.other_pairs());
        let mut words = vec![0; count.next_multiple_of(4)];
        for parent in std::iter::once(0).chain(first..first + count) {
            for child in 0..2 {
                let link = texels[parent * pair + child * pair / 2][3];
                // The pair of a scene without a tree has no children.
                if let Some(word) = words.get_mut((link as usize).wrapping_sub(first)).filter(|_| link & LEAF == 0) {
                    *word = parent as u32;
                }
            }
        }
        words.as_chunks().0.to_vec()
    }

    fn primitives_begin(&self) -> usize {
        match self.fetch {
            Fetch::Texture => WIDTH,
            Fetch::Buffer => self.packed.pair_texels,
        }
    }

    /// Returns the number of texels between the first primitive and the first pair after the primitives.
    fn primitive_span(&self) -> usize {
        match self.fetch {
            Fetch::Texture => self.packed.ids.len().div_ceil(WIDTH) * self.each * WIDTH,
            Fetch::Buffer => self.packed.primitives.len().next_multiple_of(self.packed.pair_texels),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Boxes, BvhBuild, MaterialId, Scene, Sphere, accel::bvh, random::Random};

    /// Reads a texel as `shaders/shared/fetch.wgsl` does.
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
            let mut packed = bvh::build(&scene, BvhBuild::Fast, boxes).unwrap();
            packed.masks = vec![[7; 4], [8; 4]];
            for fetch in [Fetch::Texture, Fetch::Buffer] {
                let geometry = GeometryTexels::new(&packed, fetch);
                let texels = geometry.texels();
                assert_eq!(texels.len(), geometry.count(), "{count} {boxes:?} {fetch:?}");
                let masks = &texels[geometry.masks_begin()..geometry.parents_begin()];
                assert_eq!(masks, packed.masks, "{count} {boxes:?} {fetch:?}");
                let pair = packed.pair_texels;
                for slot in 0..packed.ids.len() {
                    for texel in 0..3 {
                        let found = primitive_texel(&texels, fetch, pair, 3, slot, texel);
                        assert_eq!(found, packed.primitives[3 * slot + texel], "{slot} {fetch:?}");
                    }
                }
                // Compares the packed tree with the laid-out tree, starting from their roots.
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
                            if fetch == Fetch::Buffer {
                                let word = geometry.parents_word().wrapping_add(found[3]) as usize;
                                assert_eq!(texels[word / 4][word % 4] as usize, theirs);
                            }
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
