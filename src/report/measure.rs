//! Measures the methods on one scene at one size.

use std::time::Duration;

use web_time::Instant;

use super::{ReportEntry, ReportMethod};
use crate::{
    Builtin, Error, GpuWork, Method, Options, Renderer, Scene, Statistics, StereoCamera, StereoPair, UploadedScene,
    metrics,
};

/// A built-in scene on the device.
pub(super) struct Staged {
    builtin: Builtin,
    primitives: usize,
    uploaded: UploadedScene,
}

impl Staged {
    pub(super) async fn new(renderer: &Renderer, builtin: Builtin) -> Result<Self, Error> {
        Self::of(renderer, builtin, &builtin.scene()).await
    }

    async fn of(renderer: &Renderer, builtin: Builtin, scene: &Scene) -> Result<Self, Error> {
        Ok(Self { builtin, primitives: scene.primitive_count(), uploaded: renderer.upload(scene).await? })
    }

    /// Uploads the first scene and renders its first pair. Returns the time that both take.
    pub(super) async fn first(
        renderer: &mut Renderer,
        builtin: Builtin,
        [width, height]: [u32; 2],
    ) -> Result<(Self, Duration), Error> {
        let scene = builtin.scene();
        let begin = Instant::now();
        let staged = Self::of(renderer, builtin, &scene).await?;
        read(renderer, &staged.uploaded, &builtin.camera(width, height), Method::Auto).await?;
        Ok((staged, begin.elapsed()))
    }
}

/// A scene at one size, and how it is measured.
pub(super) struct Test<'a> {
    pub(super) scene: &'a Staged,
    pub(super) size: [u32; 2],
    /// `naive` is the first and `ideal` the second.
    pub(super) methods: &'a [Method],
    pub(super) rounds: usize,
}

/// A picture for an estimate has this share of the width and of the height.
const PROBE: u32 = 4;

impl Test<'_> {
    fn camera(&self) -> StereoCamera {
        self.scene.builtin.camera(self.size[0], self.size[1])
    }

    /// Returns an estimate of the time that all frames take, from a small picture by `naive`.
    pub(super) async fn expected(&self, renderer: &mut Renderer) -> Result<Duration, Error> {
        let uploaded = &self.scene.uploaded;
        let camera = self.camera().size(self.size[0] / PROBE, self.size[1] / PROBE);
        trace(renderer, uploaded, &camera, Method::Naive).await?; // compiles its kernels
        let begin = Instant::now();
        trace(renderer, uploaded, &camera, Method::Naive).await?;
        let frames = self.methods.len() * (self.rounds + 1);
        Ok(begin.elapsed() * PROBE * PROBE * frames as u32)
    }

    /// Returns the figures, and the time of all frames without the compilation of kernels.
    /// `tell` is called before each frame.
    ///
    /// # Errors
    /// Those of `tell`, and those of frames.
    pub(super) async fn measured(
        &self,
        renderer: &mut Renderer,
        tell: &mut impl FnMut() -> Result<(), Error>,
    ) -> Result<(ReportEntry, Duration), Error> {
        let Self { scene: Staged { builtin, primitives, uploaded }, size, methods, rounds } = *self;
        let camera = self.camera();
        let naive = read(renderer, uploaded, &camera, Method::Naive).await?;
        let difference = metrics::compare(&naive.right, &naive.right, &naive.pose)?;
        let mut compared = vec![(naive.statistics.clone(), difference)];
        for &method in &methods[1..] {
            tell()?;
            let pair = read(renderer, uploaded, &camera, method).await?;
            let difference = metrics::compare(&pair.right, &naive.right, &pair.pose)?;
            compared.push((pair.statistics, difference));
        }
        let begin = Instant::now();
        let mut times = vec![Vec::new(); methods.len()];
        let mut works = vec![GpuWork::default(); methods.len()];
        for round in 0..rounds {
            // The order rotates, so that no method is always the one after an expensive one.
            for turn in 0..methods.len() {
                tell()?;
                let index = (round + turn) % methods.len();
                let (begin, before) = (Instant::now(), renderer.gpu().work());
                let statistics = trace(renderer, uploaded, &camera, methods[index]).await?;
                let wall = begin.elapsed();
                works[index] = renderer.gpu().work() - before;
                times[index].push((statistics.times.map_or(wall, |times| times.total()), wall));
            }
        }
        let frames = begin.elapsed() / rounds as u32 * (rounds as u32 + 1);
        let sorted = |mut times: Vec<Duration>| {
            times.sort_unstable();
            times
        };
        let sort = |times: Vec<(Duration, Duration)>| {
            let (pairs, walls) = times.into_iter().unzip();
            (sorted(pairs), sorted(walls))
        };
        let times = Vec::from_iter(times.into_iter().map(sort));
        let first_eye = middle(&times[1].0).as_secs_f64(); // of ideal
        let mut rows = Vec::new();
        for (index, ((statistics, difference), (pairs, walls))) in compared.iter().zip(&times).enumerate() {
            rows.push(ReportMethod {
                method: methods[index],
                pair: middle(pairs),
                range: [pairs[0], pairs[pairs.len() - 1]],
                wall: middle(walls),
                second_eye: middle(pairs).as_secs_f64() / first_eye - 1.0,
                rays: [statistics.left.rays, statistics.right.rays],
                retraced: statistics.retraced_share(),
                identical_percent: difference.identical_percent,
                wrong_surface_percent: difference.wrong_surface_percent,
                intermediate_bytes: statistics.intermediate_bytes,
                chosen: statistics.choice.map(|choice| choice.method),
                work: works[index],
            });
        }
        let ids = hash_of(naive.left.primitive.iter().chain(&naive.right.primitive));
        let info = uploaded.info();
        let entry = ReportEntry {
            scene: *builtin,
            size,
            primitives: *primitives,
            scene_bytes: info.node_bytes + info.primitive_bytes,
            build: info.build,
            ids,
            has_known_ids: known_ids(*builtin, size).map(|known| known == ids),
            methods: rows,
        };
        Ok((entry, frames))
    }
}

async fn read(
    renderer: &mut Renderer,
    scene: &UploadedScene,
    camera: &StereoCamera,
    method: Method,
) -> Result<StereoPair, Error> {
    renderer.pair(scene, camera).options(&Options::new(method)).read().await
}

async fn trace(
    renderer: &mut Renderer,
    scene: &UploadedScene,
    camera: &StereoCamera,
    method: Method,
) -> Result<Statistics, Error> {
    renderer.pair(scene, camera).options(&Options::new(method)).trace().await
}

/// Returns the median of sorted times.
fn middle(sorted: &[Duration]) -> Duration {
    sorted[sorted.len() / 2]
}

/// Returns the FNV-1a hash of numbers, 64 bits wide.
pub(super) fn hash_of<'a>(numbers: impl Iterator<Item = &'a u32>) -> u64 {
    let bytes = numbers.flat_map(|number| number.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Returns the hash of the ids that a software adapter finds by `naive`.
pub(super) fn known_ids(scene: Builtin, size: [u32; 2]) -> Option<u64> {
    match (scene, size) {
        (Builtin::Hall, [640, 360]) => Some(0xcce9_ab8b_55e5_1e74),
        (Builtin::Spheres, [640, 360]) => Some(0x916c_6dd6_d43f_fdc4),
        (Builtin::Near, [640, 360]) => Some(0xd8e4_dd60_12ed_c96a),
        (Builtin::Random1000, [640, 360]) => Some(0x42bd_a14b_d202_36a8),
        (Builtin::HallFinished, [640, 360]) => Some(0x74d9_761e_7986_8670),
        _ => None,
    }
}
