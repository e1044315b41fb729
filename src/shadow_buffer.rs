//! What a frame asks of shadow-buffers: `docs/SHADOW-BUFFER.md`.

use crate::{Error, Options};

/// Lights that have a shadow-buffer at most; those behind them keep their rays.
pub const MAX_SHADOW_BUFFERS: usize = 16;

/// Shadow-buffers (Raghuvanshi & Dhande, "Raytraced rendering using t-buffer and shadow-buffer"): around each point
/// light a table of directions that says what is nearest along each. Shaded points ask it in place of shadow rays, as
/// its [`ShadowRule`] says. The tables depend on lights and geometry alone, so they are filled once and kept with the
/// uploaded scene, for any number of views and frames.
///
/// ```
/// use stereotrace::{Options, ShadowBuffer, ShadowRule};
///
/// let ours = Options::default().shadow_buffer(ShadowBuffer::new(400));
/// let the_papers = Options::default().shadow_buffer(ShadowBuffer::new(400).rule(ShadowRule::Object));
/// assert_ne!(ours, the_papers);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ShadowBuffer {
    /// Rows of a table, from pole to pole of the sphere around the light, 1 at least; there are twice as many columns.
    /// Eight bytes a texel, sixteen by [`ShadowRule::Hybrid`].
    pub rows: u32,
    /// What a shaded point makes of the texels about its direction.
    pub rule: ShadowRule,
}

/// What a shaded point makes of the texels of a [`ShadowBuffer`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ShadowRule {
    /// The paper's: the point is lit if its direction's texel shows the point's own object, and it faces the light.
    /// Objects are spheres, ellipsoids, planes, and what hangs together by vertices of triangles. For convex
    /// objects alone: what shadows itself is lit. Shadows' edges are off by up to half a texel.
    Object,
    /// The point is hidden if its direction's texel is nearer to the light than the point is by more than a bias, as
    /// shadow maps have it.
    Depth {
        /// In widths of a texel at the point's distance, for a surface that faces the light; it grows by the tangent
        /// of the angle to it, since a texel's depth on a slanting surface does. At least 0.
        bias: f32,
    },
    /// Points are lit where nothing stands before the plane that their direction's texel shows and they are on it, and
    /// hidden where what texels show is met by their own shadow ray; elsewhere a shadow ray is traced: see
    /// `docs/SHADOW-BUFFER.md`. Without a margin the shadows are those of rays, but of what stands less than 2⁻¹⁸ of
    /// the light's distance off a surface.
    Hybrid {
        /// How far before the plane that a texel shows something may stand and be no matter, and how far behind it a
        /// point of a curved surface may be, in widths of a texel there. At least 0. What is that close to a
        /// surface may fail to shade it.
        margin: f32,
    },
}

impl ShadowRule {
    /// [`ShadowRule::Depth`] by the width of a texel.
    pub const DEPTH: Self = Self::Depth { bias: 1.0 };
    /// [`ShadowRule::Hybrid`] by a tenth of the width of a texel.
    pub const HYBRID: Self = Self::Hybrid { margin: 0.1 };

    /// What `shaders/shared/shadow_buffer.wgsl` has sections for.
    fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Depth { .. } => "depth",
            Self::Hybrid { .. } => "hybrid",
        }
    }

    /// Its setting.
    fn value(self) -> f32 {
        match self {
            Self::Object => 0.0,
            Self::Depth { bias: value } | Self::Hybrid { margin: value } => value,
        }
    }
}

impl ShadowBuffer {
    /// So many rows and twice as many columns, by [`ShadowRule::HYBRID`].
    pub fn new(rows: u32) -> Self {
        Self { rows, rule: ShadowRule::HYBRID }
    }

    /// What a shaded point makes of the texels.
    pub fn rule(mut self, rule: ShadowRule) -> Self {
        self.rule = rule;
        self
    }

    /// [`ShadowRule::Hybrid`] with this margin.
    pub fn margin(self, margin: f32) -> Self {
        self.rule(ShadowRule::Hybrid { margin })
    }

    /// # Errors
    /// [`Error::Options`] for no rows, and for a bias or margin that is no distance.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let fault = |reason| Err(Error::Options { option: "shadow_buffer", reason });
        if self.rows == 0 {
            return fault("0 rows; there must be 1 at least".into());
        }
        let value = self.rule.value();
        if !value.is_finite() || value < 0.0 {
            let what = if self.rule.name() == "depth" { "bias" } else { "margin" };
            return fault(format!("a {what} of {value}; it must be a number of texels, at least 0"));
        }
        Ok(())
    }
}

impl Options {
    /// Whether points ask shadow-buffers which point lights they see, in place of shadow rays or before them, as the
    /// buffer's rule says. In both eyes alike; of [`Method::Bracket`](crate::Method::Bracket) what the source's
    /// samples say comes first. The first 16 points among the first 32 lights have one; other lights keep their
    /// rays, as do lights that are not points, lights farther off than 64 times the scene's longest side, and frames
    /// [in steps](crate::Statistics::in_steps).
    pub fn shadow_buffer(mut self, shadow_buffer: impl Into<Option<ShadowBuffer>>) -> Self {
        self.shadow_buffer = shadow_buffer.into();
        self
    }
}

/// How kernels read shadow-buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Reading {
    /// The rule's name.
    pub(crate) rule: &'static str,
    /// Bits of its setting.
    value: u32,
    /// Which of the first 32 lights have one, a bit each. Layers are in their order.
    pub(crate) lights: u32,
}

impl Reading {
    pub(crate) fn new(rule: ShadowRule, lights: u32) -> Self {
        Self { rule: rule.name(), value: rule.value().to_bits(), lights }
    }

    /// The rule's setting.
    pub(crate) fn value(&self) -> f32 {
        f32::from_bits(self.value)
    }
}

/// What shadow-buffers cost a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ShadowBufferWork {
    /// Texels that were filled for this frame; 0 where all were kept from another one.
    pub filled: u64,
    /// Primitives that were projected for it, once a light and 2 million texels; 0 unless counting was asked for.
    pub nodes: u64,
    /// Tests of primitives at texels for it: by the rays through their middles, and by the hybrid rule of what is
    /// before what they show; 0 unless counting was asked for.
    pub primitive_tests: u64,
    /// Device memory of all lights' tables in bytes, 0 where the frame asks none.
    pub bytes: u64,
}

impl ShadowBufferWork {
    /// Together with another frame's of the same tables.
    pub(crate) fn with(self, other: Self) -> Self {
        Self {
            filled: self.filled + other.filled,
            nodes: self.nodes + other.nodes,
            primitive_tests: self.primitive_tests + other.primitive_tests,
            bytes: self.bytes.max(other.bytes),
        }
    }
}
