//! The `auto` method and its cost model. The method chooses between `bracket` and `naive` once a band of the left view
//! is traced (shaders/bracket/choose.wgsl).

use std::fmt;

use super::{Promise, Target};
use crate::{
    Gpu, Method, ShadowReuse,
    frame::plan::{Made, Stage},
    steps::bracket,
    wgpu,
};

pub(super) const PROMISE: Promise = Promise { bits: ShadowReuse::Two, samples: true, ..Promise::of(Made::Chosen) };

pub(super) fn stages(Target { view, soft, search, .. }: Target) -> Vec<Stage> {
    vec![Stage::Steps(bracket::or_traced(view, soft, search))]
}

/// The choice of [`Method::Auto`] and its reasons.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Choice {
    /// The method that made most of the right view: [`Method::BRACKET`] or [`Method::Naive`]. Each band of rows has
    /// its own choice.
    pub method: Method,
    /// Share of the right view's rows that `bracket` made, 0 to 1.
    pub by_bracket: f32,
    /// Share of right pixels in gaps that no left sample saw, 0 to 1.
    pub gaps: f32,
    /// Shadow rays per pixel of the left view. If it recalled results of such rays from an earlier frame, this is at
    /// least the number in the last frame that recalled none.
    pub shadow_rays: f32,
    /// Secondary rays per pixel of the left view, by mirrors, glass and transparent surfaces. The right view traces as
    /// many with either method.
    pub secondary_rays: f32,
    /// Predicted cost of the right view by `bracket`, in primary rays per pixel.
    pub bracket: f32,
    /// Predicted cost of the right view by `naive`, in primary rays per pixel.
    pub naive: f32,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { method, by_bracket, gaps, shadow_rays, secondary_rays, bracket, naive } = self;
        let sent =
            if *secondary_rays > 0.0 { format!(" and {secondary_rays:.1} secondary ones") } else { String::new() };
        let share = if *method == Method::Naive { 1.0 - by_bracket } else { *by_bracket };
        let part = if share < 1.0 { format!(" for {:.0}% of the rows", 100.0 * share) } else { String::new() };
        write!(
            f,
            "{method}{part}: the right view is predicted to cost {bracket:.2} primary rays per pixel by bracket, \
             {naive:.2} by naive ({shadow_rays:.1} shadow rays{sent} per left pixel, {:.1}% of right pixels in gaps)",
            100.0 * gaps
        )
    }
}

/// What [`Method::Auto`] chooses by: costs of the passes on an adapter, in primary rays of whole pictures. By default
/// they are constants for CPU adapters and for GPUs. [`Renderer::calibrate`](crate::Renderer::calibrate) measures them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Time of a primary ray, in seconds; 0 if it is not measured. On a GPU, slow rays make submissions smaller, so
    /// that none takes too long for its watchdog.
    pub ray_seconds: f32,
    /// Cost per pixel of finding the right view's surfaces by `bracket`. Below 1 it is cheaper than tracing them.
    pub search: f32,
    /// Cost of a shadow ray that `bracket` saves, at least 0.1.
    pub shadow: f32,
}

/// Times of a pair by both methods, for a calibration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trial {
    /// Time of one view without lights, in seconds.
    pub(crate) primary: f64,
    /// Times of a pair by `naive` and by `bracket`, in seconds.
    pub(crate) times: [f64; 2],
    pub(crate) pixels: f64,
    pub(crate) seen: Seen,
}

impl Calibration {
    /// Costs of a shadow ray that noisy times can't exceed. Three drivers of software adapters have 0.16 to 0.42.
    const SHADOW: [f64; 2] = [0.1, 1.0];

    /// Returns the constants of an adapter. Those of CPU adapters are medians over spheres, hall, `sponza_4x`, dragon
    /// and `buddha_1m2` on llvmpipe (studies/notes/bracket.md). Those of GPUs follow from counted nodes and primitive
    /// tests; they are not measured.
    pub(crate) fn of(gpu: &Gpu) -> Self {
        match gpu.adapter_info().device_type {
            wgpu::DeviceType::Cpu => Self { ray_seconds: 0.0, search: 1.0, shadow: 0.9 },
            _ => Self { ray_seconds: 0.0, search: 0.35, shadow: 0.8 },
        }
    }

