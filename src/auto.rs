//! Which way to the right view costs less: what `Method::Auto` asks once a band of the left view is there (shaders/choose.wgsl).

use std::fmt;

use crate::{Gpu, Method, Pose, wgpu};

/// What [`Method::Auto`] chose, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Choice {
    /// The method that made most of the right view: [`Method::BRACKET`] or [`Method::Naive`]. It is chosen for each band of rows.
    pub method: Method,
    /// The share that was made by bracket, 0 to 1.
    pub by_bracket: f32,
    /// Share of right pixels in gaps that no left sample saw, 0 to 1.
    pub gaps: f32,
    /// Shadow rays a pixel of the left view.
    pub shadow_rays: f32,
    /// What the right view was predicted to cost by bracket, in primary rays a pixel.
    pub bracket: f32,
    /// The same by naive.
    pub naive: f32,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { method, by_bracket, gaps, shadow_rays, bracket, naive } = self;
        let share = if *method == Method::Naive { 1.0 - by_bracket } else { *by_bracket };
        let part = if share < 1.0 { format!(" for {:.0}% of the rows", 100.0 * share) } else { String::new() };
        write!(
            f,
            "{method}{part}: the right view is predicted to cost {bracket:.2} primary rays a pixel by bracket, {naive:.2} by naive \
             ({shadow_rays:.1} shadow rays a left pixel, {:.1}% of right pixels in gaps)",
            100.0 * gaps
        )
    }
}

/// What passes cost on an adapter, in primary rays of whole pictures.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CostModel {
    /// A pixel's share of bounding, searching and resolving tiles.
    pub(crate) search: f32,
    /// A shadow ray among a whole picture's.
    pub(crate) shadow: f32,
    /// A shadow ray of a list, relative to that.
    pub(crate) listed: f32,
}

impl CostModel {
    /// Share of shadow bits, away from gaps, that left samples don't agree in: 2 to 8% on meshes and halls. (As in shaders/choose.wgsl.)
    const DISAGREED: f32 = 0.05;

    /// CPU: medians over spheres, hall, `sponza_4x`, dragon and `buddha_1m2` on llvmpipe (docs/BRACKET.md). GPU: from counted nodes and
    /// primitive tests, not measured.
    pub(crate) fn of(gpu: &Gpu) -> Self {
        match gpu.adapter_info().device_type {
            wgpu::DeviceType::Cpu => Self { search: 1.0, shadow: 0.9, listed: 3.0 },
            _ => Self { search: 0.35, shadow: 0.8, listed: 1.5 },
        }
    }

    /// Of a left view with so many shadow rays, and so many right pixels in gaps.
    pub(crate) fn choose(self, pose: &Pose, shadow_rays: u64, gap_pixels: u64) -> Choice {
        let pixels = pose.size[0] as f32 * pose.size[1] as f32;
        let (shadow_rays, gaps) = (shadow_rays as f32 / pixels, (gap_pixels as f32 / pixels).min(1.0));
        let shadows = self.shadow * shadow_rays;
        let naive = 1.0 + shadows;
        let bracket = self.search + self.listed * shadows * (gaps + Self::DISAGREED).min(1.0);
        let method = if bracket < naive { Method::BRACKET } else { Method::Naive };
        let by_bracket = if method == Method::Naive { 0.0 } else { 1.0 };
        Choice { method, by_bracket, gaps, shadow_rays, bracket, naive }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::StereoCamera;

    #[test]
    fn few_shadow_rays_or_wide_gaps_make_it_naive() {
        let pose = StereoCamera::look_at(Vec3::Z, Vec3::ZERO).size(100, 100).pose().unwrap();
        let model = CostModel { search: 1.0, shadow: 0.9, listed: 3.0 };
        let chosen = |shadow_rays, gaps| model.choose(&pose, shadow_rays, gaps).method;
        assert_eq!(chosen(30_000, 300), Method::BRACKET);
        assert_eq!(chosen(30_000, 5000), Method::Naive);
        assert_eq!(chosen(0, 0), Method::Naive);
        let text = model.choose(&pose, 30_000, 300).to_string();
        assert!(
            text.starts_with("bracket: ") && text.contains("3.0 shadow rays") && text.contains("3.0% of"),
            "{text}"
        );
    }
}
