//! What a frame made, read back to the host.

use super::{
    Traced,
    plan::RightView,
    targets::{Shape, Target, Targets},
};
use crate::{
    Check, Error, GBuffer, Method, Options, PixelSource, Pose, Rays, Renderer, ShadowSource, Statistics, StereoPair,
    UploadedScene, View, Work, layout, variant::Kept,
};

impl Renderer {
    /// What a frame cost, or in how many threads an adapter cut it short.
    pub(crate) async fn statistics(&self, targets: &Targets, method: Method) -> Result<Result<Statistics, u64>, Error> {
        let [width, height] = targets.shape.size;
        let words: Vec<u32> = self.gpu.read(targets.get(Target::Counters), height as usize * layout::COUNTERS).await?;
        let sum = |word| sum_of(&words, word);
        let pixels = u64::from(width) * u64::from(height);
        let cut_short = sum(layout::CUT_SHORT);
        if cut_short > 0 {
            return Ok(Err(cut_short));
        }
        let work = |eye: usize, primary, verification| Work {
            rays: Rays { primary, verification, shadow: sum(eye * layout::VIEW_WORDS + layout::SHADOW_RAYS) },
            nodes: sum(eye * layout::VIEW_WORDS + layout::NODES_VISITED),
            primitive_tests: sum(eye * layout::VIEW_WORDS + layout::PRIMITIVES_TESTED),
        };
        let times = match &self.timestamps {
            Some(timestamps) => timestamps.read(&self.gpu).await?,
            None => None,
        };
        let (bad, missed) = (sum(layout::BAD_PIXELS), sum(layout::MISSED_PIXELS));
        let (primary, verification, reused) = match method {
            Method::Naive | Method::Auto => (pixels, 0, 0),
            Method::Ideal => (0, 0, pixels),
            Method::Atomic(_) | Method::Buffer(..) | Method::Sweep(_) | Method::Bracket(_) => {
                let landed = pixels - missed;
                let checked = matches!(method, Method::Atomic(Check::All) | Method::Buffer(_, Check::All));
                (bad + missed, if checked { landed } else { 0 }, landed - bad)
            }
        };
        Ok(Ok(Statistics {
            method,
            left: work(0, pixels, 0),
            right: work(1, primary, verification),
            reused,
            bad,
            missed,
            lost_candidates: sum(layout::LOST_CANDIDATES),
            times,
            ..Statistics::default()
        }))
    }

    pub(crate) async fn read_pair(
        &self,
        scene: &UploadedScene,
        pose: Pose,
        options: &Options,
        traced: Traced,
    ) -> Result<StereoPair, Error> {
        let Traced { statistics, targets, right } = traced;
        let Shape { size: [width, height], kept, .. } = targets.shape;
        let pixels = width as usize * height as usize;
        // What bracket keeps has marks besides, so it is read whatever the user wants of it.
        let samples: Vec<layout::PixelHit> = match kept {
            Kept::Samples => self.gpu.read(targets.get(Target::Hits), 2 * pixels).await?,
            _ => Vec::new(),
        };
        let hits: Vec<layout::PixelHit> = match (options.g_buffer, kept) {
            (GBuffer::None, _) | (_, Kept::None) => Vec::new(),
            (_, Kept::Samples) => {
                let id = |word: u32| scene.ids.get((word & layout::NO_SLOT) as usize).copied().unwrap_or(crate::MISS);
                samples.iter().map(|hit| layout::PixelHit { primitive: id(hit.primitive), ..*hit }).collect()
            }
            (_, Kept::Ids) => self.gpu.read(targets.get(Target::Hits), 2 * pixels).await?,
            (_, Kept::Depth) => {
                let depths: Vec<f32> = self.gpu.read(targets.get(Target::Hits), 2 * pixels).await?;
                depths.into_iter().map(|depth| layout::PixelHit { depth, primitive: crate::MISS }).collect()
            }
        };
        let rgba8: Vec<[u8; 4]> = self.gpu.read(targets.get(Target::Pictures), 2 * pixels).await?;
        let counters = height as usize * layout::COUNTERS;
        let costs: Vec<u32> = match options.cost_map {
            true => self.gpu.read(targets.get(Target::Counters), counters + 2 * pixels).await?.split_off(counters),
            false => Vec::new(),
        };
        let view = |eye: usize, linear, hits: &[layout::PixelHit]| {
            let with_ids = if options.g_buffer == GBuffer::Ids { hits } else { &[] };
            let depth = |hit: &layout::PixelHit| if hit.depth < crate::FAR { hit.depth } else { f32::INFINITY };
            let object = |hit: &layout::PixelHit| scene.objects.get(hit.primitive as usize).copied();
            View {
                width,
                height,
                rgba8: rgba8[eye * pixels..(eye + 1) * pixels].to_vec(),
                linear,
                depth: hits.iter().map(depth).collect(),
                primitive: with_ids.iter().map(|hit| hit.primitive).collect(),
                cost: costs.get(eye * pixels..(eye + 1) * pixels).unwrap_or_default().to_vec(),
                object: with_ids.iter().map(|hit| object(hit).unwrap_or(crate::MISS)).collect(),
            }
        };
        let left_linear: Vec<[f32; 4]> = self.gpu.read(targets.get(Target::LeftColor), pixels).await?;
        let (left_hits, right_hits) = hits.split_at(hits.len() / 2);
        // Reused pixels are the left ones that right_source names.
        let mut right_hits = right_hits.to_vec();
        let mut shadow_source = Vec::new();
        let (source, right_linear) = match right {
            RightView::Traced => {
                (vec![PixelSource::Traced; pixels], self.gpu.read(targets.get(Target::RightColor), pixels).await?)
            }
            RightView::Left => {
                right_hits.copy_from_slice(left_hits);
                (vec![PixelSource::Reused; pixels], left_linear.clone())
            }
            RightView::Bracketed => {
                let marks = || samples[pixels..].iter().map(|hit| hit.primitive);
                let source = marks().map(pixel_source).collect();
                shadow_source = marks().map(shadow_source_of).collect();
                (source, self.gpu.read(targets.get(Target::RightColor), pixels).await?)
            }
            RightView::Marked => {
                let marks: Vec<u32> = self.gpu.read(targets.get(Target::RightSource), pixels).await?;
                let mut linear: Vec<[f32; 4]> = self.gpu.read(targets.get(Target::RightColor), pixels).await?;
                let source: Vec<_> = marks.iter().copied().map(pixel_source).collect();
                for (index, mark) in marks.iter().enumerate().filter(|(index, _)| source[*index] == PixelSource::Reused)
                {
                    let taken = index - index % width as usize + *mark as usize - 1;
                    linear[index] = left_linear[taken];
                    if let Some(hit) = right_hits.get_mut(index) {
                        *hit = left_hits[taken];
                    }
                }
                (source, linear)
            }
        };
        let left = view(0, left_linear, left_hits);
        let right = view(1, right_linear, &right_hits);
        Ok(StereoPair { left, right, source, shadow_source, statistics, pose })
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
