//! Defines the compared ways of rendering. They differ in how first hits and shadows are found, and in the structure
//! through which rays are traced.

use std::fmt;

use stereotrace::{BvhBuild, Method, Options, ShadowBuffer, ShadowRule, Visibility};

/// A way of rendering one eye's picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Way {
    /// Whether rays test a list of all objects instead of a tree.
    list: bool,
    /// Whether first hits come from the T-buffer, object by object, instead of rays.
    t_buffer: bool,
    /// The shadow-buffer, or `None` for shadow rays.
    pub(crate) table: Option<Table>,
}

/// A shadow-buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Table {
    /// Number of rows; there are twice as many columns.
    pub(crate) rows: u32,
    pub(crate) rule: Rule,
    /// Whether the buffer is filled once and kept between frames, since it does not depend on the eye. Otherwise it is
    /// filled in each frame.
    pub(crate) kept: bool,
}

/// Rule that decides from a shadow-buffer whether a point is lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// The paper's rule: a point is lit if its own object is the nearest.
    Object,
    /// A point is lit if nothing is nearer by more than a bias.
    Depth,
    /// The surrounding cells decide if they agree; otherwise a ray is traced.
    Hybrid,
}

impl Way {
    /// The classical ray tracer: every ray is tested against every object.
    pub(crate) const CLASSICAL: Self = Self { list: true, t_buffer: false, table: None };
    /// The paper's T-buffer without its shadow-buffer: shadow rays are tested against the list.
    pub(crate) const T_BUFFER: Self = Self { t_buffer: true, ..Self::CLASSICAL };
    /// All rays are traced through a tree.
    pub(crate) const BVH: Self = Self { list: false, ..Self::CLASSICAL };
    /// The T-buffer, with shadow rays traced through a tree.
    pub(crate) const BVH_T_BUFFER: Self = Self { t_buffer: true, ..Self::BVH };

    /// Returns the paper's two buffers with its own rule. The few remaining rays, and those that fill the
    /// shadow-buffer, are traced through a tree.
    pub(crate) fn both(rows: u32) -> Self {
        Self { t_buffer: true, ..Self::bvh_shadow_buffer(rows) }
    }

    /// Returns rays through a tree for first hits, with a shadow-buffer in place of shadow rays.
    pub(crate) fn bvh_shadow_buffer(rows: u32) -> Self {
        Self { table: Some(Table { rows, rule: Rule::Object, kept: false }), ..Self::BVH }
    }

    /// Sets the rule of the shadow-buffer, if there is one.
    pub(crate) fn rule(self, rule: Rule) -> Self {
        Self { table: self.table.map(|table| Table { rule, ..table }), ..self }
    }

    /// Keeps the shadow-buffer between frames, if there is one.
    pub(crate) fn kept(self) -> Self {
        Self { table: self.table.map(|table| Table { kept: true, ..table }), ..self }
    }

    /// Returns how the scene's tree is built.
    pub(crate) fn build(self) -> BvhBuild {
        if self.list { BvhBuild::Flat } else { BvhBuild::Balanced }
    }

    /// Returns the rendering options.
    pub(crate) fn options(self) -> Options {
        let visibility = if self.t_buffer { Visibility::TBuffer } else { Visibility::Rays };
        let table = self.table.map(|table| {
            ShadowBuffer::new(table.rows).rule(match table.rule {
                Rule::Object => ShadowRule::Object,
                Rule::Depth => ShadowRule::DEPTH,
                Rule::Hybrid => ShadowRule::HYBRID,
            })
        });
        Options::new(Method::Naive).visibility(visibility).shadow_buffer(table)
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Object => "object",
            Self::Depth => "depth",
            Self::Hybrid => "hybrid",
        })
    }
}

impl fmt::Display for Way {
    /// Formats a way as `T-buffer, shadow-buffer 400x800`. The rule follows if it is not the paper's.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let first = match (self.t_buffer, self.list) {
            (false, true) => "classical",
            (false, false) => "BVH",
            (true, _) => "T-buffer",
        };
        let shadows = match self.table {
            Some(Table { rows, rule, kept }) => {
                let rule = if rule == Rule::Object { String::new() } else { format!(" ({rule})") };
                format!(", shadow-buffer {rows}x{}{rule}{}", 2 * rows, if kept { ", kept" } else { "" })
            }
            None if self.t_buffer && !self.list => ", shadow rays by BVH".into(),
            None => String::new(),
        };
        f.pad(&format!("{first}{shadows}"))
    }
}
