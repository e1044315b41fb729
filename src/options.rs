//! What to render with.

use crate::{Error, Filter, Method, ShadowBuffer, Visibility, output, samples};

/// What to render with.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// How the right view is made.
    pub method: Method,
    /// How the first hits of views that are traced are found.
    pub visibility: Visibility,
    /// Count BVH nodes and primitive tests (slower).
    pub count: bool,
    /// Keep what each pixel cost, as [`View::cost`](crate::View::cost); counts too.
    pub cost_map: bool,
    /// What is kept of each pixel besides its colour.
    pub g_buffer: GBuffer,
    /// Surfaces that a ray may come from, one behind the other, that mirror, refract or let through: 0 to
    /// [`MAX_BOUNCES`]. What would be seen after more is black. 5 where nothing is said.
    pub bounces: u32,
    /// Keep linear colour too, as [`View::linear`](crate::View::linear).
    pub linear: bool,
    /// Samples a pixel: 1, 4, 9, 16, 25, 36, 49 or 64.
    pub samples: u32,
    /// How they are weighed.
    pub filter: Filter,
    /// More samples only where a pixel's differ, in place of as many in all.
    pub adaptive: Option<Adaptive>,
    /// Whether each row of them stands aside of the grid by an offset of its own.
    pub jitter: bool,
    /// Rays to each light that is not a point, 1 to [`MAX_SOFT_RAYS`]; 16 where nothing is said.
    pub shadow_rays: u32,
    /// Whether ambient light is kept off by what stands near; `None` where nothing is said: it reaches all.
    pub occlusion: Option<AmbientOcclusion>,
    /// By how many rays surfaces are lit by the sky, in place of ambient light; `None` where nothing is said: by none.
    pub sky_rays: Option<u32>,
    /// What of these rays' answers a view takes over from its source.
    pub penumbra: Penumbra,
    /// Of the random numbers that shift these rays, and of jitter. The same seed makes the same picture to the bit.
    pub seed: u32,
    /// By how many stops pictures are brighter than the light that scenes give, -64 to 64; 0 where nothing is said.
    pub exposure: f32,
    /// What becomes of what is too bright for a picture.
    pub tone: Tone,
    /// Whether each view has random numbers of its own: for quilts, whose views overlap on the display, so that equal
    /// noise would show.
    pub noise_by_view: bool,
    /// Whether points ask shadow-buffers which point lights they see; `None` where nothing is said: they trace shadow
    /// rays.
    pub shadow_buffer: Option<ShadowBuffer>,
}

/// What becomes of what is too bright for a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Tone {
    /// It is cut off: each channel at 1.
    #[default]
    Clamp,
    /// All is bent towards white along a film's curve, dark parts a little darker (Narkowicz 2015).
    Filmic,
}

impl Tone {
    /// A channel of exposed linear light as it is shown, 0 to 1: what kernels do.
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

    /// A linear colour as it is shown, its light multiplied by `exposure`.
    pub(crate) fn rgba8(self, linear: [f32; 3], exposure: f32) -> [u8; 4] {
        let [red, green, blue] = linear.map(|value| output::encode(self.shown(value * exposure)));
        [red, green, blue, 255]
    }
}

/// Ambient occlusion: the share of ambient light that reaches a point, by rays spread by the cosine over what it faces.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct AmbientOcclusion {
    /// How many, 1 to [`MAX_SOFT_RAYS`].
    pub rays: u32,
    /// How far off something keeps light off, world units, above 0; infinite for any distance.
    pub radius: f32,
}

impl AmbientOcclusion {
    /// So many rays, 1 to [`MAX_SOFT_RAYS`], of so many world units, above 0.
    pub fn new(rays: u32, radius: f32) -> Self {
        Self { rays, radius }
    }
}

