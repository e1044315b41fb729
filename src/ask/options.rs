//! Render options.

use crate::{Error, Filter, Method, ShadowBuffer, Visibility, ask, srgb};

/// Options of a frame. Set fields by the methods of the same names, or assign them. Callers can't write `Options { ..
/// }`, since later versions may add fields.
///
/// ```
/// use stereotrace::{Method, Options, Tone};
///
/// let mut options = Options::new(Method::BRACKET).samples(9).shadow_rays(32);
/// options.tone = Tone::Filmic;
/// assert_eq!((options.samples, options.bounces), (9, Options::default().bounces));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// How the right view is made.
    pub method: Method,
    /// How the first hits of traced views are found.
    pub visibility: Visibility,
    /// Count BVH nodes and primitive tests (slower).
    pub count: bool,
    /// Keep the cost of each pixel, as [`View::cost`](crate::View::cost). Implies counting.
    pub cost_map: bool,
    /// Keep what surfaces reflect, as [`View::albedo`](crate::View::albedo). Only light by paths
    /// ([`Options::lighting`]) provides it.
    pub albedo: bool,
    /// Data kept for each pixel besides its colour.
    pub g_buffer: GBuffer,
    /// Maximum number of reflections, refractions and transparent surfaces along a ray: 0 to [`MAX_BOUNCES`], 5 by
    /// default. Rays beyond it return black.
    pub bounces: u32,
    /// Keep linear colour too, as [`View::linear`](crate::View::linear).
    pub linear: bool,
    /// Samples per pixel: 1, 4, 9, 16, 25, 36, 49 or 64.
    pub samples: u32,
    /// Reconstruction filter of the samples.
    pub filter: Filter,
    /// Adaptive supersampling, in place of a fixed number of samples; `None` by default.
    pub adaptive: Option<Adaptive>,
    /// Jitter the sample grid: shift each row of samples by its own offset.
    pub jitter: bool,
    /// Rays to each extended light, 1 to [`MAX_SOFT_RAYS`]; 16 by default.
    pub shadow_rays: u32,
    /// Ambient occlusion; with `None`, the default, ambient light reaches every point.
    pub ambient_occlusion: Option<AmbientOcclusion>,
    /// Number of sky light rays, 1 to [`MAX_SOFT_RAYS`]. With `None`, the default, ambient light is used instead.
    pub sky_rays: Option<u32>,
    /// How a view reuses its source view's shares of soft light.
    pub penumbra: Penumbra,
    /// Seed of the soft light rays and of the jitter. Equal seeds make equal pictures, to the bit.
    pub seed: u32,
    /// Exposure in stops, -64 to 64; 0 by default.
    pub exposure: f32,
    /// How values too bright for the picture are mapped.
    pub tone: Tone,
    /// Use different random numbers in each view. Meant for quilts, whose views overlap on the display, so that equal
    /// noise would be visible.
    pub noise_by_view: bool,
    /// Light that reaches surfaces by other surfaces.
    pub lighting: Lighting,
    /// Remove noise from the light of paths. Meant for pictures to look at, not for ground truth of light. It needs
    /// whole pictures, so rows are not passed on as they finish, and frames cannot be encoded.
    pub denoise: bool,
    /// Answer shadow queries to point lights by shadow-buffers; with `None`, the default, shadow rays are traced.
    pub shadow_buffer: Option<ShadowBuffer>,
    /// Memory for samples of earlier frames, in MiB; `None` by default. The next frame of the same scene and size finds
    /// its first hits and the visibility of lights by them ([`Options::history`]).
    pub history: Option<u32>,
    /// Which of several passes the frame is ([`Passes`](crate::Passes)).
    pub(crate) pass: Pass,
}

/// One of several passes over the same views. Each pass has random numbers of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Pass {
    /// Number of passes before.
    pub(crate) number: u32,
    /// Number of paths per sample in the passes before.
    pub(crate) first_path: u32,
}

