//! Emitting primitives as light sources of paths (`shaders/shared/emitters.wgsl`).

use glam::Vec3;

use super::table::texel;
use crate::{Material, MaterialId, Scene, gpu::Texel, srgb::BRIGHTNESS};

/// Number of texels of an emitting primitive.
pub(crate) const TEXELS: usize = 4;

/// Kind of a sphere; `EMITTING_SPHERE` in emitters.wgsl.
const SPHERE: u32 = 1;

impl Material {
    /// Returns whether paths choose primitives of this material as light sources. They find others by chance: places on
    /// cut-out primitives may be holes, and emission and opacity may be a texture's.
    pub(crate) fn is_chosen(&self) -> bool {
        let is_textured = self.blends() || self.principled.is_some_and(|surface| surface.emission_texture.is_some());
        self.emission_to_paths() != Vec3::ZERO && self.opacity > 0.0 && self.cutout.is_none() && !is_textured
    }

    /// Returns the emitted radiance that paths see, without a texture.
    fn emission_to_paths(&self) -> Vec3 {
        self.principled.map_or(self.emission, |surface| surface.emission)
    }
}

/// The emitting primitives that paths choose.
pub(crate) struct Emitters {
    /// Four texels each.
    pub(crate) texels: Vec<Texel>,
    /// Sum of brightness times area.
    pub(crate) power: f32,
}

impl Emitters {
    /// Returns the number of the primitives.
    pub(crate) fn count(&self) -> usize {
        self.texels.len() / TEXELS
    }

    /// Returns the emitting triangles of a scene, and its emitting spheres. In scenes with ellipsoids, spheres are
    /// stored as ellipsoids, which are found by chance.
    pub(crate) fn of(scene: &Scene) -> Self {
        let mut found = Self { texels: Vec::new(), power: 0.0 };
        if !scene.materials().iter().any(Material::is_chosen) {
            return found;
        }
        let emission = |material: MaterialId| {
            let material = &scene.materials()[material.0 as usize];
            material.is_chosen().then(|| material.emission_to_paths() * material.opacity)
        };
        let brightness = |emission: Vec3| emission.as_dvec3().dot(BRIGHTNESS);
        let mut shares: Vec<f64> = Vec::new();
        let mut sum = 0.0;
        let mut add = |emission: Vec3, area: f64, [place, along, up]: [Vec3; 3], kind: u32| {
            let power = brightness(emission) * area;
            if !(power > 0.0 && power.is_finite()) {
                return;
            }
            sum += power;
            shares.push(sum);
            found.texels.extend([texel(place, 0), texel(along, kind), texel(up, 0), texel(emission, 0)]);
        };
        for triangle in scene.triangles() {
            let Some(emission) = emission(triangle.material) else { continue };
            let [a, b, c] = triangle.corners;
            let area = 0.5 * (b - a).as_dvec3().cross((c - a).as_dvec3()).length();
            add(emission, area, [a, b - a, c - a], 0);
        }
        for sphere in scene.spheres().iter().filter(|_| scene.ellipsoids().is_empty()) {
            let Some(emission) = emission(sphere.material) else { continue };
            let radius = f64::from(sphere.radius);
            let area = 4.0 * std::f64::consts::PI * radius * radius;
            add(emission, area, [sphere.center, Vec3::new(sphere.radius, 0.0, 0.0), Vec3::ZERO], SPHERE);
        }
        for (texels, share) in found.texels.chunks_exact_mut(TEXELS).zip(shares) {
            texels[0][3] = ((share / sum) as f32).to_bits();
        }
        found.power = sum as f32;
        found
    }
}