/// Adaptive supersampling: see [`Options::adaptive`].
///
/// A cell that is divided in one view is divided in the others too, so that both eyes see an edge equally sharp. The
/// left view so depends on the right one. Where methods infer the right view's shadows differently, their left views
/// may differ in such cells; by [`Method::BRACKET_RAYS`](crate::Method::BRACKET_RAYS) both are those of `naive`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Adaptive {
    /// 2 to 5: corners of pixels, and how often one is divided. A pixel that is divided as often as can be has 3, 5, 9
    /// or 17 samples a side.
    pub levels: u32,
    /// By how much the corners of a cell may differ in each channel of the 8-bit picture and not be divided, 0 to 255.
    pub tolerance: f32,
}

impl Adaptive {
    /// So many levels, 2 to 5, and the tolerance in values of a channel of the 8-bit picture, 0 to 255.
    pub fn new(levels: u32, tolerance: f32) -> Self {
        Self { levels, tolerance }
    }
}

/// What a view made by `bracket` takes over from its source of lights that are not points and of occlusion, of which a
/// sample knows the share of rays that arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Penumbra {
    /// What both samples beside a point see fully, or not at all. In a penumbra the view traces its own rays.
    Exact,
    /// Shares too, their mean where they differ by no more than chance explains, and by no more than twice that from
    /// the next samples': in narrower penumbrae the view traces its own rays. Of the sky or occlusion and the first
    /// lights that are not points, six together. With [`ShadowReuse::Two`](crate::ShadowReuse) only; else as
    /// `Exact`.
    Shared {
        /// Standard deviations of the difference of two shares that still are chance, above 0.
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

/// The most rays that a pixel asks a light that is not a point, its surroundings, or the sky; more samples a pixel ask
/// more.
pub const MAX_SOFT_RAYS: u32 = 32;

/// The most that [`Options::bounces`] may be.
pub const MAX_BOUNCES: u32 = 8;

/// What is kept of each pixel besides its colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum GBuffer {
    /// Depth and the ids of primitive and object.
    #[default]
    Ids,
    /// Depth alone: [`View::primitive`](crate::View::primitive) and [`View::object`](crate::View::object) stay empty.
    Depth,
    /// Nothing: [`View::depth`](crate::View::depth) stays empty too.
    None,
}

impl Options {
    /// The given method, nothing counted.
    pub fn new(method: Method) -> Self {
        Self {
            method,
            visibility: Visibility::Rays,
            count: false,
            cost_map: false,
            g_buffer: GBuffer::Ids,
            bounces: 5,
            linear: false,
            samples: 1,
            filter: Filter::Box,
            adaptive: None,
            jitter: true,
            shadow_rays: 16,
            occlusion: None,
            sky_rays: None,
            penumbra: Penumbra::default(),
            seed: 0,
            exposure: 0.0,
            tone: Tone::Clamp,
            noise_by_view: false,
            shadow_buffer: None,
        }
    }

    /// How the right view is made.
    pub fn method(mut self, method: Method) -> Self {
        self.method = method;
        self
    }

    /// Whether BVH nodes and primitive tests are counted (slower).
    pub fn count(mut self, count: bool) -> Self {
        self.count = count;
        self
    }

    /// Whether [`View::cost`](crate::View::cost) says what each pixel cost.
    pub fn cost_map(mut self, cost_map: bool) -> Self {
        self.cost_map = cost_map;
        self
    }

    /// Surfaces that a ray may come from, one behind the other, 0 to [`MAX_BOUNCES`].
    pub fn bounces(mut self, bounces: u32) -> Self {
        self.bounces = bounces;
        self
    }

    /// Whether [`View::linear`](crate::View::linear) is kept too.
    pub fn linear(mut self, linear: bool) -> Self {
        self.linear = linear;
        self
    }

    /// How many samples make a pixel's colour: 1, 4, 9, 16, 25, 36, 49 or 64; frames with any other number are errors.
    /// They stand in the cells of a square grid, at the same places in all views ([`Options::jitter`]), and are
    /// weighed by [`Options::filter`] in linear light. The picture takes their number times the rays and the time,
    /// and memory for a band of rows of them, whatever its height.
    ///
    /// [`View::cost`](crate::View::cost), [`Statistics`](crate::Statistics) and [`Work`](crate::Work) tell of all rays.
    /// Depth, ids and where a pixel came from are not filtered, and are those of one ray through the pixel's
    /// centre. Without jitter that is the middle sample of odd grids (9, 25, 49). Jittered and even ones have none
    /// there: a picture of one sample is rendered besides, and kept until the other's rows are done. With
    /// [`GBuffer::None`] that is not done, and [`PixelSource`](crate::PixelSource) and
    /// [`ShadowSource`](crate::ShadowSource) are those of the sample in the middle cell, or in the next one to the
    /// right and below.
    pub fn samples(mut self, samples: u32) -> Self {
        self.samples = samples;
        self
    }

