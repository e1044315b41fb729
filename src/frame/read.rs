//! What a frame made, read back to the host.

use super::{
    Traced,
    plan::Made,
    targets::{Target, Targets},
};
use crate::{
    Check, Error, GBuffer, Method, Options, PixelSource, Rays, Renderer, RigView, ShadowSource, Statistics, StereoPair,
    UploadedScene, View, Views, Work, layout,
};

/// What was counted of a view.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    shadow_rays: u64,
    nodes: u64,
    primitive_tests: u64,
    bad: u64,
    missed: u64,
    pub(crate) lost_candidates: u64,
    /// Threads whose loops an adapter ended.
    cut_short: u64,
}

impl Counts {
    fn of(counters: &[u32]) -> Self {
        let sum = |word| sum_of(counters, word);
        Self {
            shadow_rays: sum(layout::SHADOW_RAYS),
            nodes: sum(layout::NODES_VISITED),
            primitive_tests: sum(layout::PRIMITIVES_TESTED),
            bad: sum(layout::BAD_PIXELS),
            missed: sum(layout::MISSED_PIXELS),
            lost_candidates: sum(layout::LOST_CANDIDATES),
            cut_short: sum(layout::CUT_SHORT),
        }
    }
}

/// In how many threads of all views an adapter cut loops short.
pub(crate) fn threads_cut_short(counts: &[Counts]) -> u64 {
    counts.iter().map(|counts| counts.cut_short).sum()
}

/// A view, and how its pixels came about.
pub(crate) struct ReadView {
    pub(crate) view: View,
    pub(crate) source: Vec<PixelSource>,
    /// By `bracket` only.
    pub(crate) shadow_source: Vec<ShadowSource>,
}

impl Traced {
    /// The method that made a view.
    pub(crate) fn method_of(&self, view: usize) -> Method {
        match self.choices[view] {
            _ if self.eyes.sources[view] == view => Method::Naive,
            Some(choice) => choice.method,
            None => self.method,
        }
    }

    /// What a view cost, and how many of its pixels were taken over from its source.
    pub(crate) fn work(&self, view: usize) -> (Work, u64) {
        let counts = &self.counts[view];
        let [width, height] = self.eyes.pose.size.map(u64::from);
        let pixels = width * height;
        let (primary, verification, reused) = match self.method_of(view) {
            Method::Naive | Method::Auto => (pixels, 0, 0),
            Method::Ideal => (0, 0, pixels),
            Method::Atomic(_) | Method::Buffer(..) | Method::Sweep(_) | Method::Bracket(_) => {
                let landed = pixels - counts.missed;
                let checked =
                    matches!(self.method_of(view), Method::Atomic(Check::All) | Method::Buffer(_, Check::All));
                (counts.bad + counts.missed, if checked { landed } else { 0 }, landed - counts.bad)
            }
        };
        let rays = Rays { primary, verification, shadow: counts.shadow_rays };
        (Work { rays, nodes: counts.nodes, primitive_tests: counts.primitive_tests }, reused)
    }

    /// Of a pair.
    pub(crate) fn pair_statistics(&self) -> Statistics {
        let (right, reused) = self.work(1);
        Statistics {
            method: self.method_of(1),
            choice: self.choices[1],
            in_steps: self.in_steps,
            left: self.work(0).0,
            right,
            reused,
            bad: self.counts[1].bad,
            missed: self.counts[1].missed,
            lost_candidates: self.counts[1].lost_candidates,
            buffer_depth: self.buffer_depth,
            times: self.times.clone(),
            intermediate_bytes: self.intermediate_bytes,
        }
    }
}

impl Renderer {
    /// What was counted of each view.
    pub(crate) async fn counts(&self, targets: &Targets) -> Result<Vec<Counts>, Error> {
        let words = targets.shape.size[1] as usize * layout::COUNTERS;
        let mut counts = Vec::new();
        for view in 0..targets.shape.views {
            let counters: Vec<u32> = self.gpu.read(targets.get(Target::Counters, view), words).await?;
            counts.push(Counts::of(&counters));
        }
        Ok(counts)
    }

