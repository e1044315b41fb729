//! Defines the options of rendering: size, method, samples, light transport and tone.

use clap::Args;
use stereotrace::{
    Adaptive, AmbientOcclusion, Filter, Finish, MAX_BOUNCES, Method, Options, Scene, ShadowBuffer, Tone, Visibility,
};

use super::values::{OcclusionArgument, adaptive, occlusion, shadow_buffer, size, tone};
use crate::studio;

/// Default size of an eye's picture: width and height in pixels.
pub(super) const SIZE: [u32; 2] = [1280, 720];

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Picture")]
pub(crate) struct PictureArguments {
    /// Size of one eye's picture in pixels [default: 1280x720, or the size in the --calib file]
    #[arg(long = "size", value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    pub(super) size_said: Option<[u32; 2]>,
    /// Method that renders the second eye: auto (the cheaper of bracket and naive), naive, bracket or another method
    ///
    /// auto predicts the cheaper method; naive traces both eyes; bracket reuses the left eye's shadows and shows the
    /// same surfaces as naive. Other methods are ideal, atomic, buffer, buffer-2e, buffer-N (N slots per pixel),
    /// es-isler, adelson-hodges, atomic-edges, buffer-edges, verified and bracket-rays.
    #[arg(long, default_value_t)]
    pub(crate) method: Method,
    /// Samples per pixel, for antialiasing: 1, 4, 9, 16, 25, 36, 49 or 64 [default: 4 for a file without --plain or
    /// --cameras, else 1]
    #[arg(long, value_name = "N")]
    pub(crate) samples: Option<u32>,
    /// Adaptive antialiasing in place of --samples: divide a pixel if samples in its corners differ by more than TOL
    /// of 255. LEVELS is 2 to 5 [default levels: 4]
    #[arg(
        long,
        value_name = "TOL[:LEVELS]",
        value_parser = adaptive,
        conflicts_with = "samples",
        allow_hyphen_values = true
    )]
    pub(crate) adaptive: Option<Adaptive>,
    /// Reconstruction filter that weights the samples of a pixel: box, tent or gauss
    #[arg(long, value_name = "KIND", default_value_t)]
    filter: Filter,
    /// Jitter the sample grid, so that near-vertical edges get more levels: true or false
    #[arg(long, value_name = "BOOL", default_value_t = true, action = clap::ArgAction::Set)]
    jitter: bool,
    /// Maximum number of reflections and refractions along a ray: 0 to 8
    #[arg(
        long,
        value_name = "N",
        default_value_t = 5,
        value_parser = clap::value_parser!(u32).range(..=i64::from(MAX_BOUNCES))
    )]
    bounces: u32,
    /// Exposure in stops, -64 to 64: each stop doubles the brightness
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_hyphen_values = true)]
    exposure: f32,
    /// Tone mapping: clamp values above 1, or filmic, a curve for all values
    #[arg(long, value_name = "clamp|filmic", default_value = "clamp", value_parser = tone)]
    tone: Tone,
    /// Seed of the random numbers for soft light, jitter and random cameras. Equal seeds give equal pictures
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Shadow rays per sample to each light that is not a point, 1 to 32 [default: 16; 4 for a file without --plain,
    /// --cameras, --samples or --adaptive]
    #[arg(long, value_name = "N")]
    shadow_rays: Option<u32>,
    /// Ambient occlusion by N rays per sample, 1 to 32, with occluders up to RADIUS world units away [default radius:
    /// 0.1 of the scene's diagonal, or 0.3 for a file without --plain or --cameras]
    #[arg(long, value_name = "N[:RADIUS]", value_parser = occlusion)]
    pub(crate) occlusion: Option<OcclusionArgument>,
    /// Light surfaces by the sky (image-based lighting) in place of ambient light, by N rays per sample, 1 to 32.
    /// Occluders block the sky's light
    #[arg(long, value_name = "N", conflicts_with = "occlusion")]
    pub(crate) sky_light: Option<u32>,
    /// Algorithm that finds the closest hits of traced views: rays, or t-buffer, which draws each primitive over the
    /// pixels that it may cover
    #[arg(long, value_name = "KIND", default_value_t)]
    visibility: Visibility,
    /// Use shadow buffers in place of shadow rays: tables of ROWS rows of directions around each point light. The rule
    /// compares objects, compares depths with a BIAS, or traces rays where the buffer is uncertain (hybrid, the
    /// default). BIAS and MARGIN are in texel widths
    #[arg(long, value_name = "ROWS[:object|depth[=BIAS]|hybrid[=MARGIN]]", value_parser = shadow_buffer)]
    shadow_buffer: Option<ShadowBuffer>,
    /// Count BVH nodes and primitive tests (slower)
    #[arg(long)]
    count: bool,
}

impl PictureArguments {
    /// Returns the size of an eye's picture: width and height in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.size_said.unwrap_or(SIZE)
    }

    /// Returns the arguments with the defaults of the automatic look of a file: antialiasing, and ambient occlusion
    /// unless lights or the sky light are given. Options on the command line keep their values.
    pub(crate) fn flattered(&self, lights_are_said: bool, scene: &Scene) -> Self {
        let mut settled = self.clone();
        if self.samples.is_none() && self.adaptive.is_none() {
            settled.shadow_rays.get_or_insert(studio::RAYS);
            settled.samples = Some(studio::SAMPLES);
        }
        // Ambient occlusion treats glass as opaque, so objects in a glass case would be black.
        let has_glass = scene.materials().iter().any(|material| matches!(material.finish, Finish::Glass { .. }));
        if !lights_are_said && !has_glass && self.occlusion.is_none() && self.sky_light.is_none() {
            settled.occlusion = Some(OcclusionArgument(settled.shadow_rays.unwrap_or(16), None));
        }
        settled
    }

    /// Returns the render options for a scene. `reach` is the default radius of ambient occlusion, as a share of the
    /// scene's diagonal.
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
