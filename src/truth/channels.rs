//! Values of per-pixel outputs, by name.

use std::borrow::Cow;

use crate::{Channel, Error, EyeTruth, GroundTruth, PixelSource, RigView, ShadowSource, StereoPair, View};

/// Channels of one view: of an eye of a pair, or of a view of a rig.
///
/// ```
/// use stereotrace::{Builtin, Channel, Values, render_stereo};
///
/// let pair = render_stereo(&Builtin::Hall.scene(), &Builtin::Hall.camera(16, 12))?;
/// let Values::Floats(disparity) = pair.right_channels(None).get(Channel::Disparity)? else { panic!() };
/// assert_eq!(disparity.len(), 16 * 12);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Channels<'a> {
    view: &'a View,
    /// The pair, and whether the view is its right one.
    pair: Option<(&'a StereoPair, bool)>,
    truth: Option<&'a EyeTruth>,
    sources: Option<(&'a [PixelSource], &'a [ShadowSource])>,
}

/// Values of a channel, one per pixel.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Values<'a> {
    /// sRGB and alpha.
    Color(&'a [[u8; 4]]),
    /// Linear RGB and alpha.
    Linear(&'a [[f32; 4]]),
    /// Lengths in the channel's unit.
    Floats(Cow<'a, [f32]>),
    /// Unit vectors, or zero.
    Vectors(&'a [[f32; 3]]),
    /// Ids, or [`MISS`](crate::MISS).
    Ids(&'a [u32]),
    /// Counts.
    Counts(&'a [u32]),
    /// Numbers of an enumeration's variants.
    Codes(Vec<u8>),
}

impl StereoPair {
    /// Returns the channels of the left view, with those of a ground truth of the pair.
    pub fn left_channels<'a>(&'a self, truth: Option<&'a GroundTruth>) -> Channels<'a> {
        let truth = truth.map(|truth| &truth.left);
        Channels { view: &self.left, pair: Some((self, false)), truth, sources: None }
    }

    /// Returns the channels of the right view, with those of a ground truth of the pair.
    pub fn right_channels<'a>(&'a self, truth: Option<&'a GroundTruth>) -> Channels<'a> {
        let (truth, sources) = (truth.map(|truth| &truth.right), Some((&*self.source, &*self.shadow_source)));
        Channels { view: &self.right, pair: Some((self, true)), truth, sources }
    }
}

impl RigView {
    /// Returns the channels of the view.
    pub fn channels(&self) -> Channels<'_> {
        Channels { view: &self.view, pair: None, truth: None, sources: Some((&self.source, &self.shadow_source)) }
    }
}

impl<'a> Channels<'a> {
    /// Returns whether there is ground truth.
    #[cfg_attr(not(feature = "exr"), allow(dead_code, reason = "OpenEXR files are written by a feature"))]
    pub(crate) fn has_truth(&self) -> bool {
        self.truth.is_some()
    }

    /// Returns whether points leave their rows, so that there are no disparities.
    pub(crate) fn leaves_rows(&self) -> bool {
        self.pair.is_some_and(|(pair, _)| pair.pose.projection.without_rows().is_some())
    }

    /// Returns the values of a channel.
    ///
    /// # Errors
    /// [`Error::Options`] for a channel that the view can't have, or that was not kept
    /// ([`Options::channels`](crate::Options::channels)); [`Error::Sizes`] for a ground truth of another size.
    pub fn get(&self, channel: Channel) -> Result<Values<'a>, Error> {
        let values = self.values(channel)?;
        if values.len() < self.view.rgba8.len() {
            return Err(missing(channel, "it was not kept; name it in Options::channels"));
        }
        Ok(values)
    }

    fn values(&self, channel: Channel) -> Result<Values<'a>, Error> {
        let view = self.view;
        let truth = || match self.truth()? {
            Some(truth) => Ok(truth),
            None if self.pair.is_none() => Err(missing(channel, "only pairs have ground truth")),
            None => Err(missing(channel, "it is ground truth; call Renderer::ground_truth")),
        };
        let sources = || self.sources.ok_or_else(|| missing(channel, "the left view is traced; the right view has it"));
        Ok(match channel {
            Channel::Color => Values::Color(&view.rgba8),
            Channel::Linear => Values::Linear(&view.linear),
            Channel::Albedo if view.albedo.is_empty() => {
                return Err(missing(channel, "only light by paths provides it, if Options::channels names it"));
            }
            Channel::Albedo => Values::Vectors(&view.albedo),
            Channel::Depth => Values::Floats(Cow::Borrowed(&view.depth)),
            Channel::Primitive => Values::Ids(&view.primitive),
            Channel::Object => Values::Ids(&view.object),
            Channel::Cost => Values::Counts(&view.cost),
            Channel::Disparity => self.disparity()?,
            Channel::Source => Values::Codes(sources()?.0.iter().map(|source| *source as u8).collect()),
            Channel::ShadowSource => match sources()?.1 {
                [] => return Err(missing(channel, "only bracket methods provide it")),
                sources => Values::Codes(sources.iter().map(|source| *source as u8).collect()),
            },
            Channel::Distance => Values::Floats(Cow::Borrowed(&truth()?.distance)),
            Channel::Occlusion => Values::Codes(truth()?.occlusion.iter().map(|found| *found as u8).collect()),
            Channel::Normal => Values::Vectors(&truth()?.shading_normal),
            Channel::GeometricNormal => Values::Vectors(&truth()?.geometric_normal),
            Channel::Material => Values::Ids(&truth()?.material),
        })
    }

    /// Returns the ground truth, which must have the view's size.
    fn truth(&self) -> Result<Option<&'a EyeTruth>, Error> {
        let View { width, height, .. } = *self.view;
        match self.truth {
            Some(truth) if [truth.width, truth.height] != [width, height] => Err(Error::Sizes {
                sizes: format!("{}x{} and {width}x{height}", truth.width, truth.height),
                reason: "the ground truth must belong to the pair",
            }),
            truth => Ok(truth),
        }
    }

    fn disparity(&self) -> Result<Values<'a>, Error> {
        let channel = Channel::Disparity;
        let Some((pair, is_right)) = self.pair else {
            return Err(missing(channel, "only pairs have disparities; a camera converts depths"));
        };
        if self.leaves_rows() {
            return Err(missing(channel, "toed-in eyes and lenses have none: points do not stay in their rows"));
        }
        Ok(Values::Floats(match self.truth()? {
            Some(truth) => Cow::Borrowed(&truth.disparity),
            None if is_right => Cow::Owned(pair.right_disparity()),
            None => Cow::Owned(pair.disparity()),
        }))
    }
}

impl Values<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Color(values) => values.len(),
            Self::Linear(values) => values.len(),
            Self::Floats(values) => values.len(),
            Self::Vectors(values) => values.len(),
            Self::Ids(values) | Self::Counts(values) => values.len(),
            Self::Codes(values) => values.len(),
        }
    }
}

fn missing(channel: Channel, reason: &str) -> Error {
    Error::Options { option: channel.name(), reason: reason.into() }
}
