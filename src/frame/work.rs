//! Counts of the work of a view.

/// Numbers of rays of one view, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Rays {
    /// Closest-hit rays through pixels. With a [T-buffer](crate::Visibility::TBuffer), only rays that are traced in
    /// addition to it. With a history ([`Options::history`](crate::Options::history)), only those of pixels whose bound
    /// does not suffice.
    pub primary: u64,
    /// Any-hit rays of limited length that verify reused pixels.
    pub verification: u64,
    /// Any-hit rays towards lights.
    pub shadow: u64,
    /// Closest-hit rays that mirrors, glass and transparent surfaces reflect, refract or transmit.
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
    /// Numbers of rays, by kind.
    pub rays: Rays,
    /// Number of BVH nodes visited (a node holds the boxes of two children), plus the number of primitives projected
    /// into a [T-buffer](crate::Visibility::TBuffer). 0 unless counting is on.
    pub nodes: u64,
    /// Number of primitive tests; 0 unless counting is on.
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
    /// Returns the number of box tests (two per node) plus the number of primitive tests.
    pub fn cost(&self) -> u64 {
        2 * self.nodes + self.primitive_tests
    }
}
