//! Per-pixel outputs by name. Files, the command, the Python package and the page take them from this table.

use crate::{GBuffer, Options, error::by_name};

/// A per-pixel output of a view. [`Channels::get`](crate::Channels::get) returns its values.
///
/// Lists are row-major, `[height][width]`, top row first. Depths, ids and ground truth describe the first surface along
/// the ray through a pixel's centre, even if it is a mirror or glass. The world is right-handed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Channel {
    /// Picture in sRGB, 8 bits, with alpha 255.
    Color,
    /// Linear RGB radiance before exposure and tone mapping, without an upper limit, and alpha 1.
    Linear,
    /// Share of light that surfaces reflect, linear RGB, averaged over a pixel's samples: diffuse reflection and
    /// highlights; 1 for glass, 0 for sky. For denoisers of others. Only with light by paths.
    Albedo,
    /// Depth along the view direction in world units; infinite for sky.
    Depth,
    /// Distance from the eye along the pixel's ray in world units; infinite for sky.
    Distance,
    /// Disparity `x_left - x_right` in pixels. Sky has the disparity of infinite depth.
    Disparity,
    /// Visibility from the other eye, as a number of [`Occlusion`](crate::Occlusion).
    Occlusion,
    /// Shading normal, interpolated if a mesh has normals: unit length, world frame, on the geometric normal's side;
    /// zero for sky.
    Normal,
    /// Normal of the surface itself, towards the eye: unit length, world frame; zero for sky.
    GeometricNormal,
    /// Id of the primitive; [`MISS`](crate::MISS) for sky.
    Primitive,
    /// Id of the object; [`MISS`](crate::MISS) for sky.
    Object,
    /// Id of the material; [`MISS`](crate::MISS) for sky.
    Material,
    /// Source of the pixel, as a number of [`PixelSource`](crate::PixelSource).
    Source,
    /// Source of the visibility of lights, as a number of [`ShadowSource`](crate::ShadowSource).
    ShadowSource,
    /// Number of BVH nodes visited and primitives tested by all rays of the pixel.
    Cost,
}

/// What makes a channel's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Maker {
    /// Rendering, for every view.
    View,
    /// Rendering, for views that are made from another view.
    OtherView,
    /// The depths of a pair's view.
    Pair,
    /// [`Renderer::ground_truth`](crate::Renderer::ground_truth), for pairs.
    GroundTruth,
}

/// Row of the table.
struct Row {
    name: &'static str,
    maker: Maker,
    /// Names of the channels of an `OpenEXR` file, one for each component.
    exr: &'static [&'static str],
}

impl Channel {
    /// All channels.
    pub const ALL: &'static [Self] = &[
        Self::Color,
        Self::Linear,
        Self::Albedo,
        Self::Depth,
        Self::Distance,
        Self::Disparity,
        Self::Occlusion,
        Self::Normal,
        Self::GeometricNormal,
        Self::Primitive,
        Self::Object,
        Self::Material,
        Self::Source,
        Self::ShadowSource,
        Self::Cost,
    ];

    fn row(self) -> Row {
        let row = |name, maker, exr| Row { name, maker, exr };
        match self {
            Self::Color => row("color", Maker::View, &[]),
            Self::Linear => row("linear", Maker::View, &["R", "G", "B"]),
            Self::Albedo => row("albedo", Maker::View, &["albedo.R", "albedo.G", "albedo.B"]),
            Self::Depth => row("depth", Maker::View, &["Z"]),
            Self::Distance => row("distance", Maker::GroundTruth, &["distance"]),
            Self::Disparity => row("disparity", Maker::Pair, &["disparity"]),
            Self::Occlusion => row("occlusion", Maker::GroundTruth, &[]),
            Self::Normal => row("normal", Maker::GroundTruth, &["N.X", "N.Y", "N.Z"]),
            Self::GeometricNormal => row("geometric_normal", Maker::GroundTruth, &["Ng.X", "Ng.Y", "Ng.Z"]),
            Self::Primitive => row("primitive", Maker::View, &["id.primitive"]),
            Self::Object => row("object", Maker::View, &["id.object"]),
            Self::Material => row("material", Maker::GroundTruth, &["id.material"]),
            Self::Source => row("source", Maker::OtherView, &[]),
            Self::ShadowSource => row("shadow_source", Maker::OtherView, &[]),
            Self::Cost => row("cost", Maker::View, &[]),
        }
    }

    /// Returns the name that [`FromStr`](std::str::FromStr) parses and [`Display`](std::fmt::Display) writes.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Returns what makes the channel's values.
    pub fn maker(self) -> Maker {
        self.row().maker
    }

    /// Returns the names of its components in an `OpenEXR` file; none if it is not written to such files.
    #[cfg_attr(not(feature = "exr"), allow(dead_code, reason = "OpenEXR files are written by a feature"))]
    pub(crate) fn exr_names(self) -> &'static [&'static str] {
        self.row().exr
    }
}

by_name!(Channel, "output");

impl Options {
    /// Sets what frames keep for each pixel to what these channels need: [`Options::g_buffer`], [`Options::linear`],
    /// [`Options::albedo`] and [`Options::cost_map`].
    #[must_use]
    pub fn channels(self, channels: &[Channel]) -> Self {
        let has = |wanted: &[Channel]| wanted.iter().any(|channel| channels.contains(channel));
        let truth = channels.iter().any(|channel| channel.maker() == Maker::GroundTruth);
        let g_buffer = match () {
            () if truth || has(&[Channel::Primitive, Channel::Object]) => GBuffer::Ids,
            () if has(&[Channel::Depth, Channel::Disparity]) => GBuffer::Depth,
            () => GBuffer::None,
        };
        let [linear, albedo, cost] = [Channel::Linear, Channel::Albedo, Channel::Cost].map(|channel| has(&[channel]));
        self.g_buffer(g_buffer).linear(linear).albedo(albedo).cost_map(cost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back_and_options_keep_what_channels_need() {
        for &channel in Channel::ALL {
            assert_eq!(channel.name().parse::<Channel>().unwrap(), channel);
        }
        assert!("colour".parse::<Channel>().unwrap_err().to_string().contains("geometric_normal"));
        let kept = |channels: &[Channel]| {
            let options = Options::default().channels(channels);
            (options.g_buffer, options.linear, options.cost_map)
        };
        assert_eq!(kept(&[Channel::Color]), (GBuffer::None, false, false));
        assert_eq!(kept(&[Channel::Disparity, Channel::Linear]), (GBuffer::Depth, true, false));
        assert_eq!(kept(&[Channel::Normal, Channel::Cost]), (GBuffer::Ids, false, true));
        assert!(Options::default().channels(&[Channel::Albedo]).albedo);
    }
}
