//! Keeps the samples of a frame's traced view, and the position of its eye, for the next frame.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::executor::{Held, Resources};
use crate::{
    Error, Lighting, Options,
    gpu::{Gpu, Texel},
    kernel::{Resource, layout},
    scene::shadowing::{Kept, Shadowing},
};

/// Number of texels of an eye at the beginning of the samples' last row, and of a box after it (`history.wgsl`).
const EYE_TEXELS: u32 = 4;
const BOX_TEXELS: u32 = 2;
/// Maximum number of boxes of moved objects.
const MOST_BOXES: u32 = 16;

/// The scene that a history belongs to: its number, and its origin in world coordinates.
pub(crate) type SceneId = (u64, DVec3);

/// The samples of an earlier frame, and room for those of the current one.
#[derive(Debug)]
pub(crate) struct History {
    scene: SceneId,
    size: [u32; 2],
    /// Samples of the earlier frame and of the current one, each with a further row for their eye.
    samples: [wgpu::TextureView; 2],
    /// The light that paths brought to the samples, if it is recalled.
    light: Option<[wgpu::TextureView; 2]>,
    /// Bound and busy lights of each tile of the current view.
    bounds: wgpu::Buffer,
    /// The earlier frame; `None` before the first one.
    earlier: Option<Earlier>,
    /// Number of frames so far, and of paths that their samples followed each.
    frames: u32,
    paths: u32,
    /// Shadow rays per pixel that the traced view asked for: at least those of the last frame that recalled none.
    asked: f32,
}

/// The eye of an earlier frame's traced view, and what its visibility bits depend on.
#[derive(Debug)]
struct Earlier {
    eye: [Vec3; EYE_TEXELS as usize],
    lit: Lit,
}

/// What visibility bits depend on: the scene, and all options but those of counting, display and memory, and the number
/// of paths.
#[derive(Clone, Debug)]
pub(crate) struct Lit {
    scene: Arc<Shadowing>,
    options: Options,
}

impl Lit {
    pub(crate) fn of(scene: &Arc<Shadowing>, options: &Options) -> Self {
        let Options { count, cost_map, g_buffer, linear, exposure, tone, history, .. } = Options::default();
        let lighting = match options.lighting {
            Lighting::Direct => Lighting::Direct,
            Lighting::Paths { bounces, .. } => Lighting::Paths { bounces, samples: 1 },
        };
        let others = Options { count, cost_map, g_buffer, linear, exposure, tone, history, ..options.clone() };
        Self { scene: scene.clone(), options: Options { lighting, ..others } }
    }
}

/// The parts of a history that a frame reads and writes.
#[derive(Clone, Debug)]
pub(crate) struct Remembered {
    earlier: wgpu::TextureView,
    pub(crate) current: wgpu::TextureView,
    /// The light of the earlier frame's paths, and room for that of the current one's.
    light: Option<[wgpu::TextureView; 2]>,
    pub(crate) bounds: wgpu::Buffer,
}

/// How a frame uses a history.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Recall {
    /// Not at all.
    Nothing,
    /// It keeps the samples of its traced view.
    Keep,
    /// It also reads those of an earlier frame: their depths, their visibility bits if some of these hold, and the
    /// light that paths brought if nothing changed.
    Read { bits: bool, light: bool },
}

impl History {
    /// Returns the memory of a history in bytes, or `None` for a size that has none. `light` says whether it keeps the
    /// light that paths brought.
    pub(crate) fn bytes(gpu: &Gpu, [width, height]: [u32; 2], light: bool) -> Option<u64> {
        let most = gpu.limits.max_texture_dimension_2d;
        let fits = width >= EYE_TEXELS && width <= most && height < most;
        let samples = 2 * size_of::<Texel>() as u64 * u64::from(width) * (u64::from(height) + 1);
        fits.then(|| samples * if light { 2 } else { 1 } + bounds_bytes([width, height]))
    }

    /// Creates a history without any samples.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] and [`Error::DeviceLost`].
    pub(crate) async fn new(gpu: &Gpu, scene: SceneId, size: [u32; 2], light: bool) -> Result<Self, Error> {
        let texels = size[0] as usize * (size[1] as usize + 1);
        let make = || {
            let two = |label| [(); 2].map(|()| gpu.rows_of_texels(label, size[0], texels));
            let light = light.then(|| two("history_light"));
            Ok((two("history"), light, gpu.storage_buffer("history_bounds", bounds_bytes(size))))
        };
        let (samples, light, bounds) = gpu.checked(make).await?;
        let new = Self { scene, size, samples, light, bounds, earlier: None, frames: 0, paths: 0, asked: 0.0 };
        // The textures are filled for the reason of `samples_texture`.
        for view in new.textures() {
            gpu.fill_rows(view.texture(), 0, std::iter::repeat_n([0; 4], texels)).await?;
        }
        new.written(gpu).await?;
        Ok(new)
    }

