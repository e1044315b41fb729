//! Draws the random values of a pair. A value depends only on the seed, the pair's number and the value's name.

use serde::Serialize;
use sha2::{Digest as _, Sha256};

use super::spec::Distance;

/// Number of places from which random lights are chosen.
pub(super) const PLACES: u32 = 16;

/// A value, or a distribution of values.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Drawn<T> {
    /// Evenly distributed from the first to the second.
    Uniform([T; 2]),
    /// With evenly distributed logarithms.
    LogUniform([T; 2]),
    /// Normally distributed within limits.
    Normal(Normal),
    Choice(Vec<T>),
    #[serde(untagged)]
    Value(T),
}

impl<T: Span> Drawn<T> {
    /// Returns its choices, or its least and its largest value.
    pub(super) fn ends(&self) -> Vec<T> {
        match self {
            Self::Value(value) => vec![*value],
            Self::Uniform(ends) | Self::LogUniform(ends) => ends.to_vec(),
            Self::Normal(normal) => normal.limits.map(T::of).to_vec(),
            Self::Choice(choices) => choices.clone(),
        }
    }
}

/// A normal distribution between two limits. It is written as `[mean, deviation, low, high]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "[f64; 4]")]
pub(super) struct Normal {
    pub(super) mean: f64,
    pub(super) deviation: f64,
    pub(super) limits: [f64; 2],
}

impl From<Normal> for [f64; 4] {
    fn from(Normal { mean, deviation, limits: [low, high] }: Normal) -> Self {
        [mean, deviation, low, high]
    }
}

impl Normal {
    /// Returns the shares of the normal distribution that lie below the two limits.
    pub(super) fn shares(&self) -> [f64; 2] {
        self.limits.map(|limit| share_below((limit - self.mean) / self.deviation))
    }

    /// Returns the value below which a share of the values lies, by bisection.
    fn at(&self, share: f64) -> f64 {
        let [below, above] = self.shares();
        let wanted = below + share * (above - below);
        let [mut low, mut high] = self.limits.map(|limit| (limit - self.mean) / self.deviation);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if share_below(middle) < wanted { low = middle } else { high = middle }
        }
        self.mean + self.deviation * 0.5 * (low + high)
    }
}

/// Returns the share of a standard normal distribution below a value.
fn share_below(value: f64) -> f64 {
    0.5 * libm::erfc(-value * std::f64::consts::FRAC_1_SQRT_2)
}

/// Values of which ranges exist.
pub(super) trait Span: Copy {
    /// Returns the value for a number.
    fn of(number: f64) -> Self;
    /// Returns the value at a share of the range, 0 to 1.
    fn between(low: Self, high: Self, share: f64) -> Self;
    /// Returns the value at a share of the range of logarithms.
    fn log_between(low: Self, high: Self, share: f64) -> Self;
}

impl Span for f64 {
    fn of(number: f64) -> Self {
        rounded(number)
    }

    fn between(low: Self, high: Self, share: f64) -> Self {
        rounded(low + share * (high - low))
    }

    fn log_between(low: Self, high: Self, share: f64) -> Self {
        rounded((low.ln() + share * (high / low).ln()).exp())
    }
}

impl Span for Distance {
    fn of(number: f64) -> Self {
        Self(f64::of(number))
    }

    fn between(low: Self, high: Self, share: f64) -> Self {
        Self(f64::between(low.0, high.0, share))
    }

    fn log_between(low: Self, high: Self, share: f64) -> Self {
        Self(f64::log_between(low.0, high.0, share))
    }
}

impl Span for u32 {
    fn of(number: f64) -> Self {
        rounded(number).round() as Self
    }

    fn between(low: Self, high: Self, share: f64) -> Self {
        ((f64::from(low) + share * (f64::from(high) + 1.0 - f64::from(low))) as Self).min(high)
    }

    fn log_between(low: Self, high: Self, share: f64) -> Self {
        let (low, next) = (f64::from(low), f64::from(high) + 1.0);
        ((low * (next / low).powf(share)) as Self).min(high)
    }
}