    /// Returns the costs that explain the times best. The errors of a trial are relative to its time by `naive`. The
    /// time of a ray is that of the slowest scene.
    pub(crate) fn fitted(self, gpu: &Gpu, trials: &[Trial]) -> Self {
        let model = CostModel::of(gpu, self, Asked { points: 1, soft: 0, shares: true });
        // Solves for a and b in (bracket - naive) / primary = a - b * saved, with saved shadow rays per pixel.
        let [mut ww, mut wws, mut wwss, mut wwy, mut wwsy] = [0.0; 5];
        for trial in trials {
            let [naive, bracket] = trial.times;
            let saved = trial.saved(model);
            let (weight, y) = ((trial.primary / naive).powi(2), (bracket - naive) / trial.primary);
            ww += weight;
            wws += weight * saved;
            wwss += weight * saved * saved;
            wwy += weight * y;
            wwsy += weight * saved * y;
        }
        let slope = (ww * wwsy - wws * wwy) / (ww * wwss - wws * wws);
        let shadow =
            if slope.is_finite() { (-slope).clamp(Self::SHADOW[0], Self::SHADOW[1]) } else { f64::from(self.shadow) };
        let search = 1.0 + (wwy + shadow * wws) / ww;
        let ray = trials.iter().map(Trial::ray_seconds).fold(0.0, f32::max);
        if search.is_finite() { Self { ray_seconds: ray, search: search as f32, shadow: shadow as f32 } } else { self }
    }
}

impl Trial {
    fn ray_seconds(&self) -> f32 {
        (self.primary / self.pixels) as f32
    }

    /// Returns the number of shadow rays per pixel that `bracket` saves by the model.
    fn saved(&self, model: CostModel) -> f64 {
        let [shadow, own, gaps] = [self.seen.shadow_rays, self.seen.own_shadow_rays, self.seen.gap_pixels]
            .map(|count| (count as f64 / self.pixels) as f32);
        f64::from((shadow - own) * (1.0 - model.asked_anew(gaps.min(1.0))))
    }

    /// Returns the costs by which `Auto` takes the faster method for a frame like this one, with this number of light
    /// rays per point. If that is `naive`, no number of saved rays pays, so that `Auto` knows it before the first step.
    pub(crate) fn settled(&self, model: CostModel, rays: u32) -> Calibration {
        let [naive, bracket] = self.times;
        let shadow = f64::from(model.shadow);
        let saved = if bracket < naive { self.saved(model) } else { f64::from(rays) };
        let search = 1.0 + (bracket - naive) / self.primary + shadow * saved;
        // A clock may be too coarse for any time.
        let search = if search.is_finite() { search as f32 } else { model.search };
        Calibration { ray_seconds: self.ray_seconds(), search, shadow: model.shadow }
    }
}

/// Cost of the passes on an adapter, in primary rays of whole pictures, and the share of shadow rays that can't be
/// reused.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CostModel {
    /// Cost per pixel of bounding, searching and resolving tiles.
    pub(crate) search: f32,
    /// Cost of a shadow ray in a pass over a whole picture.
    pub(crate) shadow: f32,
    /// Cost of a shadow ray in a pass over a list of pixels, relative to [`Self::shadow`].
    pub(crate) listed: f32,
    /// Cost of the shadow rays that are traced outside gaps because left samples disagree, relative to all shadow rays.
    /// It is the mean of `listed` times the share of these rays.
    pub(crate) disagreed: f32,
    /// Minimum number of shadow rays per pixel that the left view asks for. It recalls the results of some of them from
    /// an earlier frame, and does not trace these.
    pub(crate) asked: f32,
}

/// The light queries of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    /// Shadow rays per point to point lights.
    pub(crate) points: u32,
    /// Rays per point to extended lights and to the surroundings.
    pub(crate) soft: u32,
    /// Whether visible shares of soft lights are reused in addition to visibility bits.
    pub(crate) shares: bool,
}