/// Light that reaches surfaces by other surfaces.
///
/// ```
/// use stereotrace::{Lighting, Options};
///
/// let options = Options::default().lighting(Lighting::paths(64));
/// # let _ = options;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Lighting {
    /// None but what mirrors and glass show. Ambient light stands for the rest.
    #[default]
    Direct,
    /// Paths of light (Kajiya 1986, "The Rendering Equation"). The sky and emitting surfaces light the scene too, and
    /// [`Scene::ambient`](crate::Scene::ambient) is not added. Highlights are those of facets
    /// ([`Material::exponent`](crate::Material::exponent)). Views made by `bracket` reuse the light of diffuse
    /// reflection and of wide highlights of their source, as [`Options::penumbra`] says.
    Paths {
        /// Maximum number of surfaces that scatter a path's light after the first, 0 to [`MAX_PATH_BOUNCES`].
        bounces: u32,
        /// Paths per pixel, 1 to [`MAX_PATHS`]. If a pixel has several samples ([`Options::samples`]), they share the
        /// paths.
        samples: u32,
    },
}

impl Lighting {
    /// Returns paths with this number per pixel, 1 to [`MAX_PATHS`], and the default of 8 bounces.
    pub const fn paths(samples: u32) -> Self {
        Self::Paths { bounces: 8, samples }
    }
}

/// Maximum number of paths per pixel.
pub const MAX_PATHS: u32 = 4096;

/// Maximum number of bounces of a path.
pub const MAX_PATH_BOUNCES: u32 = 32;

/// Tone mapping: how values too bright for the picture are mapped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Tone {
    /// Clamps each channel at 1.
    #[default]
    Clamp,
    /// Maps each channel by a filmic curve (Narkowicz 2015), which also makes dark parts a little darker.
    Filmic,
}

impl Tone {
    /// Returns the displayed value, 0 to 1, of a channel of exposed linear light, as kernels compute it.
    pub(crate) fn shown(self, exposed: f32) -> f32 {
        let shown = match self {
            Self::Clamp => exposed,
            Self::Filmic => {
                let y = exposed.min(64.0);
                (y * (2.51 * y + 0.03)) / (y * (2.43 * y + 0.59) + 0.14)
            }
        };
        shown.clamp(0.0, 1.0)
    }

    /// Returns the sRGB pixel of a linear colour multiplied by `exposure`.
    pub(crate) fn rgba8(self, linear: [f32; 3], exposure: f32) -> [u8; 4] {
        let [red, green, blue] = linear.map(|value| srgb::encode(self.shown(value * exposure)));
        [red, green, blue, 255]
    }
}

/// Ambient occlusion. The ambient light of a point is multiplied by the fraction of cosine-distributed rays from the
/// point that hit nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct AmbientOcclusion {
    /// Rays per point, 1 to [`MAX_SOFT_RAYS`].
    pub rays: u32,
    /// Largest distance of an occluder in world units, above 0; may be infinite.
    pub radius: f32,
}

impl AmbientOcclusion {
    /// Creates ambient occlusion with 1 to [`MAX_SOFT_RAYS`] rays and a radius above 0 in world units.
    pub fn new(rays: u32, radius: f32) -> Self {
        Self { rays, radius }
    }
}

/// Adaptive supersampling: see [`Options::adaptive`].
///
/// A cell divided in one view is divided in the other views too, so that both eyes see an edge equally sharp. The left
/// view therefore depends on the right one. Methods that infer the right view's shadows differently may have different
/// left views in such cells. [`Method::BRACKET_RAYS`](crate::Method::BRACKET_RAYS) makes the same views as `naive`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Adaptive {
    /// Number of levels, 2 to 5, counting the pixel corners as the first. A pixel divided at every level has 3, 5, 9 or
    /// 17 samples per side.
    pub levels: u32,
    /// Largest difference of a cell's corners, in any 8-bit channel, that leaves the cell undivided; 0 to 255.
    pub tolerance: f32,
}

impl Adaptive {
    /// Creates adaptive supersampling with 2 to 5 levels and a tolerance of 0 to 255, in 8-bit channel values.
    pub fn new(levels: u32, tolerance: f32) -> Self {
        Self { levels, tolerance }
    }
}

/// How a view made by `bracket` reuses the soft light of its source view. Each source sample keeps the share of rays
/// that arrived, for extended lights and for ambient occlusion or the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Penumbra {
    /// Reuses a share only where both samples next to a point see all of the light, or both see none. In a penumbra the
    /// view traces its own rays.
    Exact,
    /// Also interpolates shares. The shares of the two samples may differ by no more than chance explains. Each of them
    /// may differ from the next sample's share by no more than twice that amount. In narrower penumbrae the view traces
    /// its own rays. This applies to the first six sources: the sky or occlusion, then extended lights. It requires
    /// [`ShadowReuse::Two`](crate::ShadowReuse); other methods behave as with `Exact`.
    Shared {
        /// Largest difference of two shares, in standard deviations, that counts as chance; above 0.
        deviations: f32,
    },
}