/// Rounds to 7 digits, the precision of f32, since the last bits of logarithms and sines differ between machines.
pub(super) fn rounded(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// The random values of one pair.
#[derive(Clone, Copy)]
pub(super) struct Draws {
    pub(super) seed: u32,
    pub(super) item: u32,
    /// Number of rejected pairs of this item before.
    pub(super) attempt: u32,
}

impl Draws {
    /// Returns the random number of this name, from 0 up to 1, excluding 1. Other draws do not affect it.
    pub(super) fn unit(&self, name: &str) -> f64 {
        (self.bits(name) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a random word of this name, as the seed of a sequence.
    pub(super) fn word(&self, name: &str) -> u32 {
        (self.bits(name) >> 32) as u32
    }

    /// Returns 64 random bits of this name.
    pub(super) fn bits(&self, name: &str) -> u64 {
        let Self { seed, item, attempt } = self;
        let hash = match attempt {
            0 => Sha256::digest(format!("{seed}/{item}/{name}")),
            _ => Sha256::digest(format!("{seed}/{item}/attempt {attempt}/{name}")),
        };
        hash.iter().take(8).fold(0, |bits, &byte| (bits << 8) | u64::from(byte))
    }

    /// Returns the seed of free poses.
    pub(super) fn pose_seed(&self) -> u32 {
        if self.attempt == 0 { self.seed } else { self.word("poses") }
    }

    pub(super) fn draw<T: Span>(&self, value: &Drawn<T>, name: &str) -> T {
        match value {
            Drawn::Value(value) => *value,
            Drawn::Uniform([low, high]) => T::between(*low, *high, self.unit(name)),
            Drawn::LogUniform([low, high]) => T::log_between(*low, *high, self.unit(name)),
            Drawn::Normal(normal) => T::of(normal.at(self.unit(name))),
            Drawn::Choice(choices) => choices[self.index(choices.len(), name)],
        }
    }

    /// Draws an index below `count`.
    pub(super) fn index(&self, count: usize, name: &str) -> usize {
        (self.unit(name) * count as f64) as usize
    }

    /// Draws an index by weights.
    pub(super) fn weighted(&self, weights: &[f64], name: &str) -> usize {
        let mut left = self.unit(name) * weights.iter().sum::<f64>();
        for (index, &weight) in weights.iter().enumerate() {
            if left < weight {
                return index;
            }
            left -= weight;
        }
        weights.iter().rposition(|&weight| weight > 0.0).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draws() -> impl Iterator<Item = Draws> {
        (0..2000).map(|item| Draws { seed: 11, item, attempt: 0 })
    }

    #[test]
    fn numbers_are_the_same_on_every_machine() {
        assert_eq!(Draws { seed: 11, item: 5, attempt: 0 }.unit("scene"), 0.099_475_730_580_633_97);
    }

    #[test]
    fn draws_fill_their_ranges() {
        let units: Vec<f64> = draws().map(|draws| draws.unit("x")).collect();
        let mean = units.iter().sum::<f64>() / units.len() as f64;
        assert!(units.iter().any(|&unit| unit < 0.01) && units.iter().any(|&unit| unit > 0.99));
        assert!((mean - 0.5).abs() < 0.03, "{mean}");
        let others: Vec<f64> = draws().map(|draws| draws.unit("y")).collect();
        let product = units.iter().zip(&others).map(|(x, y)| (x - 0.5) * (y - 0.5)).sum::<f64>() / units.len() as f64;
        assert!(product.abs() < 0.06 / 12.0, "a variance is 1/12, and the correlation at most 0.06: {product}");
        for (range, most) in [(Drawn::Uniform([1, 3]), 800), (Drawn::LogUniform([1, 3]), 1100)] {
            let mut counts = [0; 4];
            draws().for_each(|draws| counts[draws.draw(&range, "count") as usize] += 1);
            assert!(counts[0] == 0 && counts[1..].iter().all(|&count| (100..most).contains(&count)), "{counts:?}");
        }
        let chosen: Vec<u32> = draws().map(|draws| draws.draw(&Drawn::Choice(vec![1, 2, 5]), "z")).collect();
        assert!([1, 2, 5].iter().all(|choice| chosen.contains(choice)));
        let logs = draws().map(|draws| draws.draw(&Drawn::LogUniform([0.01, 1.0]), "z").ln());
        let mean = logs.sum::<f64>() / 2000.0;
        assert!((mean - 0.1_f64.ln()).abs() < 0.1, "{mean}");
        let second = draws().filter(|draws| draws.weighted(&[1.0, 2.0, 0.0], "scene") == 1).count();
        assert!((second as f64 / 2000.0 - 2.0 / 3.0).abs() < 0.04, "{second}");
    }

    #[test]
    fn normal_values_have_their_mean_and_deviation_within_their_limits() {
        let values = |limits| {
            let normal = Drawn::Normal(Normal { mean: 2.0, deviation: 0.5, limits });
            Vec::from_iter(draws().map(|draws| draws.draw(&normal, "n")))
        };
        let moments = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let squares = values.iter().map(|value| (value - mean) * (value - mean));
            (mean, (squares.sum::<f64>() / values.len() as f64).sqrt())
        };
        let (mean, deviation) = moments(&values([-1.0, 5.0]));
        assert!((mean - 2.0).abs() < 0.04 && (deviation - 0.5).abs() < 0.03, "{mean} {deviation}");
        // Above its mean, the distribution is half a normal one: its mean is the deviation times sqrt(2 / pi) higher.
        let half = values([2.0, 7.0]);
        let expected = 2.0 + 0.5 * (2.0 / std::f64::consts::PI).sqrt();
        assert!(half.iter().all(|value| *value >= 2.0) && (moments(&half).0 - expected).abs() < 0.03, "{half:?}");
        let whole = Drawn::Normal(Normal { mean: 3.0, deviation: 1.0, limits: [1.0, 4.0] });
        let counts = Vec::from_iter(draws().map(|draws| draws.draw::<u32>(&whole, "n")));
        assert!((1..=4).all(|count| counts.contains(&count)) && counts.iter().all(|count| (1..=4).contains(count)));
    }

    #[test]
    fn values_have_seven_digits() {
        assert_eq!((rounded(0.123_456_789), rounded(-123_456_789.0), rounded(0.0)), (0.123_456_8, -123_456_800.0, 0.0));
    }
}
