//! Errors by region, and the rows of the table.

use stereotrace::{Channel, Finish, MISS, Material, Scene, StereoPair, Values, View};

/// Difference between neighbouring pixels' light that makes an edge, as a share of it.
const EDGE: f64 = 0.05;

pub(crate) const HEAD: &str = "\
| scene | paths | method | pair ms | second eye by time | by rays | rms error | of naive's | matte | edges | glossy | \
clear | mean % | +- | between eyes |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|";

/// Region of a pixel, by the surface that it shows.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Region {
    Other,
    Matte,
    Edge,
    Glossy,
    Clear,
}

/// Regions of the pixels of the right view.
pub(crate) struct Regions(Vec<Region>);

impl Regions {
    pub(crate) fn of(scene: &Scene, limit: &StereoPair) -> Self {
        let view = &limit.right;
        let width = view.width as usize;
        let light = |pixel: usize| f64::from(view.linear[pixel][1]);
        let region = |pixel: usize| {
            let primitive = view.primitive[pixel];
            let Some(region) = material_of(scene, primitive).map(region_of) else { return Region::Other };
            let is_edge = |other: usize| (light(pixel) - light(other)).abs() > EDGE * light(pixel);
            let column = pixel % width;
            let beside = [(column > 0).then(|| pixel - 1), (column + 1 < width).then_some(pixel + 1)];
            let is_at_edge = beside.into_iter().flatten().any(is_edge);
            if region == Region::Matte && is_at_edge { Region::Edge } else { region }
        };
        Self((0..view.primitive.len()).map(region).collect())
    }
}

fn material_of(scene: &Scene, primitive: u32) -> Option<&Material> {
    if primitive == MISS {
        return None;
    }
    let index = primitive as usize;
    let triangles = scene.triangles();
    let sphere = || scene.spheres().get(index - triangles.len()).map(|sphere| sphere.material);
    let material = triangles.get(index).map(|triangle| triangle.material).or_else(sphere)?;
    scene.materials().get(material.0 as usize)
}

fn region_of(material: &Material) -> Region {
    if let Some(surface) = &material.principled {
        return if surface.transmission > 0.0 { Region::Clear } else { Region::Glossy };
    }
    match material.finish {
        Finish::Glass { .. } => Region::Clear,
        _ if material.opacity < 1.0 => Region::Clear,
        _ if material.specular.max_element() > 0.0 => Region::Glossy,
        _ if material.emission.max_element() > 0.0 => Region::Other,
        _ => Region::Matte,
    }
}

/// Errors of several pictures.
#[derive(Clone, Default)]
pub(crate) struct Errors {
    /// Sum of squares and number of values of each region, the whole picture last.
    squares: [(f64, f64); 6],
    /// Mean of each picture relative to the converged one's, less 1.
    means: Vec<f64>,
    /// Sum of squares and number of the differences between both eyes' errors, at corresponding matte pixels.
    between: (f64, f64),
}

/// Corresponding pixels: a matte pixel of the right view, and the place between two left pixels that shows the same
/// point.
pub(crate) struct Corresponding(Vec<(usize, usize, f64)>);

impl Corresponding {
    /// Largest difference of disparities at which two pixels show one point, in pixels.
    const NEAR: f32 = 0.5;

    pub(crate) fn of(limit: &StereoPair, regions: &Regions) -> Result<Self, stereotrace::Error> {
        let width = limit.right.width as usize;
        let disparity = |channels: stereotrace::Channels<'_>| -> Result<Vec<f32>, stereotrace::Error> {
            match channels.get(Channel::Disparity)? {
                Values::Floats(values) => Ok(values.into_owned()),
                other => unreachable!("disparities are floats, not {other:?}"),
            }
        };
        let (left, right) = (disparity(limit.left_channels(None))?, disparity(limit.right_channels(None))?);
        let place = |pixel: usize| {
            let column = (pixel % width) as f32 + right[pixel];
            let (first, way) = (column.floor(), f64::from(column.fract()));
            let is_inside = regions.0[pixel] == Region::Matte && first >= 0.0 && first + 1.0 < width as f32;
            let other = is_inside.then(|| pixel - pixel % width + first as usize)?;
            let is_same = |at: usize| (left[at] - right[pixel]).abs() < Self::NEAR;
            (is_same(other) && is_same(other + 1)).then_some((pixel, other, way))
        };
        Ok(Self((0..right.len()).filter_map(place).collect()))
    }
}

