//! Twin of `shaders/shared/double_float.wgsl`: sums of two f32 with twice the precision of f32.

use std::ops::{Add, Mul, Neg};

use glam::Vec3;

/// The sum `hi + lo`, where `lo` is the rounding error of `hi`.
#[derive(Clone, Copy, Debug)]
pub struct Two {
    /// The sum rounded to f32.
    pub hi: f32,
    /// The remainder.
    pub lo: f32,
}

/// A vector of three such sums.
#[derive(Clone, Copy, Debug)]
pub struct Two3(pub [Two; 3]);

impl Two {
    /// Converts an f32 exactly.
    pub fn new(v: f32) -> Self {
        Self { hi: v, lo: 0.0 }
    }

    /// Returns a - b exactly.
    pub fn difference(a: f32, b: f32) -> Self {
        let hi = a - b;
        let taken = hi - a;
        Self { hi, lo: (a - (hi - taken)) - (b + taken) }
    }
}

impl Add for Two {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let hi = self.hi + b.hi;
        let taken = hi - self.hi;
        let lo = (self.hi - (hi - taken)) + (b.hi - taken) + (self.lo + b.lo);
        let sum = hi + lo;
        Self { hi: sum, lo: lo - (sum - hi) }
    }
}

impl Neg for Two {
    type Output = Self;
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Mul for Two {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let upper_half = |v: f32| {
            let c = v * 4097.0;
            c - (c - v)
        };
        let hi = self.hi * b.hi;
        let (a_high, b_high) = (upper_half(self.hi), upper_half(b.hi));
        let (a_low, b_low) = (self.hi - a_high, b.hi - b_high);
        let lo = ((a_high * b_high - hi) + a_high * b_low + a_low * b_high) + a_low * b_low;
        Self { hi, lo: lo + (self.hi * b.lo + self.lo * b.hi) }
    }
}

impl Two3 {
    /// Converts a vector exactly.
    pub fn new(v: Vec3) -> Self {
        Self(v.to_array().map(Two::new))
    }

    /// Returns a - b exactly.
    pub fn difference(a: Vec3, b: Vec3) -> Self {
        Self(std::array::from_fn(|axis| Two::difference(a[axis], b[axis])))
    }
}

/// Returns the dot product.
pub fn dot(a: Two3, b: Two3) -> Two {
    (a.0[0] * b.0[0] + a.0[1] * b.0[1]) + a.0[2] * b.0[2]
}

/// Returns the cross product.
pub fn cross(a: Two3, b: Two3) -> Two3 {
    let component = |y: usize, z: usize| a.0[y] * b.0[z] + -(a.0[z] * b.0[y]);
    Two3([component(1, 2), component(2, 0), component(0, 1)])
}

/// Returns the ray's t at a triangle's plane.
pub fn plane_t(origin: Vec3, direction: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
    let normal = cross(Two3::difference(b, a), Two3::difference(c, a));
    let distance = dot(normal, Two3::difference(a, origin));
    distance.hi / dot(normal, Two3::new(direction)).hi
}
