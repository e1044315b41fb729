//! Writes both eyes to an `OpenEXR` file, each as a part with a view name.

use std::{io::Cursor, path::Path};

use exr::{
    image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer},
    math::Vec2,
    meta::{
        attribute::{AttributeValue, Chromaticities, Text},
        header::{ImageAttributes, LayerAttributes},
    },
};
use half::f16;

use super::{Batch, calibration::world_to_camera, file::check_count};
use crate::{Channel, Channels, Error, GroundTruth, MISS, Maker, Pose, StereoPair, Values, View};

/// Sample type of colours in an `OpenEXR` file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ExrColor {
    /// 16-bit floats with 11 bits of precision. Values are clamped to 65,504.
    #[default]
    Half,
    /// 32-bit floats.
    Float,
}

/// Primaries of Rec. 709 and D65, which sRGB uses.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

impl Batch {
    /// Adds both views of a pair as an `OpenEXR` file of two parts, `left` and `right`, each with its attribute `view`.
    /// It is lossless, except for colours with [`ExrColor::Half`].
    ///
    /// Channels:
    /// - `R`, `G`, `B`: linear light with Rec. 709's primaries ([`View::linear`]);
    /// - `albedo.R`, `albedo.G`, `albedo.B`, if the pair has them ([`View::albedo`]), for denoisers of others;
    /// - `Z`: depth along the view direction in world units, infinite for sky;
    /// - `id.primitive`, `id.object`: 32-bit whole numbers, 0 for sky, else the id + 1;
    /// - with a ground truth of the pair, also `id.material`, `disparity` in pixels and `distance` along the ray;
    /// - with a ground truth, the shading normal `N.X`, `N.Y`, `N.Z` and the geometric normal `Ng.X`, `Ng.Y`, `Ng.Z` in
    ///   the world frame.
    ///
    /// Attributes: `worldToCamera`, for row vectors, in `OpenEXR`'s frame (left-handed: x right, y up, z along the
    /// view); `interaxial` and `screenDistance` in world units.
    ///
    /// # Errors
    /// [`Error::Options`] for a pair without linear light ([`Options::linear`](crate::Options::linear)), depths or ids;
    /// [`Error::Sizes`] for a ground truth of another size; [`Error::Io`] as [`Batch::add`].
    pub fn add_exr(
        &mut self,
        path: impl AsRef<Path>,
        pair: &StereoPair,
        truth: Option<&GroundTruth>,
        color: ExrColor,
    ) -> Result<(), Error> {
        let path = path.as_ref();
        let eyes = [
            ("left", &pair.left, -1.0, pair.left_channels(truth)),
            ("right", &pair.right, 1.0, pair.right_channels(truth)),
        ];
        let layers = eyes.into_iter().map(|(name, view, side, channels)| {
            let channels = file_channels(path, view, channels, color)?;
            let size = Vec2(view.width as usize, view.height as usize);
            let encoding = Encoding::SMALL_LOSSLESS;
            Ok(Layer::new(size, attributes(&pair.pose, name, side), encoding, AnyChannels::sort(channels.into())))
        });
        let layers = layers.collect::<Result<Vec<_>, Error>>()?;
        let window = layers[0].absolute_bounds();
        let attributes = ImageAttributes { chromaticities: Some(REC_709), ..ImageAttributes::new(window) };
        let mut bytes = Cursor::new(Vec::new());
        let image = Image::from_layers(attributes, layers);
        let written = exr::image::write::WritableImage::write(&image).non_parallel().to_buffered(&mut bytes);
        written.map_err(|error| Error::unwritable(path, error))?;
        self.add(path, bytes.get_ref())
    }
}

fn attributes(pose: &Pose, name: &str, side: f64) -> LayerAttributes {
    // Row vectors need the transposed matrix. `OpenEXR`'s y axis points up, but the y axis of intrinsics points down.
    let rows = world_to_camera(pose, side);
    let turn = [1.0, -1.0, 1.0, 1.0];
    let matrix = std::array::from_fn(|index| (turn[index % 4] * rows[index % 4][index / 4]) as f32);
    let number = |value: f32| AttributeValue::F32(value);
    LayerAttributes {
        view_name: Some(Text::from(name)),
        world_to_camera: Some(matrix),
        other: [
            (Text::from("interaxial"), number(pose.interaxial)),
            (Text::from("screenDistance"), number(pose.screen_distance)),
        ]
        .into_iter()
        .collect(),
        ..LayerAttributes::named(name)
    }
}

/// Returns the channels of a view that the file holds.
fn file_channels(path: &Path, view: &View, channels: Channels<'_>, color: ExrColor) -> Result<FileChannels, Error> {
    let count = view.rgba8.len();
    check_count(path, view.width, view.height, count)?;
    if view.linear.len() != count {
        let reason = "an OpenEXR file needs linear light, but this pair has none; use Options::linear(true)";
        return Err(Error::Options { option: "linear", reason: reason.into() });
    }
    if view.depth.len() != count || view.primitive.len() != count {
        let reason = "an OpenEXR file needs depths and ids; use GBuffer::Ids";
        return Err(Error::Options { option: "g_buffer", reason: reason.into() });
    }
    let mut all = FileChannels::new();
    for &channel in Channel::ALL {
        let is_of_view = channel.maker() == Maker::View;
        if channel.exr_names().is_empty() || !(is_of_view || channels.has_truth()) {
            continue;
        }
        if channel == Channel::Disparity && channels.leaves_rows() {
            continue;
        }
        if channel == Channel::Albedo && view.albedo.is_empty() {
            continue;
        }
        let components = samples(&channels.get(channel)?, color);
        all.extend(channel.exr_names().iter().zip(components).map(|(name, samples)| AnyChannel::new(*name, samples)));
    }
    Ok(all)
}