impl Errors {
    pub(crate) fn add(&mut self, view: &View, limit: &View, regions: &Regions) {
        let (mut sum, mut of_limit) = (0.0, 0.0);
        for ((color, limit), region) in view.linear.iter().zip(&limit.linear).zip(&regions.0) {
            for channel in 0..3 {
                let (value, limit) = (f64::from(color[channel]), f64::from(limit[channel]));
                let square = (value - limit).powi(2);
                for place in [*region as usize, 5] {
                    self.squares[place].0 += square;
                    self.squares[place].1 += 1.0;
                }
                (sum, of_limit) = (sum + value, of_limit + limit);
            }
        }
        self.means.push(sum / of_limit - 1.0);
    }

    /// Adds the differences between both eyes' errors.
    pub(crate) fn add_between(&mut self, pair: &StereoPair, limit: &StereoPair, places: &Corresponding) {
        for &(right, left, way) in &places.0 {
            for channel in 0..3 {
                let of = |view: &View, pixel: usize| f64::from(view.linear[pixel][channel]);
                let error = |view: fn(&StereoPair) -> &View, at: usize| of(view(pair), at) - of(view(limit), at);
                let beside = |at: usize| error(|pair| &pair.left, at);
                let difference = error(|pair| &pair.right, right) - (1.0 - way) * beside(left) - way * beside(left + 1);
                self.between.0 += difference * difference;
                self.between.1 += 1.0;
            }
        }
    }

    /// Returns the root mean square of the differences between both eyes' errors, relative to naive's error at matte
    /// pixels.
    fn between(&self, of_naive: &Self) -> f64 {
        (self.between.0 / self.between.1).sqrt() / of_naive.rms(Region::Matte as usize)
    }

    /// Returns the error of the whole picture.
    pub(crate) fn whole(&self) -> f64 {
        self.rms(5)
    }

    fn rms(&self, place: usize) -> f64 {
        let (sum, count) = self.squares[place];
        (sum / count).sqrt()
    }

    /// Returns the mean of the pictures' relative differences, and its standard error.
    fn bias(&self) -> [f64; 2] {
        let count = self.means.len() as f64;
        let mean = self.means.iter().sum::<f64>() / count;
        let variance = self.means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        [mean, (variance / count).sqrt()]
    }
}

/// Returns a method's row. `cost` holds milliseconds, and the second eye's cost by time and by counted rays.
pub(crate) fn row(
    scene: &str,
    samples: u32,
    method: &str,
    [ms, by_time, by_rays]: [f64; 3],
    errors: &Errors,
    of_naive: &Errors,
) -> String {
    let share = |place: usize| format!("{:.2}", errors.rms(place) / of_naive.rms(place));
    let [matte, edges, glossy, clear] = [Region::Matte, Region::Edge, Region::Glossy, Region::Clear]
        .map(|region| if errors.squares[region as usize].1 > 0.0 { share(region as usize) } else { "-".into() });
    let [mean, deviation] = errors.bias().map(|share| 100.0 * share);
    format!(
        "| {scene} | {samples} | {method} | {ms:.0} | {by_time:.2} | {by_rays:.2} | {:.4} | {} | {matte} | {edges} | \
        {glossy} | {clear} | {mean:+.2} | {deviation:.2} | {:.2} |",
        errors.rms(5),
        share(5),
        errors.between(of_naive),
    )
}
