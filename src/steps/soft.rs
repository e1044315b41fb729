//! Soft light: extended lights, and ambient or sky light that surroundings occlude. The steps first find a view's hits.
//! They then sample each light source, a few rays per dispatch, so that no thread does more work than an adapter
//! allows. Finally they shade the view.

use super::step;
use crate::{
    Light, Options, Scene,
    frame::{
        plan::{Launch, Step},
        uniforms::Part,
    },
    kernel::{Hits, Kernel, Resource::Lists, Role, Shading, kernel},
};

pub(crate) const TRACE_HITS: Kernel = kernel!("soft", "trace_hits", Role::Hits(Hits::View));
pub(crate) const TRACE_SOFT: Kernel = kernel!("soft", "trace_soft", Role::Shade(Shading::Soft));
/// Samples soft light for listed pixels that were traced.
pub(crate) const TRACE_SOFT_LISTED: Kernel = kernel!("soft", "trace_soft_listed", Role::Shade(Shading::SoftListed));
/// Samples soft light for pixels with an unknown visible share.
pub(crate) const TRACE_SOFT_ASKED: Kernel =
    Kernel { name: "trace_soft_asked", role: Role::Shade(Shading::SoftUnknown), ..TRACE_SOFT_LISTED };
pub(crate) const SHADE_HITS: Kernel = kernel!("soft", "shade_hits", Role::Shade(Shading::Source));

/// Number of rays of a part: `ASKED_GROUPS` groups of four (shaders/shared/soft.wgsl).
const PART_RAYS: u32 = 16;

/// The soft lights of a scene, in the form that frames use.
#[derive(Clone, Debug, Default)]
pub(crate) struct SoftLights {
    /// Number of lights of all kinds.
    lights: u32,
    /// Index of each light that is not a point, and whether one ray to it suffices.
    soft: Vec<(u32, bool)>,
    casts: bool,
}

impl SoftLights {
    pub(crate) fn of(scene: &Scene) -> Self {
        let place = |(index, light): (usize, &Light)| (index as u32, light.is_sharp());
        let soft = scene.soft_lights().map(place).collect();
        Self { lights: scene.lights.len() as u32, soft, casts: scene.shadows }
    }

    /// Returns the light sources in the order of their slots, ambient light first. Each entry has the light's index,
    /// the number of rays, and whether surfaces can hide the light.
    fn sources(&self, options: &Options) -> impl Iterator<Item = (u32, u32, bool)> + '_ {
        let shadow_rays = options.shadow_rays;
        let lights =
            self.soft.iter().map(move |&(light, sharp)| (light, if sharp { 1 } else { shadow_rays }, self.casts));
        let ambient = options.surroundings().map(|occlusion| (self.lights, occlusion.rays, true));
        ambient.into_iter().chain(lights)
    }

    pub(crate) fn count(&self, options: &Options) -> u32 {
        self.sources(options).count() as u32
    }

    /// Returns the number of soft light rays per pixel.
    pub(crate) fn rays(&self, options: &Options) -> u32 {
        self.sources(options).filter(|(.., hidden)| *hidden).map(|(_, rays, _)| rays).sum()
    }

    pub(crate) fn parts(&self, options: &Options) -> Vec<Part> {
        let parts = |(slot, (light, rays, hidden)): (usize, (u32, u32, bool))| {
            let firsts = (0..if hidden { rays } else { 0 }).step_by(PART_RAYS as usize);
            firsts.map(move |first| Part::Soft { light, slot: slot as u32, first })
        };
        self.sources(options).enumerate().flat_map(parts).collect()
    }
}

fn asked(kernel: &'static Kernel, view: usize, launch: Launch, parts: usize) -> impl Iterator<Item = Step> {
    (0..parts).map(move |part| Step::Run { name: kernel.name, kernel, view, launch, part })
}

/// Returns the steps that find a whole view's hits, sample its soft light and shade it.
pub(crate) fn traced(view: usize, launch: Launch, parts: usize) -> Vec<Step> {
    let mut steps = vec![step(&TRACE_HITS, view, launch)];
    steps.extend(behind_hits(view, launch, parts));
    steps
}

/// Returns the steps that sample soft light for a whole view with known hits, and shade it.
pub(crate) fn behind_hits(view: usize, launch: Launch, parts: usize) -> Vec<Step> {
    asked(&TRACE_SOFT, view, launch, parts).chain([step(&SHADE_HITS, view, launch)]).collect()
}

/// Returns the steps that sample soft light for listed pixels that a method traced. Shading comes later.
pub(crate) fn listed(view: usize, list: u32, parts: Option<usize>) -> Vec<Step> {
    asked(&TRACE_SOFT_LISTED, view, Launch::Listed(Lists, list), parts.unwrap_or(0)).collect()
}

/// Returns the steps that sample soft light for pixels that `bracket` listed. Shading comes later.
pub(crate) fn unknown(kernel: &'static Kernel, view: usize, list: u32, parts: Option<usize>) -> Vec<Step> {
    asked(kernel, view, Launch::Listed(Lists, list), parts.unwrap_or(0)).collect()
}