/// Ray counts of a left view, and the right pixels that no left sample saw.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    pub(crate) shadow_rays: u64,
    /// Shadow rays that began on surfaces seen in mirrors and glass; each eye traces its own.
    pub(crate) own_shadow_rays: u64,
    pub(crate) secondary_rays: u64,
    pub(crate) gap_pixels: u64,
}

impl Seen {
    pub(crate) const NOTHING: Self = Self { shadow_rays: 0, own_shadow_rays: 0, secondary_rays: 0, gap_pixels: 0 };
}

impl CostModel {
    /// Share of the shadow bits outside gaps in which left samples disagree: 2 to 8% on meshes and halls.
    const DISAGREED: f32 = 0.05;
    /// [`Self::DISAGREED`] for soft light rays, without and with reuse of shares, from the counts of
    /// studies/notes/bracket.md.
    const DISAGREED_SOFT: [f32; 2] = [0.74, 0.1];
    /// Cost of a soft light ray in a pass over a list of pixels, relative to a pass over a whole picture. It is low
    /// because neighbouring pixels trace these rays in the same order.
    const LISTED_SOFT: f32 = 1.5;

    /// Creates the cost model of an adapter for a frame's light queries.
    pub(crate) fn of(gpu: &Gpu, calibration: Calibration, asked: Asked) -> Self {
        let is_cpu = gpu.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let Calibration { search, shadow, .. } = calibration;
        let listed: f32 = if is_cpu { 3.0 } else { 1.5 };
        let [points, soft] = [asked.points, asked.soft].map(|rays| rays as f32);
        let all = (points + soft).max(1.0);
        let (listed_soft, share) = (Self::LISTED_SOFT.min(listed), Self::DISAGREED_SOFT[usize::from(asked.shares)]);
        Self {
            search,
            shadow: shadow.max(Calibration::SHADOW[0] as f32), // also if it is NaN
            listed: (points * listed + soft * listed_soft) / all,
            disagreed: (points * listed * Self::DISAGREED + soft * listed_soft * share) / all,
            asked: 0.0,
        }
    }

    /// Returns the cost of the shadow rays that `bracket` traces, relative to all shadow rays of a whole picture.
    fn asked_anew(self, gaps: f32) -> f32 {
        (self.listed * gaps + self.disagreed).min(self.listed)
    }

    /// Returns the minimum number of shadow rays saved per pixel that makes the search pay (as in
    /// shaders/bracket/choose.wgsl).
    pub(crate) fn least_spared(self) -> f32 {
        (self.search - 1.0) / self.shadow
    }