impl Default for Penumbra {
    fn default() -> Self {
        Self::Shared { deviations: 1.5 }
    }
}

impl Penumbra {
    pub(crate) fn tolerance(self) -> f32 {
        match self {
            Self::Exact => 0.0,
            Self::Shared { deviations } => deviations,
        }
    }
}

/// Maximum number of rays from a point to an extended light, to its surroundings, or to the sky. The number of samples
/// per pixel multiplies this number.
pub const MAX_SOFT_RAYS: u32 = 32;

/// Maximum of [`Options::bounces`].
pub const MAX_BOUNCES: u32 = 8;

/// Data kept for each pixel besides its colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum GBuffer {
    /// Depth, primitive id and object id.
    #[default]
    Ids,
    /// Depth only: [`View::primitive`](crate::View::primitive) and [`View::object`](crate::View::object) stay empty.
    Depth,
    /// Nothing: [`View::depth`](crate::View::depth) stays empty too.
    None,
}

impl Options {
    /// Creates options with the given method and defaults elsewhere.
    pub fn new(method: Method) -> Self {
        Self {
            method,
            visibility: Visibility::Rays,
            count: false,
            cost_map: false,
            albedo: false,
            g_buffer: GBuffer::Ids,
            bounces: 5,
            linear: false,
            samples: 1,
            filter: Filter::Box,
            adaptive: None,
            jitter: true,
            shadow_rays: 16,
            ambient_occlusion: None,
            sky_rays: None,
            penumbra: Penumbra::default(),
            seed: 0,
            exposure: 0.0,
            tone: Tone::Clamp,
            noise_by_view: false,
            lighting: Lighting::Direct,
            denoise: false,
            shadow_buffer: None,
            history: None,
            pass: Pass::default(),
        }
    }

    /// Sets how the right view is made.
    pub fn method(mut self, method: Method) -> Self {
        self.method = method;
        self
    }

    /// Sets whether BVH nodes and primitive tests are counted (slower).
    pub fn count(mut self, count: bool) -> Self {
        self.count = count;
        self
    }

    /// Sets whether each pixel's cost is kept as [`View::cost`](crate::View::cost).
    pub fn cost_map(mut self, cost_map: bool) -> Self {
        self.cost_map = cost_map;
        self
    }

    /// Sets whether what surfaces reflect is kept as [`View::albedo`](crate::View::albedo).
    pub fn albedo(mut self, albedo: bool) -> Self {
        self.albedo = albedo;
        self
    }

    /// Sets the maximum number of reflections, refractions and transparent surfaces along a ray, 0 to [`MAX_BOUNCES`].
    pub fn bounces(mut self, bounces: u32) -> Self {
        self.bounces = bounces;
        self
    }

    /// Sets whether [`View::linear`](crate::View::linear) is kept.
    pub fn linear(mut self, linear: bool) -> Self {
        self.linear = linear;
        self
    }

    /// Sets the memory for samples of earlier frames in MiB, at least 1. A film's next frame then searches the tiles of
    /// its traced view only as deep as these samples landed, and recalls their visibility of lights where all samples
    /// around a point agree (docs/BRACKET.md). Shares of soft light are interpolated ([`Penumbra::Shared`]), and the
    /// light of paths is averaged over frames. First hits are the same as without, but for the rounding of adapters
    /// that contract operations. With `bracket-rays` all light is traced anew. Where objects moved
    /// ([`Renderer::update`](crate::Renderer::update)), so is all light that they may hide. Any change drops the light
    /// of paths.
    ///
    /// It takes 32 bytes per sample, and 32 more if the light of paths is shared. A frame has no history if that is
    /// more memory, if it is adaptive, encoded, traced in steps or drawn into a T-buffer, if several views are traced,
    /// and if `bracket`, `bracket-rays` or `auto` does not make its views. Memory is freed by
    /// [`Renderer::forget`](crate::Renderer::forget).
    pub fn history(mut self, mebibytes: impl Into<Option<u32>>) -> Self {
        self.history = mebibytes.into();
        self
    }