    /// How a pixel's samples are weighed: [`Filter::Box`] unless something else is asked for.
    pub fn filter(mut self, filter: Filter) -> Self {
        self.filter = filter;
        self
    }

    /// More samples only where a pixel's differ: adaptive supersampling (Whitted 1980), in stereo (Adelson & Hodges
    /// 1993, "Reflection and Refraction with Multiple Rays Per Pixel"). A sample stands in each corner of a pixel,
    /// and its neighbours share it. Where the four differ, as they would be shown, by more than the tolerance in
    /// some channel, in a view or where another view shows the same, the pixel is divided into four with five
    /// samples more, and so on. Its colour is the mean of its parts, in linear light.
    ///
    /// It goes with one sample a pixel otherwise, with the filter `Box`, and with [`Method::Naive`], [`Method::Ideal`],
    /// [`Method::Bracket`] and [`Method::Auto`]; what else is asked for is an error. Views that others are made
    /// from trace samples of a divided cell's corners again, a quarter of what they trace: what others take over of
    /// them is not kept from level to level. Depth, ids and where a pixel came from are those of one more ray
    /// through the pixel's centre; with [`GBuffer::None`] that ray is not traced, and the last two are those of the
    /// sample in its upper left corner.
    pub fn adaptive(mut self, adaptive: impl Into<Option<Adaptive>>) -> Self {
        self.adaptive = adaptive.into();
        self
    }

    /// Whether samples stand aside of the middles of their cells, as they do unless something else is asked for. Each
    /// row of samples does by an offset of its own, the same in all views: of a pixel's n rows one by `(k + 1/2) /
    /// n - 1/2` of a cell's width for each k from 0 to n - 1, in an order that [`Options::seed`] and the row say.
    /// So an edge that is nearly upright cuts a pixel in n² steps in place of n; level ones keep n. One sample
    /// stands in its pixel's centre.
    pub fn jitter(mut self, jitter: bool) -> Self {
        self.jitter = jitter;
        self
    }

    /// Rays to each light that is not a point, 1 to [`MAX_SOFT_RAYS`]. What mirrors show is lit by a quarter of them.
    pub fn shadow_rays(mut self, rays: u32) -> Self {
        self.shadow_rays = rays;
        self
    }

    /// Whether, by how many rays and from how far off ambient light is kept off.
    pub fn occlusion(mut self, occlusion: impl Into<Option<AmbientOcclusion>>) -> Self {
        self.occlusion = occlusion.into();
        self
    }

    /// Whether [`Scene::sky`](crate::Scene::sky) lights surfaces, by so many rays, 1 to [`MAX_SOFT_RAYS`]; what they
    /// meet keeps its light off. A diffuse surface then shows `albedo / π ∫ L(ω) V(ω) cos θ dω` over all it faces:
    /// its albedo under a sky of 1 that nothing hides. What mirrors show is lit by a quarter of the rays. Rays
    /// leave by the cosine; of a [`SkyMap`](crate::SkyMap) every other one by its brightness, so that a sun of few
    /// pixels makes no noise.
    ///
    /// It takes the place of ambient light: [`Scene::ambient`](crate::Scene::ambient) is not added in such a frame,
    /// whoever gave it, and there is nothing for [`Options::occlusion`] to keep off, so frames that ask for both
    /// are errors. Highlights are the lights' alone, as without it; mirrors and glass show the sky itself. A sky
    /// map shows its sun already: a light in its place would be a second one.
    pub fn sky_rays(mut self, rays: impl Into<Option<u32>>) -> Self {
        self.sky_rays = rays.into();
        self
    }