type FileChannels = Vec<AnyChannel<FlatSamples>>;

/// Returns the samples of each component. An id is stored as 0 for [`MISS`], else as the id + 1.
fn samples(values: &Values<'_>, color: ExrColor) -> Vec<FlatSamples> {
    const { assert!(MISS == u32::MAX) };
    match values {
        Values::Linear(colors) => {
            let component = |index: usize| colors.iter().map(move |color| color[index]);
            let half = |value: f32| f16::from_f32(value.min(f16::MAX.to_f32()));
            let samples = |index| match color {
                ExrColor::Half => FlatSamples::F16(component(index).map(half).collect()),
                ExrColor::Float => FlatSamples::F32(component(index).collect()),
            };
            [0, 1, 2].map(samples).into()
        }
        Values::Floats(values) => vec![FlatSamples::F32(values.to_vec())],
        Values::Vectors(vectors) => {
            let component = |index: usize| FlatSamples::F32(vectors.iter().map(|vector| vector[index]).collect());
            [0, 1, 2].map(component).into()
        }
        Values::Ids(ids) => vec![FlatSamples::U32(ids.iter().map(|id| id.wrapping_add(1)).collect())],
        Values::Counts(counts) => vec![FlatSamples::U32(counts.to_vec())],
        Values::Codes(codes) => vec![FlatSamples::U32(codes.iter().map(|&code| code.into()).collect())],
        Values::Color(_) => unreachable!("files hold linear colours"),
    }
}

#[cfg(test)]
mod tests {
    use exr::prelude::*;

    use super::super::tests::{pair, view};
    use super::*;
    use crate::{
        folder::Folder,
        glam::{DMat4, DVec3, DVec4},
    };

    #[test]
    fn both_parts_read_back_with_their_views_and_matrices() {
        let folder = Folder::new("exr");
        let path = folder.file("a.exr");
        let mut both = pair(view(3, &[[10, 20, 30]; 6]), view(3, &[[200, 100, 50]; 6]));
        both.left.primitive[4] = 70_000;
        both.left.depth[4] = 2.5;
        both.left.linear[0][0] = 1e9;
        for color in [ExrColor::Half, ExrColor::Float] {
            let mut batch = Batch::new();
            batch.add_exr(&path, &both, None, color).unwrap();
            batch.commit().unwrap();
            let image = read_all_flat_layers_from_file(&path).unwrap();
            assert_eq!(image.attributes.chromaticities, Some(REC_709));
            for (layer, (name, side)) in image.layer_data.iter().zip([("left", -1.0), ("right", 1.0)]) {
                assert_eq!(layer.attributes.layer_name, Some(Text::from(name)));
                assert_eq!(layer.attributes.view_name, Some(Text::from(name)));
                let names: Vec<String> = layer.channel_data.list.iter().map(|one| one.name.to_string()).collect();
                assert_eq!(names, ["B", "G", "R", "Z", "id.object", "id.primitive"]);
                // A point one unit in front of the eye and a quarter up is at (0, 0.25, 1), as a row vector.
                let pose = &both.pose;
                let eye = pose.eye + pose.right.as_dvec3() * (0.5 * side * f64::from(pose.interaxial));
                let point = (eye + pose.forward.as_dvec3() + 0.25 * pose.up.as_dvec3()).extend(1.0);
                let rows = layer.attributes.world_to_camera.unwrap().map(f64::from);
                // glam's columns hold the rows that were read, so this product is the row vector times the file's
                // matrix.
                let seen: DVec4 = DMat4::from_cols_array(&rows) * point;
                assert!(seen.truncate().distance(DVec3::new(0.0, 0.25, 1.0)) < 1e-6, "{seen}");
            }
            let samples = |layer: usize, channel: &str| {
                let list = &image.layer_data[layer].channel_data.list;
                let found = list.iter().find(|one| one.name == *channel).unwrap();
                found.sample_data.values_as_f32().collect::<Vec<_>>()
            };
            assert_eq!(samples(0, "id.primitive"), [0.0, 0.0, 0.0, 0.0, 70_001.0, 0.0]);
            assert_eq!(samples(0, "Z")[4], 2.5);
            assert!(samples(0, "Z")[0].is_infinite());
            let (light, exact) = (samples(1, "R")[2], both.right.linear[2][0]);
            assert!((light - exact).abs() <= if color == ExrColor::Half { 3e-4 } else { 0.0 }, "{light} {exact}");
            assert_eq!(samples(0, "R")[0], if color == ExrColor::Half { 65_504.0 } else { 1e9 });
        }
    }

    #[test]
    fn what_is_missing_is_named_and_nothing_is_written() {
        let folder = Folder::new("exr_fault");
        let full = pair(view(2, &[[1; 3]; 2]), view(2, &[[1; 3]; 2]));
        let add = |pair: &StereoPair| {
            Batch::new().add_exr(folder.file("a.exr"), pair, None, ExrColor::Half).unwrap_err().to_string()
        };
        let mut dark = full.clone();
        dark.right.linear.clear();
        assert!(add(&dark).contains("invalid options: linear: an OpenEXR file needs linear light"));
        let mut flat = full.clone();
        flat.left.primitive.clear();
        assert!(add(&flat).contains("g_buffer"));
        let mut short = full;
        short.left.rgba8.pop();
        assert!(add(&short).contains("cannot be written from 1 pixel"));
        assert!(folder.names().is_empty());
    }
}