    /// Returns whether a frame may depend on earlier frames, by [`Options::history`]. The next frame after
    /// [`Renderer::forget`](crate::Renderer::forget) depends on none.
    pub fn has_history(&self) -> bool {
        let by_bracket = matches!(self.method, Method::Bracket(_) | Method::Auto);
        self.history.is_some() && by_bracket && self.adaptive.is_none()
    }

    /// Sets the number of samples per pixel: 1, 4, 9, 16, 25, 36, 49 or 64. Frames with any other number are errors.
    ///
    /// Samples lie in the cells of a square grid, at the same positions in all views ([`Options::jitter`]). Their
    /// colours are filtered by [`Options::filter`] in linear light. Rays and time grow in proportion to the number of
    /// samples. Memory grows by one band of rows of samples, for any height of the picture.
    ///
    /// [`View::cost`](crate::View::cost), [`Statistics`](crate::Statistics) and [`Work`](crate::Work) count all rays.
    /// Depth, ids and pixel sources are not filtered: they come from one ray through the pixel's centre. Without
    /// jitter, odd grids (9, 25, 49) have their middle sample there. Other grids have no sample there. A second picture
    /// with one sample per pixel is then rendered too. Its rows are kept until the rows of the first picture are done.
    /// [`GBuffer::None`] skips the second picture. Then [`PixelSource`](crate::PixelSource) and
    /// [`ShadowSource`](crate::ShadowSource) come from the middle cell, or from the cell right of and below the middle.
    pub fn samples(mut self, samples: u32) -> Self {
        self.samples = samples;
        self
    }

    /// Sets the reconstruction filter; [`Filter::Box`] by default.
    pub fn filter(mut self, filter: Filter) -> Self {
        self.filter = filter;
        self
    }

    /// Enables adaptive supersampling (Whitted 1980), in stereo (Adelson & Hodges 1993, "Reflection and Refraction with
    /// Multiple Rays Per Pixel").
    ///
    /// There is a sample at each pixel corner, which the neighbouring pixels share. A pixel whose displayed corners
    /// differ by more than the tolerance in some channel is divided into four, with five more samples. It is also
    /// divided if another view divides the cell that shows the same point. Cells are divided again in the same way. A
    /// divided cell's colour is the mean of its four cells, in linear light.
    ///
    /// It requires one sample per pixel, the filter `Box`, and [`Method::Naive`], [`Method::Ideal`],
    /// [`Method::Bracket`] or [`Method::Auto`]. Other settings are errors. Source views trace the corners of a divided
    /// cell again, since samples for reuse are not kept between levels. These repeated rays are a quarter of the rays
    /// of source views. Depth, ids and pixel sources come from one more ray through the pixel's centre. With
    /// [`GBuffer::None`] that ray is not traced. Pixel and shadow sources then come from the sample in the upper left
    /// corner.
    pub fn adaptive(mut self, adaptive: impl Into<Option<Adaptive>>) -> Self {
        self.adaptive = adaptive.into();
        self
    }

    /// Sets whether the sample grid is jittered; on by default. Each row of samples is shifted by its own offset, the
    /// same in all views. The offsets of a pixel's n rows are `(k + 1/2) / n - 1/2` cell widths, for k from 0 to n - 1.
    /// Their order depends on [`Options::seed`] and the row. A nearly vertical edge then has n² levels instead of n. A
    /// horizontal edge keeps n levels. With one sample per pixel, the sample stays in the pixel's centre.
    pub fn jitter(mut self, jitter: bool) -> Self {
        self.jitter = jitter;
        self
    }

    /// Sets the rays to each extended light, 1 to [`MAX_SOFT_RAYS`]. Surfaces seen in mirrors get a quarter of them.
    pub fn shadow_rays(mut self, rays: u32) -> Self {
        self.shadow_rays = rays;
        self
    }

    /// Sets ambient occlusion.
    pub fn ambient_occlusion(mut self, occlusion: impl Into<Option<AmbientOcclusion>>) -> Self {
        self.ambient_occlusion = occlusion.into();
        self
    }

