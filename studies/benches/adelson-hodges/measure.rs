//! Measures a method on a scene, in the paper's figures.

use stereotrace::{
    Error, Method, Options, PixelSource, Renderer, Scene, StereoCamera, StereoPair, UploadedScene, View,
    blocking::Wait,
    metrics::{self, Difference},
};

use crate::counts::{options, rays_as_in_the_paper};

/// Figures of a right view, in percent except for distances. Savings are relative to `Naive`'s right view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Figures {
    /// Right pixels that are traced.
    pub(crate) traced: f64,
    /// Traced pixels at the left ends of rows.
    pub(crate) left_edge: f64,
    /// Share of rays that are saved.
    pub(crate) rays: f64,
    /// Share of rays that are saved if reused pixels keep their shadow rays, as in the paper.
    pub(crate) rays_as_in_the_paper: f64,
    /// Share of nodes and primitive tests that are saved.
    pub(crate) counters: f64,
    /// Difference of the view from `Naive`'s.
    pub(crate) difference: Difference,
    /// Share of the summed RGB distances that lies on glass.
    pub(crate) on_glass: f64,
    /// Share of the summed RGB distances on pixels that show another object than the true one.
    pub(crate) on_others: f64,
}

impl Figures {
    /// Returns the mean RGB distance of all pixels, including identical ones.
    pub(crate) fn distance_of_all(&self) -> f64 {
        self.difference.differing_percent / 100.0 * self.difference.mean_difference
    }
}

/// Renders pairs of a scene and compares them with `Naive`'s.
pub(crate) struct Subject<'a> {
    scene: &'a Scene,
    uploaded: UploadedScene,
    camera: StereoCamera,
    samples: u32,
    pub(crate) naive: StereoPair,
}

impl<'a> Subject<'a> {
    pub(crate) fn new(
        renderer: &mut Renderer,
        scene: &'a Scene,
        camera: StereoCamera,
        samples: u32,
    ) -> Result<Self, Error> {
        let uploaded = renderer.upload(scene).wait()?;
        let naive = renderer
            .pair(&uploaded, &camera)
            .options(&options(Method::Naive).samples(samples).jitter(false))
            .read()
            .wait()?;
        Ok(Self { scene, uploaded, camera, samples, naive })
    }

    pub(crate) fn pair(&self, renderer: &mut Renderer, method: Method) -> Result<StereoPair, Error> {
        renderer.pair(&self.uploaded, &self.camera).options(&self.options(method)).read().wait()
    }

    fn options(&self, method: Method) -> Options {
        options(method).samples(self.samples).jitter(false)
    }

    pub(crate) fn figures(&self, renderer: &mut Renderer, method: Method) -> Result<Figures, Error> {
        let pair = self.pair(renderer, method)?;
        let (found, naive) = (&pair.statistics.right, &self.naive.statistics.right);
        let saved = |found: u64, naive: u64| 100.0 * (1.0 - found as f64 / naive as f64);
        // For several samples per pixel, and for methods other than the paper's, the traced rays are used.
        let as_in_the_paper = match method {
            Method::Sweep(_) if self.samples == 1 => rays_as_in_the_paper(renderer, self.scene, &self.camera, &pair)?,
            _ => found.rays.total(),
        };
        Ok(Figures {
            traced: 100.0 * pair.statistics.retraced_share(),
            left_edge: 100.0 * left_edge(&pair) as f64 / pair.source.len() as f64,
            rays: saved(found.rays.total(), naive.rays.total()),
            rays_as_in_the_paper: saved(as_in_the_paper, naive.rays.total()),
            counters: saved(found.cost(), naive.cost()),
            difference: metrics::compare(&pair.right, &self.naive.right, &pair.pose)?,
            on_glass: self.share_of_distances(&pair.right, |_, truth| self.is_glass(truth)),
            on_others: self.share_of_distances(&pair.right, |found, truth| found != truth),
        })
    }

    /// Returns a share of the summed RGB distances of all pixels, in percent. It is the share of pixels for whose found
    /// and true objects `wanted` holds.
    fn share_of_distances(&self, right: &View, wanted: impl Fn(u32, u32) -> bool) -> f64 {
        let truth = &self.naive.right;
        let (mut all, mut share) = (0.0, 0.0);
        for (index, (a, b)) in right.rgba8.iter().zip(&truth.rgba8).enumerate() {
            let square = |channel: usize| f64::from(a[channel].abs_diff(b[channel])).powi(2);
            let distance = (square(0) + square(1) + square(2)).sqrt();
            all += distance;
            share += if wanted(right.object[index], truth.object[index]) { distance } else { 0.0 };
        }
        if all > 0.0 { 100.0 * share / all } else { 0.0 }
    }

    /// Returns whether an object is glass. Objects are the floor, then spheres, then ellipsoids.
    fn is_glass(&self, object: u32) -> bool {
        let meshes = self.scene.object_count() - self.scene.spheres().len() - self.scene.ellipsoids().len();
        let Some(ball) = (object as usize).checked_sub(meshes) else { return false };
        let spheres = self.scene.spheres().iter().map(|sphere| sphere.material);
        let material = spheres.chain(self.scene.ellipsoids().iter().map(|one| one.material)).nth(ball);
        material.is_some_and(|id| self.scene.materials()[id.0 as usize].name == "refractive")
    }
}

/// Returns the number of pixels between the left end of each row and its first reused pixel, summed over the rows.
fn left_edge(pair: &StereoPair) -> usize {
    let rows = pair.source.chunks_exact(pair.right.width as usize);
    rows.map(|row| row.iter().take_while(|source| **source != PixelSource::Reused).count()).sum()
}
