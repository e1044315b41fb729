//! Fits least-squares curves, as in the paper's figures 15 to 17.

/// A point of a figure.
pub(crate) type Point = (f64, f64);

/// `intercept + slope x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) intercept: f64,
    pub(crate) slope: f64,
    /// Share of the variance of y that the line explains, 0 to 1; NaN if all y are equal.
    pub(crate) r_squared: f64,
}

/// `constant + linear x + square x²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parabola {
    pub(crate) constant: f64,
    pub(crate) linear: f64,
    pub(crate) square: f64,
    /// Share of the variance of y that the parabola explains.
    pub(crate) r_squared: f64,
}

impl Line {
    /// Fits a line. Returns `None` for fewer than two different x.
    pub(crate) fn through(points: &[Point]) -> Option<Self> {
        let (mean_x, mean_y) = (mean(points, |point| point.0), mean(points, |point| point.1));
        let squares = sum(points, |(x, _)| (x - mean_x).powi(2));
        if squares.is_nan() || squares <= 0.0 {
            return None;
        }
        let slope = sum(points, |(x, y)| (x - mean_x) * (y - mean_y)) / squares;
        let line = Self { intercept: mean_y - slope * mean_x, slope, r_squared: 0.0 };
        Some(Self { r_squared: r_squared(points, |x| line.at(x)), ..line })
    }

    pub(crate) fn at(&self, x: f64) -> f64 {
        self.intercept + self.slope * x
    }
}

impl Parabola {
    /// Fits a parabola. Returns `None` for fewer than three different x.
    pub(crate) fn through(points: &[Point]) -> Option<Self> {
        // The fit uses u = (x - mean) / scale. Sums of fourth powers of u stay near 1, and the sum of u is 0.
        let middle = mean(points, |point| point.0);
        let scale = points.iter().map(|(x, _)| (x - middle).abs()).fold(0.0, f64::max);
        let u = |x: f64| (x - middle) / scale;
        let count = points.len() as f64;
        let power = |exponent: i32| sum(points, |(x, _)| u(x).powi(exponent));
        let with_y = |exponent: i32| sum(points, |(x, y)| u(x).powi(exponent) * y);
        let [second, third, fourth] = [power(2), power(3), power(4)];
        let [a, b, c] = [with_y(0), with_y(1), with_y(2)];
        // The normal equations are: count p + second r = a; second q + third r = b; second p + third q + fourth r = c.
        let left = fourth - second * second / count - third * third / second;
        // For only two different x this is 0 up to rounding.
        if left.is_nan() || left <= 1e-9 * count {
            return None;
        }
        let r = (c - second * a / count - third * b / second) / left;
        let (p, q) = ((a - second * r) / count, (b - third * r) / second);
        let square = r / (scale * scale);
        let linear = q / scale - 2.0 * square * middle;
        let constant = p - q * middle / scale + square * middle * middle;
        // The residuals are computed from u, since large terms in x may cancel.
        let of_u = |x: f64| p + q * u(x) + r * u(x) * u(x);
        Some(Self { constant, linear, square, r_squared: r_squared(points, of_u) })
    }

    pub(crate) fn at(&self, x: f64) -> f64 {
        self.constant + x * (self.linear + x * self.square)
    }
}

fn sum(points: &[Point], of: impl Fn(Point) -> f64) -> f64 {
    points.iter().map(|&point| of(point)).sum()
}

fn mean(points: &[Point], of: impl Fn(Point) -> f64) -> f64 {
    sum(points, of) / points.len() as f64
}

/// Returns 1 - (sum of squared residuals) / (sum of squares about the mean).
fn r_squared(points: &[Point], curve: impl Fn(f64) -> f64) -> f64 {
    let mean_y = mean(points, |point| point.1);
    1.0 - sum(points, |(x, y)| (y - curve(x)).powi(2)) / sum(points, |(_, y)| (y - mean_y).powi(2))
}
