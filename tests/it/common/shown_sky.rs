//! Sky maps in double precision: the colour in a direction, and the light that a surface receives.

use stereotrace::{
    SkyMap,
    glam::{DVec3, Vec3},
};

use super::random::Random;

const PI: f64 = std::f64::consts::PI;

/// A map with the kernels' bilinear interpolation, in double precision.
pub(crate) struct Shown {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<Vec3>,
}

impl Shown {
    pub(crate) fn map(&self) -> SkyMap {
        SkyMap::new(self.width as u32, self.height as u32, self.pixels.clone()).unwrap()
    }

    /// Returns the colour at a position, in pixels from the left and from the top.
    pub(crate) fn at(&self, x: f64, y: f64) -> DVec3 {
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (right_share, lower_share) = (x - 0.5 - left, y - 0.5 - top);
        let pixel = |column: f64, row: f64| {
            let beyond = row < 0.0 || row >= self.height as f64;
            let row = row.clamp(0.0, self.height as f64 - 1.0) as usize;
            let turned = column as i64 + if beyond { self.width as i64 / 2 } else { 0 };
            self.pixels[row * self.width + turned.rem_euclid(self.width as i64) as usize].as_dvec3()
        };
        let across = |row: f64| pixel(left, row).lerp(pixel(left + 1.0, row), right_share);
        across(top).lerp(across(top + 1.0), lower_share)
    }

    /// Returns the light of a white surface. It is a sum over `fine` x `fine` parts of each pixel. Only parts in
    /// directions for which `is_open` holds send light.
    pub(crate) fn light(&self, normal: DVec3, fine: usize, is_open: impl Fn(DVec3) -> bool) -> DVec3 {
        let [columns, rows] = [self.width * fine, self.height * fine];
        let mut sum = DVec3::ZERO;
        for row in 0..rows {
            let down = (row as f64 + 0.5) / rows as f64 * PI;
            // The solid angle of the band between two circles of latitude is exact.
            let edges = [row as f64, row as f64 + 1.0].map(|edge| (edge / rows as f64 * PI).cos());
            let angle = (edges[0] - edges[1]) * 2.0 * PI / columns as f64;
            for column in 0..columns {
                let around = ((column as f64 + 0.5) / columns as f64 - 0.5) * 2.0 * PI;
                let d = DVec3::new(down.sin() * around.sin(), down.cos(), -down.sin() * around.cos());
                let cosine = d.dot(normal);
                if cosine > 0.0 && is_open(d) {
                    let place = [column, row].map(|index| (index as f64 + 0.5) / fine as f64);
                    sum += self.at(place[0], place[1]) * (angle * cosine / PI);
                }
            }
        }
        sum
    }
}

/// Returns a map of noise, from dark to bright, with a sun of one pixel in it.
pub(crate) fn noisy(width: usize, height: usize) -> Shown {
    let mut random = Random(7);
    let mut pixels: Vec<Vec3> =
        (0..width * height).map(|_| Vec3::from_array(std::array::from_fn(|_| random.unit().powi(4)))).collect();
    pixels[height / 5 * width + width / 3] = Vec3::new(300.0, 200.0, 100.0);
    Shown { width, height, pixels }
}