    /// What is asked of a point's surroundings: how much of ambient light they leave, or of the sky.
    pub(crate) fn surroundings(&self) -> Option<AmbientOcclusion> {
        self.sky_rays.map(|rays| AmbientOcclusion::new(rays, f32::INFINITY)).or(self.occlusion)
    }

    /// What of these rays' answers a view takes over from its source.
    pub fn penumbra(mut self, penumbra: Penumbra) -> Self {
        self.penumbra = penumbra;
        self
    }

    /// The seed of the random numbers that shift these rays, and of the order of jittered samples.
    pub fn seed(mut self, seed: u32) -> Self {
        self.seed = seed;
        self
    }

    /// By how many stops pictures are brighter than the light that scenes give, -64 to 64.
    /// [`View::linear`](crate::View::linear) stays.
    pub fn exposure(mut self, stops: f32) -> Self {
        self.exposure = stops;
        self
    }

    /// What becomes of what is too bright for a picture.
    pub fn tone(mut self, tone: Tone) -> Self {
        self.tone = tone;
        self
    }

    /// Whether each view has random numbers of its own.
    pub fn noise_by_view(mut self, noise_by_view: bool) -> Self {
        self.noise_by_view = noise_by_view;
        self
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
    /// [`Error::Options`] for a value out of its range, [`Error::Samples`] for a number of samples that there isn't.
    pub fn check(&self) -> Result<(), Error> {
        samples::side_of(self.samples)?;
        let within = |option, value: u32, range: std::ops::RangeInclusive<u32>| match range.contains(&value) {
            true => Ok(()),
            false => {
                let reason = format!("{value}; there can be {} to {}", range.start(), range.end());
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
        if let Some(AmbientOcclusion { rays, radius }) = self.occlusion {
            within("occlusion", rays, 1..=MAX_SOFT_RAYS)?;
            above_zero("the radius of occlusion", radius)?;
        }
        self.check_adaptive()?;
        self.shadow_buffer.map_or(Ok(()), |buffer| buffer.check())?;
        if let Some(rays) = self.sky_rays {
            within("sky_rays", rays, 1..=MAX_SOFT_RAYS)?;
            if self.occlusion.is_some() {
                let reason = "the sky (sky_rays) takes the place of ambient light, which it would keep off; ask for one of the two";
                return Err(Error::Options { option: "occlusion", reason: reason.into() });
            }
        }
        match self.penumbra {
            Penumbra::Exact => Ok(()),
            Penumbra::Shared { deviations } => above_zero("the deviations of shared penumbrae", deviations),
        }
    }

    /// # Errors
    /// [`Error::Options`] for levels or a tolerance out of their range, and for what adaptive samples don't go with.
    fn check_adaptive(&self) -> Result<(), Error> {
        let Some(Adaptive { levels, tolerance }) = self.adaptive else { return Ok(()) };
        let fault = |reason| Err(Error::Options { option: "adaptive", reason });
        if !(2..=5).contains(&levels) {
            return fault(format!("{levels} levels; there can be 2 to 5"));
        }
        if !(0.0..=255.0).contains(&tolerance) {
            return fault(format!("a tolerance of {tolerance}; it must be 0 to 255"));
        }
        if self.samples != 1 {
            return fault(format!("{} samples a pixel besides; take 1", self.samples));
        }
        if self.filter != Filter::Box {
            return fault(format!("the filter {}; take {}", self.filter, Filter::Box));
        }
        match self.method {
            Method::Naive | Method::Ideal | Method::Bracket(_) | Method::Auto => Ok(()),
            method => fault(format!("the method {method}; take naive, ideal, a bracket or auto")),
        }
    }

    /// What is kept of each pixel besides its colour.
    pub fn g_buffer(mut self, g_buffer: GBuffer) -> Self {
        self.g_buffer = g_buffer;
        self
    }
}

impl Default for Options {
    /// [`Method::Auto`], nothing counted.
    fn default() -> Self {
        Self::new(Method::Auto)
    }
}