    /// Sets the number of sky light rays, 1 to [`MAX_SOFT_RAYS`]. [`Scene::sky`](crate::Scene::sky) then lights
    /// surfaces, and surfaces that these rays meet block its light. A diffuse surface shows
    /// `albedo / π ∫ L(ω) V(ω) cos θ dω`, which is its albedo under an unoccluded sky of 1. Surfaces seen in mirrors
    /// get a quarter of the rays. Rays are cosine-distributed. For a [`SkyMap`](crate::SkyMap) every other ray samples
    /// brightness instead, so that a small sun makes no noise.
    ///
    /// Sky light replaces ambient light: [`Scene::ambient`](crate::Scene::ambient) is not added, and
    /// [`Options::ambient_occlusion`] has nothing to scale, so frames with both are errors. Highlights come from lights
    /// only, and mirrors and glass show the sky itself. A sky map already contains its sun; a light in the same place
    /// would add a second one.
    pub fn sky_rays(mut self, rays: impl Into<Option<u32>>) -> Self {
        self.sky_rays = rays.into();
        self
    }

    /// Returns the query for a point's surroundings: sky light rays of infinite length, or ambient occlusion.
    pub(crate) fn surroundings(&self) -> Option<AmbientOcclusion> {
        self.sky_rays.map(|rays| AmbientOcclusion::new(rays, f32::INFINITY)).or(self.ambient_occlusion)
    }

    /// Sets how a view reuses its source view's shares of soft light.
    pub fn penumbra(mut self, penumbra: Penumbra) -> Self {
        self.penumbra = penumbra;
        self
    }

    /// Sets the seed of the soft light rays and of the jitter.
    pub fn seed(mut self, seed: u32) -> Self {
        self.seed = seed;
        self
    }

    /// Sets the exposure in stops, -64 to 64. It leaves [`View::linear`](crate::View::linear) unchanged.
    pub fn exposure(mut self, stops: f32) -> Self {
        self.exposure = stops;
        self
    }

    /// Sets the tone mapping.
    pub fn tone(mut self, tone: Tone) -> Self {
        self.tone = tone;
        self
    }

    /// Sets whether each view uses different random numbers.
    pub fn noise_by_view(mut self, noise_by_view: bool) -> Self {
        self.noise_by_view = noise_by_view;
        self
    }

    /// Sets the light that reaches surfaces by other surfaces.
    pub fn lighting(mut self, lighting: Lighting) -> Self {
        self.lighting = lighting;
        self
    }

    /// Sets whether noise is removed from the light of paths.
    pub fn denoise(mut self, denoise: bool) -> Self {
        self.denoise = denoise;
        self
    }

    /// Returns whether frames keep light in parts.
    pub(crate) fn keeps_parts(&self) -> bool {
        self.denoise || (self.albedo && self.follows_paths())
    }

    /// Checks whether a frame's light can be kept in parts, if it is to be. `whole` says whether whole pictures are
    /// made.
    pub(crate) fn check_parts(&self, whole: bool) -> Result<(), Error> {
        if self.albedo && self.follows_paths() && (self.adaptive.is_some() || !whole) {
            let reason =
                "it needs whole pictures without adaptive samples, which rows and encoded frames are not".into();
            return Err(Error::Options { option: "albedo", reason });
        }
        let reason = match self.denoise {
            false => return Ok(()),
            true if !self.follows_paths() => "only light by paths (lighting) is denoised",
            true if self.samples == 1 && matches!(self.lighting, Lighting::Paths { samples: 1, .. }) => {
                "it needs at least two paths per pixel"
            }
            true if self.adaptive.is_some() => "pictures with adaptive samples are not denoised",
            true if !whole => "it needs whole pictures, which rows and encoded frames are not",
            true => return Ok(()),
        };
        Err(Error::Options { option: "denoise", reason: reason.into() })
    }

    /// Returns the seed of the jitter, which differs from pass to pass.
    pub(crate) fn jitter_seed(&self) -> u32 {
        self.seed.wrapping_add(self.pass.number)
    }

    /// Returns the seed of a view's light. Paths go on with their sequence from pass to pass, by one seed.
    pub(crate) fn light_seed(&self, view: usize) -> u32 {
        let of_pass = if self.follows_paths() { 0 } else { self.pass.number << 16 };
        self.seed.wrapping_add(of_pass).wrapping_add(if self.noise_by_view { view as u32 } else { 0 })
    }

    pub(crate) fn follows_paths(&self) -> bool {
        self.lighting != Lighting::Direct
    }

    /// Returns whether directions are sampled by the brightness of a sky map.
    pub(crate) fn samples_sky(&self) -> bool {
        self.sky_rays.is_some() || self.follows_paths()
    }

