//! Random numbers of one purpose within a scene.

use crate::{dataset::draws::Draws, random::Random};

/// A sequence of random numbers, which depends on an item's draws and a purpose.
pub(super) struct Dice(Random);

impl Dice {
    pub(super) fn new(draws: &Draws, purpose: &str) -> Self {
        Self(Random(draws.word(purpose)))
    }

    /// Starts another sequence. Its numbers do not depend on how many numbers this one gives later.
    pub(super) fn fork(&mut self) -> Self {
        Self(Random(crate::random::pcg((self.unit() * (1 << 24) as f32) as u32 ^ self.0.0.rotate_left(9))))
    }

    /// Returns a number from 0 up to 1, excluding 1.
    pub(super) fn unit(&mut self) -> f32 {
        self.0.unit()
    }

    pub(super) fn between(&mut self, low: f32, high: f32) -> f32 {
        self.0.between(low, high)
    }

    /// Returns a number with evenly distributed logarithm. Both limits are above 0.
    pub(super) fn log_between(&mut self, low: f32, high: f32) -> f32 {
        low * (high / low).powf(self.unit())
    }

    /// Returns a whole number below `count`, or 0.
    pub(super) fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f32) as usize).min(count.saturating_sub(1))
    }

    /// Returns a whole number from `low` to `high`.
    pub(super) fn whole(&mut self, low: usize, high: usize) -> usize {
        low + self.below(high + 1 - low)
    }

    pub(super) fn chance(&mut self, probability: f32) -> bool {
        self.unit() < probability
    }

    /// Returns one of the values, which must not be empty.
    pub(super) fn pick<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    /// Returns an angle in radians, from 0 to a full turn.
    pub(super) fn angle(&mut self) -> f32 {
        self.between(0.0, std::f32::consts::TAU)
    }

    /// Returns a uniformly distributed rotation: a normalised point of the 4D unit ball.
    pub(super) fn turn(&mut self) -> glam::Quat {
        loop {
            let [x, y, z, w] = [(); 4].map(|()| self.between(-1.0, 1.0));
            let squared = x * x + y * y + z * z + w * w;
            if (0.01..1.0).contains(&squared) {
                return glam::Quat::from_xyzw(x, y, z, w).normalize();
            }
        }
    }
}
