//! How pictures are rendered.

use clap::Args;
use stereotrace::{
    Adaptive, AmbientOcclusion, Filter, Finish, MAX_BOUNCES, Method, Options, Scene, ShadowBuffer, Tone, Visibility,
};

use super::values::{OcclusionArgument, adaptive, occlusion, shadow_buffer, size, tone};
use crate::studio;

/// Of an eye's picture, in pixels, where nothing is said.
pub(super) const SIZE: [u32; 2] = [1280, 720];

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Picture")]
pub(crate) struct PictureArguments {
    /// Size of an eye's picture in pixels [default: 1280x720, or what --calib says]
    #[arg(long = "size", value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    pub(super) size_said: Option<[u32; 2]>,
    /// How the second eye is made: auto (bracket or naive, whichever is likely cheaper), naive, ideal, atomic, buffer,
    /// buffer-2e, buffer-N (slots), es-isler, adelson-hodges, atomic-edges, buffer-edges, bracket, verified or
    /// bracket-rays
    #[arg(long, default_value_t)]
    pub(crate) method: Method,
    /// Samples a pixel, which smooth edges: 1, 4, 9, 16, 25, 36, 49 or 64 [default: 4 for a file that is flattered,
    /// else 1]
    #[arg(long, value_name = "N")]
    pub(crate) samples: Option<u32>,
    /// In their place more samples only where those in a pixel's corners differ by more than TOL of 255, at up to
    /// LEVELS levels, 2 to 5
    #[arg(long, value_name = "TOL[:LEVELS]", value_parser = adaptive, conflicts_with = "samples", allow_hyphen_values = true)]
    pub(crate) adaptive: Option<Adaptive>,
    /// How samples are weighed: box, tent or gauss
    #[arg(long, value_name = "KIND", default_value_t)]
    filter: Filter,
    /// Whether rows of samples stand aside of their grid, which gives edges that are nearly upright more steps: true
    /// or false
    #[arg(long, value_name = "BOOL", default_value_t = true, action = clap::ArgAction::Set)]
    jitter: bool,
    /// Surfaces that a ray may come from, one behind the other, by reflection or refraction: 0 to 8
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(..=i64::from(MAX_BOUNCES)))]
    bounces: u32,
    /// Brighten pictures by so many stops, or darken them
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_hyphen_values = true)]
    exposure: f32,
    /// What becomes of what is too bright: clamp, or filmic
    #[arg(long, value_name = "clamp|filmic", default_value = "clamp", value_parser = tone)]
    tone: Tone,
    /// Of the random numbers of soft light and jitter: the same seed makes the same picture
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Rays of a sample to each light that is not a point, 1 to 32 [default: 16; 4 where a flattered file's samples
    /// are not said]
    #[arg(long, value_name = "N")]
    shadow_rays: Option<u32>,
    /// Let what stands near keep ambient light off: by N rays a sample, 1 to 32, as far as RADIUS world units
    /// [default: a tenth of the scene's diagonal]
    #[arg(long, value_name = "N[:RADIUS]", value_parser = occlusion)]
    pub(crate) occlusion: Option<OcclusionArgument>,
    /// Light surfaces by the sky in place of ambient light: by N rays a sample, 1 to 32. What they meet keeps its
    /// light off
    #[arg(long, value_name = "N", conflicts_with = "occlusion")]
    pub(crate) sky_light: Option<u32>,
    /// How the first hits of traced views are found: by rays, or by drawing each primitive over the pixels that it may
    /// cover, t-buffer
    #[arg(long, value_name = "KIND", default_value_t)]
    visibility: Visibility,
    /// Ask tables of directions around point lights, of so many rows, in place of shadow rays: by the nearest object
    /// alone, by its depth, or (hybrid) where they prove something, but for a margin, with rays elsewhere
    #[arg(long, value_name = "ROWS[:object|depth[=BIAS]|hybrid[=MARGIN]]", value_parser = shadow_buffer)]
    shadow_buffer: Option<ShadowBuffer>,
    /// Count BVH nodes and primitive tests (slower)
    #[arg(long)]
    count: bool,
}

impl PictureArguments {
    /// Of an eye's picture, in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.size_said.unwrap_or(SIZE)
    }

    /// The same where a scene is flattered of which little is said: with what flatters it, as far as nothing else is
    /// asked for.
    pub(crate) fn flattered(&self, lights_are_said: bool, scene: &Scene) -> Self {
        let mut settled = self.clone();
        if self.samples.is_none() && self.adaptive.is_none() {
            settled.shadow_rays.get_or_insert(studio::RAYS);
            settled.samples = Some(studio::SAMPLES);
        }
        // Occlusion takes glass as opaque: what stands in a glass case would be black.
        let has_glass = scene.materials().iter().any(|material| matches!(material.finish, Finish::Glass { .. }));
        if !lights_are_said && !has_glass && self.occlusion.is_none() && self.sky_light.is_none() {
            settled.occlusion = Some(OcclusionArgument(settled.shadow_rays.unwrap_or(16), None));
        }
        settled
    }

    /// What to render a scene with.
    pub(crate) fn options(&self, scene: &Scene, reach: f32) -> Options {
        let diagonal = scene.bounds().map(|(low, high)| low.distance(high) as f32).filter(|diagonal| *diagonal > 0.0);
        let occlusion = self.occlusion.and_then(|OcclusionArgument(rays, radius)| {
            let radius = radius.or(diagonal.map(|diagonal| reach * diagonal))?;
            Some(AmbientOcclusion::new(rays, radius))
        });
        let options = Options::new(self.method).visibility(self.visibility).seed(self.seed).count(self.count);
        let options = options.samples(self.samples.unwrap_or(1)).filter(self.filter).jitter(self.jitter);
        let options = options.adaptive(self.adaptive).bounces(self.bounces);
        let options = options.shadow_rays(self.shadow_rays.unwrap_or(16)).occlusion(occlusion).sky_rays(self.sky_light);
        options.exposure(self.exposure).tone(self.tone).shadow_buffer(self.shadow_buffer)
    }
}
