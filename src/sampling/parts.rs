//! Light in parts, averaged over the samples of a pixel, for denoising.

use glam::{Vec2, Vec3};

use crate::{
    accel::bvh::pack_normal,
    kernel::layout::{LightParts, NO_LIGHT, NO_NORMAL},
    srgb::BRIGHTNESS,
};

/// Sums over a pixel's samples so far. Pairs hold diffuse light before the albedo and glossy light, over the samples
/// that reflect this kind.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PartSums {
    /// Diffuse light after and before the albedo.
    lit: Vec3,
    diffuse: Vec3,
    glossy: Vec3,
    albedo: Vec3,
    rest: Vec3,
    point: Vec3,
    normal: Vec3,
    lobe_width: f32,
    reflectance: Vec3,
    /// Weight of the samples that show a surface.
    surface: f32,
    weights: Vec2,
    brightness: Vec2,
    /// Squares of the brightness.
    squares: Vec2,
    /// Sums with squared weights: the weights themselves, and the variances.
    squared_weights: Vec2,
    variances: Vec2,
}

impl PartSums {
    /// Adds a sample.
    pub(crate) fn add(&mut self, parts: &LightParts, weight: f32) {
        self.rest += weight * Vec3::from(parts.rest);
        if parts.normal == NO_NORMAL {
            return;
        }
        let [diffuse, glossy, albedo] = [parts.diffuse, parts.glossy, parts.albedo].map(Vec3::from);
        self.lit += weight * albedo * diffuse;
        self.glossy += weight * glossy;
        self.albedo += weight * albedo;
        self.point += weight * Vec3::new(parts.point_x, parts.point_y, parts.point_z);
        self.normal += weight * from_octahedral(parts.normal);
        self.lobe_width += weight * parts.lobe_width;
        self.reflectance += weight * Vec3::from(parts.reflectance);
        self.surface += weight;
        let variances = Vec2::new(parts.diffuse_variance, parts.glossy_variance);
        let weights = Vec2::select(variances.cmpge(Vec2::ZERO), Vec2::splat(weight), Vec2::ZERO);
        let brightness = Vec2::new(diffuse.dot(BRIGHTNESS.as_vec3()), glossy.dot(BRIGHTNESS.as_vec3()));
        self.diffuse += weights.x * diffuse;
        self.weights += weights;
        self.brightness += weights * brightness;
        self.squares += weights * brightness * brightness;
        self.squared_weights += weights * weights;
        self.variances += weights * weights * variances;
    }

    /// Returns these sums with all weights multiplied by a factor.
    pub(crate) fn weighted(&self, factor: f32) -> Self {
        let squared = factor * factor;
        Self {
            lit: self.lit * factor,
            diffuse: self.diffuse * factor,
            glossy: self.glossy * factor,
            albedo: self.albedo * factor,
            rest: self.rest * factor,
            point: self.point * factor,
            normal: self.normal * factor,
            lobe_width: self.lobe_width * factor,
            reflectance: self.reflectance * factor,
            surface: self.surface * factor,
            weights: self.weights * factor,
            brightness: self.brightness * factor,
            squares: self.squares * factor,
            squared_weights: self.squared_weights * squared,
            variances: self.variances * squared,
        }
    }

