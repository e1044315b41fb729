//! Noise of a camera's sensor: photon noise and read noise, as in the EMVA standard 1288 without dark current.

use crate::{Options, View};

/// A sensor. Its random numbers are the same on every machine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sensor {
    /// Electrons of a pixel's channel at linear light 1 after exposure; more are clipped.
    pub(super) full_well: f64,
    /// Standard deviation of the read noise in electrons.
    pub(super) read_noise: f64,
}

impl Sensor {
    /// Replaces a view's light by what the sensor measures. `seed` starts the random numbers.
    pub(super) fn expose(self, view: &mut View, options: &Options, seed: u64) {
        let exposure = f64::from(options.exposure.exp2());
        let mut random = Random { state: seed, spare: None };
        let mut measured = |light: f32| {
            let expected = (f64::from(light) * exposure * self.full_well).clamp(0.0, self.full_well);
            let read = if self.read_noise > 0.0 { self.read_noise * random.normal() } else { 0.0 };
            let electrons = (random.poisson(expected) + read).clamp(0.0, self.full_well);
            (electrons / (self.full_well * exposure)) as f32
        };
        let linear = std::mem::take(&mut view.linear);
        let noisy: Vec<_> =
            linear.into_iter().map(|[red, green, blue, _]| [red, green, blue].map(&mut measured)).collect();
        view.show_linear(noisy.into_iter(), options);
    }
}

/// Random numbers by `SplitMix64` (Steele, Lea and Flood 2014).
struct Random {
    state: u64,
    /// Second number of a pair of normally distributed ones.
    spare: Option<f64>,
}

impl Random {
    /// Returns a number above 0 and below 1.
    fn unit(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        ((bits >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    /// Returns a standard normal number (Marsaglia's polar method).
    fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        loop {
            let [x, y] = [2.0 * self.unit() - 1.0, 2.0 * self.unit() - 1.0];
            let squared = x * x + y * y;
            if squared > 0.0 && squared < 1.0 {
                let factor = (-2.0 * libm::log(squared) / squared).sqrt();
                self.spare = Some(y * factor);
                return x * factor;
            }
        }
    }

    /// Returns a Poisson-distributed whole number.
    fn poisson(&mut self, mean: f64) -> f64 {
        if mean < 10.0 { self.poisson_of_few(mean) } else { self.poisson_of_many(mean) }
    }

    /// Counts uniform factors until their product is below e^-mean (Knuth).
    fn poisson_of_few(&mut self, mean: f64) -> f64 {
        let limit = libm::exp(-mean);
        let (mut count, mut product) = (0.0, self.unit());
        while product > limit {
            product *= self.unit();
            count += 1.0;
        }
        count
    }

    /// Transformed rejection with squeeze (Hörmann 1993, algorithm PTRS), for means of at least 10.
    fn poisson_of_many(&mut self, mean: f64) -> f64 {
        let log_mean = libm::log(mean);
        let b = 0.931 + 2.53 * mean.sqrt();
        let a = -0.059 + 0.02483 * b;
        let inverse_alpha = 1.1239 + 1.1328 / (b - 3.4);
        let squeeze = 0.9277 - 3.6224 / (b - 2.0);
        loop {
            let (u, v) = (self.unit() - 0.5, self.unit());
            let us = 0.5 - u.abs();
            let count = ((2.0 * a / us + b) * u + mean + 0.43).floor();
            if us >= 0.07 && v <= squeeze {
                return count;
            }
            if count < 0.0 || (us < 0.013 && v > us) {
                continue;
            }
            let density = count * log_mean - mean - libm::lgamma(count + 1.0);
            if libm::log(v * inverse_alpha / (a / (us * us) + b)) <= density {
                return count;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares counts with the distribution's own probabilities, which the recurrence p(k + 1) = p(k) mean / (k + 1)
    /// gives. The bound is 4 deviations of chi-square.
    #[test]
    fn poisson_numbers_have_their_probabilities() {
        for mean in [0.3, 4.0, 9.99, 10.0, 37.5, 400.0] {
            let mut random = Random { state: 5, spare: None };
            let draws = 200_000;
            let most = (mean + 12.0 * f64::sqrt(mean) + 12.0) as usize;
            let mut counts = vec![0_u32; most];
            (0..draws).for_each(|_| counts[random.poisson(mean) as usize] += 1);
            let mut probability = (-mean).exp();
            let (mut square, mut freedom) = (0.0, -1.0);
            let (mut expected, mut found) = (0.0, 0.0);
            for (count, seen) in counts.iter().enumerate() {
                expected += probability * f64::from(draws);
                found += f64::from(*seen);
                // Neighbouring numbers are joined to at least 20 expected draws.
                if expected >= 20.0 {
                    square += (found - expected) * (found - expected) / expected;
                    (expected, found, freedom) = (0.0, 0.0, freedom + 1.0);
                }
                probability *= mean / (count as f64 + 1.0);
            }
            let deviations = (square - freedom) / f64::sqrt(2.0 * freedom);
            assert!(deviations.abs() < 4.0, "mean {mean}: {deviations} deviations");
        }
    }

    #[test]
    fn noise_has_the_variance_of_photons_and_reading_and_is_repeatable() {
        let options = Options::default().exposure(1.0);
        let noisy = |light: f32, seed| {
            let mut view = View::of_pixels(200, vec![[0; 4]; 40_000]);
            view.linear = vec![[light; 4]; 40_000];
            Sensor { full_well: 1000.0, read_noise: 5.0 }.expose(&mut view, &options, seed);
            view
        };
        let view = noisy(0.1, 3);
        let electrons =
            Vec::from_iter(view.linear.iter().flat_map(|color| [0, 1, 2].map(|at| 2000.0 * f64::from(color[at]))));
        let mean = electrons.iter().sum::<f64>() / electrons.len() as f64;
        let squares = electrons.iter().map(|value| (value - mean) * (value - mean));
        let variance = squares.sum::<f64>() / (electrons.len() - 1) as f64;
        // The deviations of these figures are 0.04 and 0.9.
        assert!((mean - 200.0).abs() < 0.2, "{mean}");
        assert!((variance - 225.0).abs() < 4.0, "{variance}");
        assert_eq!(view, noisy(0.1, 3));
        assert_ne!(view, noisy(0.1, 4));
        assert_eq!(view.rgba8[0], options.tone.rgba8([0, 1, 2].map(|at| view.linear[0][at]), 2.0));
        // Light above the full well is clipped, and no light stays near none.
        assert!(noisy(7.0, 3).linear.iter().all(|color| color[0] <= 0.5));
        assert!(noisy(0.0, 3).linear.iter().all(|color| (0.0..0.02).contains(&color[0])));
    }
}
