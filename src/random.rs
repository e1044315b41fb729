//! Makes random numbers for scenes and tests. The generator uses integer arithmetic only, so its numbers are the same
//! on every machine.
//!
//! Integration tests and benches use this generator through the module `testing`.

/// Hashes one word by PCG (O'Neill 2014), as in Jarzynski and Olano 2020.
pub fn pcg(input: u32) -> u32 {
    let state = input.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Random sequence of the hashes of successive words. The sequence repeats after 2³² numbers.
#[derive(Clone, Debug)]
pub struct Random(pub u32);

impl Random {
    /// Returns a number from 0 up to 1, excluding 1, exact in f32.
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (pcg(self.0) >> 8) as f32 / (1 << 24) as f32
    }

    /// Returns a number from `low` up to `high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }
}

#[cfg(any(test, feature = "testing"))]
impl Random {
    /// Starts at the seed's own hash. Otherwise neighbouring seeds would share all numbers but one.
    pub fn new(seed: u32) -> Self {
        Self(pcg(seed))
    }

    /// Returns a whole number below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f32) as usize
    }

    /// Returns a point in the cube from `-half` to `half` on each axis.
    pub fn point(&mut self, half: f32) -> glam::Vec3 {
        glam::Vec3::from_array([(); 3].map(|()| self.between(-half, half)))
    }
}