    /// Returns the means. Where a sample has a single path, the variance follows from the samples' spread.
    pub(crate) fn means(&self) -> LightParts {
        let rest = self.rest.to_array();
        if self.surface <= 0.0 || self.normal == Vec3::ZERO {
            return LightParts { normal: NO_NORMAL, rest, ..LightParts::default() };
        }
        let over = 1.0 / self.weights.max(Vec2::splat(f32::MIN_POSITIVE));
        let [mean, squares] = [self.brightness * over, self.squares * over];
        let several = self.squared_weights * over * over;
        let spread = (squares - mean * mean).max(Vec2::ZERO) * several / (1.0 - several).max(Vec2::splat(1e-3));
        let own = self.variances * over * over;
        let variance = |weight: f32, own: f32, spread: f32| match (weight > 0.0, own > 0.0) {
            (false, _) => NO_LIGHT,
            (true, true) => own,
            (true, false) => spread,
        };
        // A channel that no sample reflects still has light, which its neighbours average.
        let is_dark = self.albedo.cmple(Vec3::splat(1e-6));
        let diffuse = Vec3::select(is_dark, self.diffuse * over.x, self.lit / self.albedo.max(Vec3::splat(1e-6)));
        let [point_x, point_y, point_z] = (self.point / self.surface).to_array();
        LightParts {
            diffuse: diffuse.to_array(),
            diffuse_variance: variance(self.weights.x, own.x, spread.x),
            glossy: (self.glossy / self.surface).to_array(),
            glossy_variance: variance(self.weights.y, own.y, spread.y),
            albedo: self.albedo.to_array(),
            normal: pack_normal(self.normal.normalize()),
            rest,
            point_x,
            point_y,
            point_z,
            coverage: self.surface,
            lobe_width: self.lobe_width / self.surface,
            reflectance: self.reflectance.to_array(),
            _pad: 0,
        }
    }
}

/// Returns the unit vector that `pack_normal` has packed.
fn from_octahedral(packed: u32) -> Vec3 {
    let part = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let flat = Vec2::new(part(packed), part(packed >> 16));
    let z = 1.0 - flat.abs().element_sum();
    let sign = Vec2::select(flat.cmpge(Vec2::ZERO), Vec2::ONE, Vec2::NEG_ONE);
    let place = if z < 0.0 { (1.0 - Vec2::new(flat.y, flat.x).abs()) * sign } else { flat };
    place.extend(z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn seen(albedo: f32, diffuse: f32, normal: Vec3) -> LightParts {
        LightParts {
            diffuse: [diffuse; 3],
            albedo: [albedo; 3],
            normal: pack_normal(normal),
            rest: [0.25; 3],
            ..LightParts::default()
        }
    }

    #[test]
    fn normals_survive_folding() {
        let mut random = Random::new(1);
        for _ in 0..1000 {
            let normal = random.point(1.0).normalize_or(Vec3::Z);
            assert!(from_octahedral(pack_normal(normal)).distance(normal) < 1e-4, "{normal}");
        }
        for axis in Vec3::AXES {
            for normal in [axis, -axis] {
                assert!(from_octahedral(pack_normal(normal)).distance(normal) < 1e-4, "{normal}");
                assert_ne!(pack_normal(normal), NO_NORMAL);
            }
        }
    }

    #[test]
    fn a_pixel_is_as_bright_as_its_samples_together() {
        let mut sums = PartSums::default();
        let samples = [seen(0.5, 2.0, Vec3::X), seen(0.1, 4.0, Vec3::Z), seen(0.0, 8.0, Vec3::Z)];
        samples.iter().for_each(|parts| sums.add(parts, 0.25));
        sums.add(&LightParts { normal: NO_NORMAL, rest: [1.0; 3], ..LightParts::default() }, 0.25);
        let mean = sums.means();
        let brightness = mean.rest[0] + mean.albedo[0] * mean.diffuse[0];
        assert!((brightness - 0.25 * (1.0 + 0.4 + 3.0 * 0.25 + 1.0)).abs() < 1e-6, "{brightness}");
        // Three samples of brightness 2, 4 and 8 have the variance 28/3; their mean has a third of it.
        assert!((mean.diffuse_variance - 28.0 / 9.0).abs() < 1e-3, "{}", mean.diffuse_variance);
        assert_eq!((mean.coverage, mean.glossy_variance), (0.75, 0.0));
        assert_eq!(PartSums::default().means().normal, NO_NORMAL);
        // A surface without diffuse reflection says nothing of diffuse light, and a black one does.
        let mut sums = PartSums::default();
        sums.add(&LightParts { diffuse_variance: NO_LIGHT, ..seen(0.0, 0.0, Vec3::X) }, 0.5);
        assert_eq!(sums.means().diffuse_variance, NO_LIGHT);
        sums.add(&seen(0.0, 3.0, Vec3::X), 0.5);
        assert_eq!(sums.means().diffuse, [3.0; 3]);
    }
}