    pub(crate) fn is_of(&self, scene: SceneId, size: [u32; 2], light: bool) -> bool {
        (self.scene, self.size, self.light.is_some()) == (scene, size, light)
    }

    /// Returns the number of paths that each sample followed so far.
    pub(crate) fn paths(&self) -> u32 {
        self.paths
    }

    /// Returns the number of shadow rays per pixel that the earlier frame's traced view asked for.
    pub(crate) fn asked(&self) -> f32 {
        self.asked
    }

    fn textures(&self) -> impl Iterator<Item = &wgpu::TextureView> {
        self.samples.iter().chain(self.light.iter().flatten())
    }

    /// Returns how a frame may use the history, and which of the earlier frame's visibility bits hold.
    pub(crate) fn recall(&self, lit: &Lit) -> (Recall, Option<Kept>) {
        let Some(earlier) = &self.earlier else { return (Recall::Keep, None) };
        let kept = self.kept(earlier, lit);
        let light = kept.as_ref().is_some_and(|kept| kept.unchanged);
        (Recall::Read { bits: kept.is_some(), light }, kept)
    }

    /// Returns which of an earlier frame's visibility bits hold in a frame; `None` if none do.
    fn kept(&self, earlier: &Earlier, lit: &Lit) -> Option<Kept> {
        let room = (self.size[0] - EYE_TEXELS) / BOX_TEXELS;
        let kept =
            (earlier.lit.options == lit.options).then(|| lit.scene.since(&earlier.lit.scene, room.min(MOST_BOXES)));
        kept.flatten().filter(|kept| kept.lights != 0)
    }

    /// Tells a frame's kernels the eye of the earlier frame, which of its visibility bits hold, and the number of paths
    /// that each sample follows in the frame.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] and [`Error::DeviceLost`].
    pub(crate) async fn tell(&self, gpu: &Gpu, kept: Option<&Kept>, paths: u32) -> Result<(), Error> {
        let Some(earlier) = &self.earlier else { return Ok(()) };
        let (lights, moved) = kept.map_or((0, &[][..]), |kept| (kept.lights, &kept.moved));
        let words = [self.frames, lights, moved.len() as u32, paths];
        let eye = earlier.eye.into_iter().zip(words);
        let boxes = moved.as_flattened().iter().map(|corner| (*corner, 0));
        let texels = eye.chain(boxes).map(|(vector, word)| {
            let [x, y, z] = vector.to_array().map(f32::to_bits);
            [x, y, z, word]
        });
        let begin = self.size[0] as usize * self.size[1] as usize;
        gpu.fill_rows(self.samples[0].texture(), begin, texels).await?;
        self.written(gpu).await
    }

    pub(crate) fn remembered(&self) -> Remembered {
        let [earlier, current] = self.samples.clone();
        Remembered { earlier, current, light: self.light.clone(), bounds: self.bounds.clone() }
    }

    /// Makes the current frame's samples those of the earlier frame. `eye` is the eye of the traced view, which asked
    /// for `asked` shadow rays per pixel, and followed this number of paths per sample.
    pub(crate) fn turn(&mut self, eye: &layout::Eyes, lit: Lit, asked: f32, paths: u32) {
        self.asked = asked;
        self.frames = self.frames.wrapping_add(1);
        self.paths = self.paths.wrapping_add(paths);
        self.samples.swap(0, 1);
        self.light.iter_mut().for_each(|light| light.swap(0, 1));
        let eye = [eye.target_eye, eye.target_corner, eye.step_x, eye.step_y].map(Vec3::from);
        self.earlier = Some(Earlier { eye, lit });
    }

    /// Passes on what is written so far. A texture may not be destroyed before that.
    async fn written(&self, gpu: &Gpu) -> Result<(), Error> {
        gpu.checked(|| Ok(gpu.submit([]))).await.map(drop)
    }
}

/// A browser frees textures only at garbage collection, unless they are destroyed.
impl Drop for History {
    fn drop(&mut self) {
        self.textures().for_each(|view| view.texture().destroy());
        self.bounds.destroy();
    }
}

impl Remembered {
    pub(crate) fn add_resources(&self, all: &mut Resources) {
        all.set(Resource::History, Held::from(&self.earlier));
        all.set(Resource::HistoryBounds, Held::from(&self.bounds));
        if let Some([earlier, current]) = &self.light {
            all.set(Resource::EarlierLight, Held::from(earlier));
            all.set(Resource::KeptLight, Held::from(current));
        }
    }
}

/// Returns the size of the bounds of all tiles in bytes.
fn bounds_bytes(size: [u32; 2]) -> u64 {
    let [columns, rows] = size.map(|side| u64::from(side.div_ceil(layout::TILE)));
    columns * rows * 4 * u64::from(layout::BOUND_WORDS)
}
