//! The ways to a picture that are compared: how first hits are found, what rays go through, and how shadows are.

use std::fmt;

use stereotrace::{BvhBuild, Method, Options, ShadowBuffer, ShadowRule, Visibility};

/// A way to a picture of one eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Way {
    /// What rays go through: a list of all objects, or else a tree.
    list: bool,
    /// First hits object by object, by the T-buffer; else by rays.
    t_buffer: bool,
    /// Shadows by a shadow-buffer; else by rays.
    pub(crate) table: Option<Table>,
}

/// A shadow-buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Table {
    /// There are twice as many columns.
    pub(crate) rows: u32,
    pub(crate) rule: Rule,
    /// It is filled once and kept from frame to frame, since it does not depend on the eye; else it is filled in each
    /// frame.
    pub(crate) kept: bool,
}

/// What a point makes of a shadow-buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// The paper's: lit where its own object is the nearest one.
    Object,
    /// Lit where nothing is nearer by more than a bias.
    Depth,
    /// What cells around it agree on, and rays elsewhere.
    Hybrid,
}

impl Way {
    /// The classical ray tracer: every ray is tested against every object.
    pub(crate) const CLASSICAL: Self = Self { list: true, t_buffer: false, table: None };
    /// The paper's T-buffer without its shadow-buffer: shadow rays go through the list.
    pub(crate) const T_BUFFER: Self = Self { t_buffer: true, ..Self::CLASSICAL };
    /// Rays through a tree.
    pub(crate) const BVH: Self = Self { list: false, ..Self::CLASSICAL };
    /// The T-buffer with shadow rays through a tree.
    pub(crate) const BVH_T_BUFFER: Self = Self { t_buffer: true, ..Self::BVH };

    /// The paper's both buffers, by its own rule. What few rays are left, and those that fill the table, go through a
    /// tree.
    pub(crate) fn both(rows: u32) -> Self {
        Self { t_buffer: true, ..Self::bvh_shadow_buffer(rows) }
    }

    /// Rays through a tree for first hits, a shadow-buffer for the others.
    pub(crate) fn bvh_shadow_buffer(rows: u32) -> Self {
        Self { table: Some(Table { rows, rule: Rule::Object, kept: false }), ..Self::BVH }
    }

    /// The same with another rule for the shadow-buffer, if it has one.
    pub(crate) fn rule(self, rule: Rule) -> Self {
        Self { table: self.table.map(|table| Table { rule, ..table }), ..self }
    }

    /// The same with a shadow-buffer that is kept, if it has one.
    pub(crate) fn kept(self) -> Self {
        Self { table: self.table.map(|table| Table { kept: true, ..table }), ..self }
    }

    /// What a scene is uploaded with.
    pub(crate) fn build(self) -> BvhBuild {
        if self.list { BvhBuild::Flat } else { BvhBuild::Balanced }
    }

    /// What it is rendered with.
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
    /// As tables show it: `T-buffer, shadow-buffer 400x800`, with the rule where it is not the paper's.
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