    pub(crate) async fn read_pair(
        &self,
        scene: &UploadedScene,
        options: &Options,
        traced: Traced,
    ) -> Result<StereoPair, Error> {
        let left = self.read_view(scene, options, &traced, 0).await?.view;
        let ReadView { view: right, source, shadow_source } = self.read_view(scene, options, &traced, 1).await?;
        let statistics = traced.pair_statistics();
        Ok(StereoPair { left, right, source, shadow_source, statistics, pose: traced.eyes.pose })
    }

    pub(crate) async fn read_views(
        &self,
        scene: &UploadedScene,
        options: &Options,
        traced: Traced,
    ) -> Result<Views, Error> {
        let mut views = Vec::new();
        for index in 0..traced.eyes.sources.len() {
            let ReadView { view, source, shadow_source } = self.read_view(scene, options, &traced, index).await?;
            views.push(RigView {
                view,
                offset: traced.eyes.offsets[index],
                made_from: traced.eyes.sources[index],
                method: traced.method_of(index),
                choice: traced.choices[index],
                source,
                shadow_source,
                work: traced.work(index).0,
            });
        }
        let Traced { times, in_steps, intermediate_bytes, .. } = traced;
        Ok(Views { views, pose: traced.eyes.pose, times, in_steps, intermediate_bytes })
    }

    async fn read_view(
        &self,
        scene: &UploadedScene,
        options: &Options,
        traced: &Traced,
        view: usize,
    ) -> Result<ReadView, Error> {
        let (targets, [width, height]) = (&traced.targets, traced.eyes.pose.size);
        let count = width as usize * height as usize;
        let pixels: Vec<layout::Pixel> = self.gpu.read(targets.get(Target::View, view), count).await?;
        let linear = match options.linear {
            true => self.gpu.read(targets.get(Target::Linear, view), count).await?,
            false => Vec::new(),
        };
        let counters = height as usize * layout::COUNTERS;
        let cost = match options.cost_map {
            true => self.gpu.read(targets.get(Target::Counters, view), counters + count).await?.split_off(counters),
            false => Vec::new(),
        };
        let (with_depth, with_ids) = (options.g_buffer != GBuffer::None, options.g_buffer == GBuffer::Ids);
        let each = |wanted: bool| pixels.iter().filter(move |_| wanted);
        let depth = |pixel: &layout::Pixel| if pixel.depth < crate::FAR { pixel.depth } else { f32::INFINITY };
        let id = |pixel: &layout::Pixel| scene.ids.get(pixel.slot as usize).copied().unwrap_or(crate::MISS);
        let primitive: Vec<u32> = each(with_ids).map(id).collect();
        let object = |id: &u32| scene.objects.get(*id as usize).copied().unwrap_or(crate::MISS);
        let made = traced.made[view];
        let source = match made {
            Made::Traced => vec![PixelSource::Traced; count],
            Made::Copied => vec![PixelSource::Reused; count],
            Made::Marked | Made::Bracketed => pixels.iter().map(|pixel| pixel_source(pixel.marks)).collect(),
        };
        let shadow_source = each(made == Made::Bracketed).map(|pixel| shadow_source_of(pixel.marks)).collect();
        let view = View {
            width,
            height,
            rgba8: pixels.iter().map(|pixel| pixel.color.to_le_bytes()).collect(),
            linear,
            depth: each(with_depth).map(depth).collect(),
            object: primitive.iter().map(object).collect(),
            primitive,
            cost,
        };
        Ok(ReadView { view, source, shadow_source })
    }
}

/// A counter of all rows.
pub(crate) fn sum_of(counters: &[u32], word: usize) -> u64 {
    counters.iter().skip(word).step_by(layout::COUNTERS).map(|&n| u64::from(n)).sum()
}

fn pixel_source(mark: u32) -> PixelSource {
    match mark {
        mark if mark & layout::MISSED != 0 => PixelSource::Missed,
        mark if mark & layout::BAD != 0 => PixelSource::Bad,
        _ => PixelSource::Reused,
    }
}

fn shadow_source_of(mark: u32) -> ShadowSource {
    if mark & layout::ASKED != 0 { ShadowSource::Traced } else { ShadowSource::Taken }
}
