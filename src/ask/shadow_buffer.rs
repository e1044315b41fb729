//! Options of shadow-buffers (`docs/SHADOW-BUFFER.md`).

use crate::{Error, Options};

/// Maximum number of lights with a shadow-buffer; further lights use shadow rays.
pub const MAX_SHADOW_BUFFERS: usize = 16;

/// Shadow-buffers (Raghuvanshi & Dhande, "Raytraced rendering using t-buffer and shadow-buffer"): a table of directions
/// around each point light with the nearest surface in each direction. Shaded points query this table by a
/// [`ShadowRule`] instead of tracing shadow rays. Tables depend on lights and geometry only. They are filled once and
/// kept with the uploaded scene, for any number of views and frames.
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
    /// Rows of a table, from pole to pole of the sphere around the light, at least 1. A table has twice as many columns
    /// as rows. A texel takes 8 bytes, or 16 with [`ShadowRule::Hybrid`].
    pub rows: u32,
    /// How a shaded point uses the texels around its direction.
    pub rule: ShadowRule,
}

/// How a shaded point uses the texels of a [`ShadowBuffer`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ShadowRule {
    /// The paper's rule: a point is lit if the texel in its direction shows the point's own object and the point faces
    /// the light. Objects are spheres, ellipsoids, planes, and triangles connected by vertices. This suits convex
    /// objects only, since an object casts no shadow on itself. Shadow edges are off by up to half a texel.
    Object,
    /// A point is hidden if the texel in its direction is nearer to the light by more than a bias, as with shadow maps.
    Depth {
        /// Bias in texel widths at the point's distance, for a surface that faces the light. It grows by the tangent of
        /// the angle to the light, as the depth range of a texel does. At least 0.
        bias: f32,
    },
    /// A point is lit if nothing lies in front of its texel's plane, and the point lies on or in front of that plane.
    /// It is hidden if its own shadow ray hits a primitive that texels show. Otherwise a shadow ray is traced
    /// (`docs/SHADOW-BUFFER.md`). Without a margin, shadows equal ray-traced shadows, except for occluders less than
    /// 2⁻¹⁸ of the light's distance off a surface.
    Hybrid {
        /// Distance in texel widths, at least 0. An occluder is ignored if it lies in front of a texel's plane by less
        /// than this distance. A point of a curved surface may lie this far behind the plane. Occluders this close to a
        /// surface may cast no shadow on it.
        margin: f32,
    },
}

impl ShadowRule {
    /// [`ShadowRule::Depth`] with a bias of one texel width.
    pub const DEPTH: Self = Self::Depth { bias: 1.0 };
    /// [`ShadowRule::Hybrid`] with a margin of a tenth of a texel width.
    pub const HYBRID: Self = Self::Hybrid { margin: 0.1 };

    /// Returns the name of the rule's section in `shaders/shared/shadow_buffer.wgsl`.
    fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Depth { .. } => "depth",
            Self::Hybrid { .. } => "hybrid",
        }
    }

    /// Returns the rule's bias or margin.
    fn value(self) -> f32 {
        match self {
            Self::Object => 0.0,
            Self::Depth { bias: value } | Self::Hybrid { margin: value } => value,
        }
    }
}

impl ShadowBuffer {
    /// Creates shadow-buffers of `rows` rows and twice as many columns, with [`ShadowRule::HYBRID`].
    pub fn new(rows: u32) -> Self {
        Self { rows, rule: ShadowRule::HYBRID }
    }

    /// Sets how a shaded point uses the texels.
    pub fn rule(mut self, rule: ShadowRule) -> Self {
        self.rule = rule;
        self
    }

    /// Sets [`ShadowRule::Hybrid`] with this margin.
    pub fn margin(self, margin: f32) -> Self {
        self.rule(ShadowRule::Hybrid { margin })
    }

    /// # Errors
    /// [`Error::Options`] for no rows, and for a bias or margin that is negative or not finite.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let fault = |reason| Err(Error::Options { option: "shadow_buffer", reason });
        if self.rows == 0 {
            return fault("0 rows; it must have at least 1".into());
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
    /// Sets shadow-buffers for point lights. They replace all or some shadow rays, as the rule says, in the same way
    /// for both eyes. With [`Method::Bracket`](crate::Method::Bracket), reused visibility bits of the source view take
    /// precedence. The first 16 point lights among the first 32 lights have a buffer. Shadow rays remain for other
    /// lights, for lights farther away than 64 times the scene's longest side, and in frames [in
    /// steps](crate::Statistics::in_steps).
    pub fn shadow_buffer(mut self, shadow_buffer: impl Into<Option<ShadowBuffer>>) -> Self {
        self.shadow_buffer = shadow_buffer.into();
        self
    }
}

/// How kernels read shadow-buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Reading {
    /// Name of the rule.
    pub(crate) rule: &'static str,
    /// Bits of the rule's bias or margin.
    value: u32,
    /// Bit mask of the first 32 lights that have a buffer. Layers are in the order of lights.
    pub(crate) lights: u32,
}

impl Reading {
    pub(crate) fn new(rule: ShadowRule, lights: u32) -> Self {
        Self { rule: rule.name(), value: rule.value().to_bits(), lights }
    }

    /// Returns the rule's bias or margin.
    pub(crate) fn value(&self) -> f32 {
        f32::from_bits(self.value)
    }
}

/// Cost of the shadow-buffers of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ShadowBufferWork {
    /// Texels filled for this frame; 0 if all were kept from an earlier one.
    pub filled: u64,
    /// Primitives projected, once per light and 2 million texels; 0 unless counting is on.
    pub nodes: u64,
    /// Tests of primitives at texels: by the rays through texel centres, and, with the hybrid rule, for occluders in
    /// front of the texels' planes. 0 unless counting is on.
    pub primitive_tests: u64,
    /// Device memory of all lights' tables in bytes; 0 if the frame uses none.
    pub bytes: u64,
}

impl ShadowBufferWork {
    /// Returns the sum with another frame's work on the same tables.
    pub(crate) fn with(self, other: Self) -> Self {
        Self {
            filled: self.filled + other.filled,
            nodes: self.nodes + other.nodes,
            primitive_tests: self.primitive_tests + other.primitive_tests,
            bytes: self.bytes.max(other.bytes),
        }
    }
}
