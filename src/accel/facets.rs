//! Light that GGX facets reflect to a viewer under a white sky, as a table for kernels (`shaders/shared/facets.wgsl`).

use std::{f64::consts::PI, sync::OnceLock};

use crate::gpu::Texel;

/// Number of cosines, and of roughnesses, in the table.
pub(crate) const SIDE: usize = 32;

/// Samples per entry along each side of a square.
const SAMPLES: u32 = 16;

/// Returns the table: a row for each roughness (the square root of alpha), with cosines from 0 to 1. A texel holds the
/// shares of its cosine and of the next one.
pub(crate) fn reflected_shares() -> &'static [Texel] {
    static TABLE: OnceLock<Vec<Texel>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let place = |index: usize| index as f64 / (SIDE - 1) as f64;
        let row = |row: usize| (0..SIDE).map(move |column| shares(place(row).powi(2), place(column)));
        let texels = (0..SIDE).flat_map(|index| {
            let row: Vec<[f32; 2]> = row(index).collect();
            let texel = move |column: usize| {
                let ([a, b], [c, d]) = (row[column], row[(column + 1).min(SIDE - 1)]);
                [a, b, c, d].map(f32::to_bits)
            };
            (0..SIDE).map(texel)
        });
        texels.collect()
    })
}

/// Returns the reflected share of a white sky's light as two numbers, a and b. Facets with a reflectance of f at normal
/// incidence, by Schlick's approximation, reflect f a + b. `cosine` is that of the angle to the viewer. Facets are
/// sampled by those that the viewer sees (Heitz 2018, "Sampling the GGX Distribution of Visible Normals").
fn shares(alpha: f64, cosine: f64) -> [f32; 2] {
    let alpha = alpha.max(1e-4);
    let z = cosine.max(1e-3);
    let view = [(1.0 - z * z).max(0.0).sqrt(), 0.0, z];
    let stretched = normalized([alpha * view[0], 0.0, z]);
    // The first side is perpendicular to the stretched view direction; that direction has no y.
    let sides = [[0.0, 1.0, 0.0], [-stretched[2], 0.0, stretched[0]]];
    let (mut all, mut grazing) = (0.0, 0.0);
    for index in 0..SAMPLES * SAMPLES {
        let u = (f64::from(index) + 0.5) / f64::from(SAMPLES * SAMPLES);
        let turn = 2.0 * PI * f64::from(index.reverse_bits()) / 4_294_967_296.0;
        let (radius, blend) = (u.sqrt(), 0.5 * (1.0 + stretched[2]));
        let p = radius * turn.cos();
        let q = (1.0 - blend) * (1.0 - p * p).sqrt() + blend * radius * turn.sin();
        let along = (1.0 - p * p - q * q).max(0.0).sqrt();
        let part = |axis: usize| sides[0][axis] * p + sides[1][axis] * q + stretched[axis] * along;
        let facet = normalized([alpha * part(0), alpha * part(1), part(2).max(0.0)]);
        let aside = view[0] * facet[0] + view[2] * facet[2];
        let to_light = 2.0 * aside * facet[2] - z;
        if to_light > 0.0 && aside > 0.0 {
            // The share of visible facets that light reaches: height-correlated masking of both over that of one.
            let lambda = |z: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 - z * z).max(0.0) / (z * z)).sqrt() - 1.0);
            let share = (1.0 + lambda(z)) / (1.0 + lambda(z) + lambda(to_light));
            all += share;
            grazing += share * (1.0 - aside).max(0.0).powi(5);
        }
    }
    let count = f64::from(SAMPLES * SAMPLES);
    [((all - grazing) / count) as f32, (grazing / count) as f32]
}

fn normalized([x, y, z]: [f64; 3]) -> [f64; 3] {
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrates the reflectance over all directions of the light on a fine grid.
    fn integrated(alpha: f64, cosine: f64) -> [f64; 2] {
        let (rows, columns) = (4000, 360);
        let view = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
        let squared = alpha * alpha;
        let mut sums = [0.0; 2];
        for row in 0..rows {
            let z = (f64::from(row) + 0.5) / f64::from(rows);
            let aside = (1.0 - z * z).sqrt();
            for column in 0..columns {
                let turn = PI * (f64::from(column) + 0.5) / f64::from(columns);
                let light = [aside * turn.cos(), aside * turn.sin(), z];
                let half = normalized([view[0] + light[0], view[1] + light[1], view[2] + light[2]]);
                let d = half[2] * half[2] * (squared - 1.0) + 1.0;
                let density = squared / (PI * d * d);
                let lambda = |z: f64| 0.5 * ((1.0 + squared * (1.0 - z * z) / (z * z)).sqrt() - 1.0);
                let masking = 1.0 / (1.0 + lambda(cosine) + lambda(z));
                // Half of the hemisphere stands for all of it.
                let weight = 2.0 * PI / f64::from(rows * columns);
                let value = density * masking / (4.0 * cosine) * weight;
                let grazing = (1.0 - half[0] * light[0] - half[1] * light[1] - half[2] * light[2]).max(0.0).powi(5);
                sums[0] += value * (1.0 - grazing);
                sums[1] += value * grazing;
            }
        }
        sums
    }

    #[test]
    fn the_table_is_the_integral_of_the_reflectance() {
        for roughness in [0.3_f64, 0.5, 0.8, 1.0] {
            for cosine in [0.1, 0.3, 0.7, 1.0] {
                let (found, expected) = (shares(roughness.powi(2), cosine), integrated(roughness.powi(2), cosine));
                for (found, expected) in found.iter().zip(expected) {
                    let away = (f64::from(*found) - expected).abs();
                    assert!(away < 4e-3, "roughness {roughness}, cosine {cosine}: {found} for {expected}");
                }
            }
        }
    }
}
