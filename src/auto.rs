//! Which way to the right view costs less: what `Method::Auto` asks once a band of the left view is there
//! (shaders/choose.wgsl).

use std::fmt;

use crate::{Gpu, Method, Pose, wgpu};

/// What [`Method::Auto`] chose, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Choice {
    /// The method that made most of the right view: [`Method::BRACKET`] or [`Method::Naive`]. It is chosen for each
    /// band of rows.
    pub method: Method,
    /// The share that was made by bracket, 0 to 1.
    pub by_bracket: f32,
    /// Share of right pixels in gaps that no left sample saw, 0 to 1.
    pub gaps: f32,
    /// Shadow rays a pixel of the left view.
    pub shadow_rays: f32,
    /// Rays a pixel of it that mirrors, glass and veils sent on. The right view's own cost as much by either way.
    pub secondary_rays: f32,
    /// What the right view was predicted to cost by bracket, in primary rays a pixel.
    pub bracket: f32,
    /// The same by naive.
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
            "{method}{part}: the right view is predicted to cost {bracket:.2} primary rays a pixel by bracket, {naive:.2} by naive \
             ({shadow_rays:.1} shadow rays{sent} a left pixel, {:.1}% of right pixels in gaps)",
            100.0 * gaps
        )
    }
}

/// What passes cost on an adapter, in primary rays of whole pictures, and how much of what is asked of lights a view
/// must ask anew.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CostModel {
    /// A pixel's share of bounding, searching and resolving tiles.
    pub(crate) search: f32,
    /// A shadow ray among a whole picture's.
    pub(crate) shadow: f32,
    /// A ray of a list, relative to that.
    pub(crate) listed: f32,
    /// Those that are asked anew though their points are in no gap, as they cost, relative to all: the mean of
    /// `listed` times a share.
    pub(crate) disagreed: f32,
}

/// What a frame asks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    /// Shadow rays a point to lights that are points.
    pub(crate) points: u32,
    /// To the others, and into the surroundings.
    pub(crate) soft: u32,
    /// Whether shares of these are taken over, besides bits.
    pub(crate) shares: bool,
}

/// What a left view's rays were, and what of the right view no left sample saw.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    pub(crate) shadow_rays: u64,
    /// Of these the ones that began where mirrors and glass sent rays to: each eye traces its own.
    pub(crate) own_shadow_rays: u64,
    pub(crate) secondary_rays: u64,
    pub(crate) gap_pixels: u64,
}

impl CostModel {
    /// Share of points' shadow bits, away from gaps, that left samples don't agree in: 2 to 8% on meshes and halls.
    const DISAGREED: f32 = 0.05;
    /// The same of rays to lights that are not points, where shares are taken over and where they are not: from the
    /// counts of studies/notes/bracket.md.
    const DISAGREED_SOFT: [f32; 2] = [0.74, 0.1];
    /// A ray of a list to such a light, which neighbours ask in the same order, relative to a whole picture's.
    const LISTED_SOFT: f32 = 1.5;

    /// CPU: medians over spheres, hall, `sponza_4x`, dragon and `buddha_1m2` on llvmpipe (studies/notes/bracket.md).
    /// GPU: from counted nodes and primitive tests, not measured.
    pub(crate) fn of(gpu: &Gpu, asked: Asked) -> Self {
        let is_cpu = gpu.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let (search, shadow, listed) = if is_cpu { (1.0, 0.9, 3.0) } else { (0.35, 0.8, 1.5) };
        let [points, soft] = [asked.points, asked.soft].map(|rays| rays as f32);
        let all = (points + soft).max(1.0);
        let (listed_soft, share) = (Self::LISTED_SOFT.min(listed), Self::DISAGREED_SOFT[usize::from(asked.shares)]);
        Self {
            search,
            shadow,
            listed: (points * listed + soft * listed_soft) / all,
            disagreed: (points * listed * Self::DISAGREED + soft * listed_soft * share) / all,
        }
    }

    /// What of its shadow rays a view asks anew by bracket, as they cost, relative to all of a whole picture's.
    fn asked_anew(self, gaps: f32) -> f32 {
        (self.listed * gaps + self.disagreed).min(self.listed)
    }

    /// As many shadow rays a pixel must be spared for the search to pay (as shaders/choose.wgsl asks).
    pub(crate) fn least_spared(self) -> f32 {
        (self.search - 1.0) / self.shadow
    }

    pub(crate) fn choose(self, pose: &Pose, seen: Seen) -> Choice {
        let pixels = pose.size[0] as f32 * pose.size[1] as f32;
        let [shadow_rays, own, secondary_rays, gaps] =
            [seen.shadow_rays, seen.own_shadow_rays, seen.secondary_rays, seen.gap_pixels]
                .map(|count| count as f32 / pixels);
        let gaps = gaps.min(1.0);
        // By either way the eye's own.
        let sent = self.listed * (secondary_rays + self.shadow * own);
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
    use glam::Vec3;

    use super::*;
    use crate::StereoCamera;

    fn pose() -> Pose {
        StereoCamera::look_at(Vec3::Z, Vec3::ZERO).size(100, 100).pose().unwrap()
    }

    const MODEL: CostModel = CostModel { search: 1.0, shadow: 0.9, listed: 3.0, disagreed: 0.15 };

    #[test]
    fn few_shadow_rays_or_wide_gaps_make_it_naive() {
        let seen = |shadow_rays, gap_pixels| Seen { shadow_rays, gap_pixels, ..Seen::default() };
        let chosen = |shadow_rays, gaps| MODEL.choose(&pose(), seen(shadow_rays, gaps)).method;
        assert_eq!(chosen(30_000, 300), Method::BRACKET);
        assert_eq!(chosen(30_000, 5000), Method::Naive);
        assert_eq!(chosen(0, 0), Method::Naive);
        let text = MODEL.choose(&pose(), seen(30_000, 300)).to_string();
        assert!(
            text.starts_with("bracket: ") && text.contains("3.0 shadow rays") && text.contains("3.0% of"),
            "{text}"
        );
    }

    #[test]
    fn what_mirrors_ask_is_each_eye_s_own_and_saves_nothing() {
        let model = CostModel { search: 1.5, ..MODEL };
        let seen = Seen { shadow_rays: 10_000, gap_pixels: 300, ..Seen::default() };
        assert_eq!(model.choose(&pose(), seen).method, Method::BRACKET);
        let mirrored = Seen { own_shadow_rays: 5000, secondary_rays: 4000, ..seen };
        let choice = model.choose(&pose(), mirrored);
        assert_eq!(choice.method, Method::Naive, "{choice}");
        assert!(choice.naive > 3.0 * 0.4 && choice.to_string().contains("0.4 secondary"), "{choice}");
    }
}
