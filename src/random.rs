//! Random numbers for scenes and tests: made of whole numbers only, so that they are the same on every machine.
//!
//! Integration tests and benches include this file by its path: there is one generator.

/// PCG (O'Neill 2014) as a hash of one word, as in Jarzynski and Olano 2020.
pub(crate) fn pcg(input: u32) -> u32 {
    let state = input.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Each number is the hash of the next word, so a sequence repeats itself after 2³² numbers only.
pub(crate) struct Random(pub(crate) u32);

impl Random {
    /// From 0 up to 1, exact in f32.
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (pcg(self.0) >> 8) as f32 / (1 << 24) as f32
    }

    pub(crate) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }
}

#[cfg(test)]
impl Random {
    /// Starts at the seed's own hash: neighbouring seeds would otherwise share all numbers but one.
    pub(crate) fn new(seed: u32) -> Self {
        Self(pcg(seed))
    }

    /// A whole number below `count`.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f32) as usize
    }

    /// A point of the cube from `-half` to `half` on each axis.
    pub(crate) fn point(&mut self, half: f32) -> glam::Vec3 {
        glam::Vec3::from_array([(); 3].map(|()| self.between(-half, half)))
    }
}