    /// Chooses for a view of this size, which is larger than the picture with several samples per pixel.
    pub(crate) fn choose(self, size: [u32; 2], seen: Seen) -> Choice {
        let pixels = size[0] as f32 * size[1] as f32;
        let [shadow_rays, own, secondary_rays, gaps] =
            [seen.shadow_rays, seen.own_shadow_rays, seen.secondary_rays, seen.gap_pixels]
                .map(|count| count as f32 / pixels);
        let gaps = gaps.min(1.0);
        // Each eye traces these rays itself, with either method.
        let sent = self.listed * (secondary_rays + self.shadow * own);
        let shadow_rays = shadow_rays.max(self.asked + own);
        let shadows = self.shadow * (shadow_rays - own);
        let naive = 1.0 + shadows + sent;
        let bracket = self.search + self.asked_anew(gaps) * shadows + sent;
        let method = if bracket < naive { Method::BRACKET } else { Method::Naive };
        let by_bracket = if method == Method::Naive { 0.0 } else { 1.0 };
        Choice { method, by_bracket, gaps, shadow_rays, secondary_rays, bracket, naive }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [100, 100];

    const MODEL: CostModel = CostModel { search: 1.0, shadow: 0.9, listed: 3.0, disagreed: 0.15, asked: 0.0 };

    #[test]
    fn few_shadow_rays_or_wide_gaps_make_it_naive() {
        let seen = |shadow_rays, gap_pixels| Seen { shadow_rays, gap_pixels, ..Seen::default() };
        let chosen = |shadow_rays, gaps| MODEL.choose(SIZE, seen(shadow_rays, gaps)).method;
        assert_eq!(chosen(30_000, 300), Method::BRACKET);
        assert_eq!(chosen(30_000, 5000), Method::Naive);
        assert_eq!(chosen(0, 0), Method::Naive);
        let recalled = CostModel { asked: 3.0, ..MODEL }.choose(SIZE, seen(200, 300));
        assert_eq!(recalled, MODEL.choose(SIZE, seen(30_000, 300)));
        let text = MODEL.choose(SIZE, seen(30_000, 300)).to_string();
        assert!(
            text.starts_with("bracket: ") && text.contains("3.0 shadow rays") && text.contains("3.0% of"),
            "{text}"
        );
    }

    #[test]
    fn what_mirrors_ask_is_each_eye_s_own_and_saves_nothing() {
        let model = CostModel { search: 1.5, ..MODEL };
        let seen = Seen { shadow_rays: 10_000, gap_pixels: 300, ..Seen::default() };
        assert_eq!(model.choose(SIZE, seen).method, Method::BRACKET);
        let mirrored = Seen { own_shadow_rays: 5000, secondary_rays: 4000, ..seen };
        let choice = model.choose(SIZE, mirrored);
        assert_eq!(choice.method, Method::Naive, "{choice}");
        assert!(choice.naive > 3.0 * 0.4 && choice.to_string().contains("0.4 secondary"), "{choice}");
    }

    fn trial(primary: f64, times: [f64; 2], shadow_rays: u64, gap_pixels: u64) -> Trial {
        let seen = Seen { shadow_rays, gap_pixels, ..Seen::default() };
        Trial { primary, times, pixels: 10_000.0, seen }
    }

    #[test]
    fn a_calibration_finds_the_costs_that_made_the_times() {
        let gpu = Gpu::under_test();
        let (search, shadow) = (1.4, 0.3);
        let times = |primary: f64, trial: Trial| {
            let model = CostModel::of(&gpu, Calibration::of(&gpu), Asked { points: 1, soft: 0, shares: true });
            let naive = 2.0 * primary * (1.0 + 0.7 * trial.seen.shadow_rays as f64 / trial.pixels);
            [naive, naive + primary * (search - 1.0 - shadow * trial.saved(model))]
        };
        let of = |(primary, shadow_rays, gaps)| {
            let trial = trial(primary, [0.0; 2], shadow_rays, gaps);
            Trial { times: times(primary, trial), ..trial }
        };
        let trials = [(2.0, 9000, 300), (2.0, 50_000, 300), (0.5, 6000, 1500), (0.5, 30_000, 1500)].map(of);
        let found = Calibration::of(&gpu).fitted(&gpu, &trials);
        assert!((f64::from(found.search) - search).abs() < 1e-4, "{found:?}");
        assert!((f64::from(found.shadow) - shadow).abs() < 1e-4, "{found:?}");
        assert_eq!(found.ray_seconds, 2.0 / 10_000.0);
        // Times that say nothing change nothing.
        assert_eq!(Calibration::of(&gpu).fitted(&gpu, &[]), Calibration::of(&gpu));
    }

    #[test]
    fn a_settled_calibration_takes_the_faster_method() {
        for (bracket, method) in [(2.9, Method::BRACKET), (3.1, Method::Naive)] {
            let trial = trial(0.4, [3.0, bracket], 30_000, 500);
            let Calibration { ray_seconds, search, shadow } = trial.settled(MODEL, 5);
            assert_eq!(ray_seconds, 0.4 / 10_000.0);
            let choice = CostModel { search, shadow, ..MODEL }.choose(SIZE, trial.seen);
            assert_eq!(choice.method, method, "{choice}");
            // Whether all five rays can be saved is not yet known before the first step.
            let early =
                CostModel { search, shadow, ..MODEL }.choose(SIZE, Seen { shadow_rays: 50_000, ..Seen::default() });
            assert_eq!(early.method, method, "{early}");
        }
    }
}
