//! The work of a view, in counts.

/// Rays of one view by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Rays {
    /// Closest-hit rays through pixels. With a [T-buffer](crate::Visibility::TBuffer), only the rays still traced.
    pub primary: u64,
    /// Length-limited any-hit rays that check reused pixels.
    pub verification: u64,
    /// Any-hit rays towards lights.
    pub shadow: u64,
    /// Closest-hit rays reflected, refracted or passed on by mirrors, glass and transparent surfaces.
    pub secondary: u64,
}

impl Rays {
    /// Returns the sum of all kinds.
    pub fn total(&self) -> u64 {
        self.primary + self.verification + self.shadow + self.secondary
    }
}

impl std::ops::AddAssign for Rays {
    fn add_assign(&mut self, other: Self) {
        let Self { primary, verification, shadow, secondary } = other;
        self.primary += primary;
        self.verification += verification;
        self.shadow += shadow;
        self.secondary += secondary;
    }
}

/// Work of one view, in counts that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Work {
    /// Rays by kind.
    pub rays: Rays,
    /// BVH nodes visited (a node holds the boxes of two children), and primitives projected into a
    /// [T-buffer](crate::Visibility::TBuffer). 0 unless counting is on.
    pub nodes: u64,
    /// Primitives tested; 0 unless counting is on.
    pub primitive_tests: u64,
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        let Self { rays, nodes, primitive_tests } = other;
        self.rays += rays;
        self.nodes += nodes;
        self.primitive_tests += primitive_tests;
    }
}

impl Work {
    /// Returns box tests (two per node) plus primitive tests.
    pub fn cost(&self) -> u64 {
        2 * self.nodes + self.primitive_tests
    }
}