    /// Checks all values without a device, as every frame does.
    ///
    /// ```
    /// use stereotrace::{Method, Options};
    ///
    /// assert!(Options::new(Method::Auto).samples(9).check().is_ok());
    /// assert!(Options::new(Method::Auto).samples(10).check().is_err());
    /// ```
    ///
    /// # Errors
    /// [`Error::Options`] for a value out of its range, [`Error::Samples`] for an unsupported number of samples.
    pub fn check(&self) -> Result<(), Error> {
        ask::samples::side_of(self.samples)?;
        let within = |option, value: u32, range: std::ops::RangeInclusive<u32>| match range.contains(&value) {
            true => Ok(()),
            false => {
                let reason = format!("{value}; it must be {} to {}", range.start(), range.end());
                Err(Error::Options { option, reason })
            }
        };
        let above_zero = |option, value: f32| match value > 0.0 {
            true => Ok(()),
            false => Err(Error::Options { option, reason: format!("{value}; it must be above 0") }),
        };
        if !(-64.0..=64.0).contains(&self.exposure) {
            let reason = format!("{}; it must be -64 to 64 stops", self.exposure);
            return Err(Error::Options { option: "exposure", reason });
        }
        within("bounces", self.bounces, 0..=MAX_BOUNCES)?;
        within("shadow_rays", self.shadow_rays, 1..=MAX_SOFT_RAYS)?;
        if let Some(AmbientOcclusion { rays, radius }) = self.ambient_occlusion {
            within("ambient_occlusion", rays, 1..=MAX_SOFT_RAYS)?;
            above_zero("ambient_occlusion radius", radius)?;
        }
        if let Lighting::Paths { bounces, samples } = self.lighting {
            within("lighting bounces", bounces, 0..=MAX_PATH_BOUNCES)?;
            within("lighting samples", samples, 1..=MAX_PATHS)?;
            for (option, is_set) in
                [("ambient_occlusion", self.ambient_occlusion.is_some()), ("sky_rays", self.sky_rays.is_some())]
            {
                if is_set {
                    let reason = "paths of light (lighting) bring this light; leave it off".into();
                    return Err(Error::Options { option, reason });
                }
            }
        }
        if let Some(mebibytes) = self.history {
            within("history", mebibytes, 1..=u32::MAX)?;
        }
        self.check_adaptive()?;
        self.shadow_buffer.map_or(Ok(()), |buffer| buffer.check())?;
        if let Some(rays) = self.sky_rays {
            within("sky_rays", rays, 1..=MAX_SOFT_RAYS)?;
            if self.ambient_occlusion.is_some() {
                let reason = "sky light (sky_rays) replaces ambient light, which ambient occlusion would darken; use \
                              one of the two";
                return Err(Error::Options { option: "ambient_occlusion", reason: reason.into() });
            }
        }
        match self.penumbra {
            Penumbra::Exact => Ok(()),
            Penumbra::Shared { deviations } => above_zero("deviations of shared penumbrae", deviations),
        }
    }

    /// # Errors
    /// [`Error::Options`] for levels or a tolerance out of range, and for options that exclude adaptive samples.
    fn check_adaptive(&self) -> Result<(), Error> {
        let Some(Adaptive { levels, tolerance }) = self.adaptive else { return Ok(()) };
        let fault = |reason| Err(Error::Options { option: "adaptive", reason });
        if !(2..=5).contains(&levels) {
            return fault(format!("{levels} levels; it must be 2 to 5"));
        }
        if !(0.0..=255.0).contains(&tolerance) {
            return fault(format!("a tolerance of {tolerance}; it must be 0 to 255"));
        }
        if self.samples != 1 {
            return fault(format!("it does not support {} samples per pixel; use 1", self.samples));
        }
        if self.filter != Filter::Box {
            return fault(format!("it does not support the filter {}; use {}", self.filter, Filter::Box));
        }
        match self.method {
            Method::Naive | Method::Ideal | Method::Bracket(_) | Method::Auto => Ok(()),
            method => {
                fault(format!("it does not support the method {method}; use naive, ideal, a bracket method or auto"))
            }
        }
    }

    /// Sets the data kept for each pixel besides its colour.
    pub fn g_buffer(mut self, g_buffer: GBuffer) -> Self {
        self.g_buffer = g_buffer;
        self
    }
}

impl Default for Options {
    /// [`Method::Auto`] with the defaults of [`Options::new`].
    fn default() -> Self {
        Self::new(Method::Auto)
    }
}
