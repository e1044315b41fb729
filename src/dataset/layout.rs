//! Writes folder layouts that loaders of existing data sets can read.

use std::{
    fs,
    path::{Path, PathBuf},
};

use glam::DVec3;

use crate::{
    Error, EyeTruth, Flow, GroundTruth, Projection, StereoPair, error::by_name, output::Batch, view::camera::Intrinsics,
};

/// Folder layout of the data set of the same name. Pairs are numbered from 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Layout {
    /// Middlebury 2014 (Scharstein et al. 2014): a folder per pair, `000000/`, with `im0.png`, `im1.png`, `disp0.pfm`,
    /// `disp1.pfm`, `calib.txt` and the evaluation's `mask0nocc.png`. The masks `mask1nocc.png`, `mask0sky.png` and
    /// `mask1sky.png` are additions to Middlebury's layout. Sky is unknown: infinite in the disparities, 0 in
    /// `mask0nocc.png`.
    #[default]
    Middlebury,
    /// KITTI 2015 (Menze and Geiger 2015), left disparities: `training/image_2/000000_10.png`, `image_3`, `disp_occ_0`,
    /// `disp_noc_0`, and `calib_cam_to_cam/000000.txt`. Sky is not valid. There are no second frames, flow or
    /// `obj_map`.
    ///
    /// Pairs with motion also have their next pair, `image_2/000000_11.png` and `image_3`, the left view's flow,
    /// `flow_occ` and `flow_noc`, and the disparity of its points at the next time, `disp_occ_1`. Sky is not valid.
    Kitti,
    /// Scene Flow's Monkaa and Driving (Mayer et al. 2016), with one sequence named `stereotrace`:
    /// `frames_finalpass/stereotrace/left/0000.png`, `right`, the same for `disparity`, `object_index` and
    /// `material_index` as PFM, and `camera_data/stereotrace/0000.txt`. Concatenate the camera files to get a
    /// `camera_data.txt`. As in Scene Flow, id 0 means a miss. There is no clean pass.
    ///
    /// Pairs with motion take two numbers each, for the pair and its next one. `optical_flow` and `disparity_change`
    /// hold the motion of the first one's points in `into_future`, and of the next one's points in `into_past`.
    SceneFlow,
    /// Equirectangular pairs, with a folder per pair, `000000/`: `im0.png` and `im1.png`, which name their projection
    /// (XMP, `GPano`), `disp0.pfm` and `disp1.pfm` in columns, `distance0.pfm` and `distance1.pfm`, the masks of
    /// [`Layout::Middlebury`], and with the feature `json` also `camera.json`. A surface at column x of the left view
    /// is at column `x - d` of the right view, modulo the width for 360 degrees. The disparity of sky is infinite.
    Panorama,
}

impl Layout {
    /// All layouts, starting with the default.
    pub const ALL: &'static [Self] = &[Self::Middlebury, Self::Kitti, Self::SceneFlow, Self::Panorama];

    /// Returns the name that [`FromStr`](std::str::FromStr) parses and [`Display`](std::fmt::Display) writes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Middlebury => "middlebury",
            Self::Kitti => "kitti",
            Self::SceneFlow => "sceneflow",
            Self::Panorama => "panorama",
        }
    }

    /// Returns whether the layout requires parallel cameras. Middlebury's `doffs` allows converged cameras, but its
    /// loaders accept no negative disparities.
    pub fn is_parallel(self) -> bool {
        match self {
            Self::Kitti | Self::SceneFlow => true,
            Self::Middlebury | Self::Panorama => false,
        }
    }

    /// Returns whether the layout holds pairs with motion.
    pub fn holds_motion(self) -> bool {
        match self {
            Self::Kitti | Self::SceneFlow => true,
            Self::Middlebury | Self::Panorama => false,
        }
    }

    /// Returns whether the layout requires equirectangular pictures. The others require planar ones.
    pub fn is_equirectangular(self) -> bool {
        self == Self::Panorama
    }

    /// Returns the disparity limit of the layout's files in pixels: files can't hold disparities of this size or
    /// larger.
    pub fn disparity_limit(self) -> f32 {
        if self == Self::Kitti { 256.0 } else { f32::INFINITY }
    }

    /// Adds all files of a pair to a batch, with its next pair and the flow between both if there is motion.
    ///
    /// # Errors
    /// The errors of [`Layout::add`]; [`Error::Options`] for motion in a layout that does not hold it
    /// ([`Layout::holds_motion`]); and [`Error::Io`] as [`Batch::add_kitti_flow`].
    pub fn add_moving(
        self,
        batch: &mut Batch,
        folder: impl AsRef<Path>,
        index: u32,
        (pair, truth): (&StereoPair, &GroundTruth),
        motion: Option<LayoutMotion<'_>>,
    ) -> Result<(), Error> {
        let Some(motion) = motion else { return self.add(batch, folder, index, pair, truth) };
        let folder = folder.as_ref();
        match self {
            Self::Kitti => {
                self.add(batch, folder, index, pair, truth)?;
                kitti_motion(batch, &Root(folder), index, truth, &motion)
            }
            Self::SceneFlow => {
                let [now, then] = [2 * index, 2 * index + 1];
                self.add(batch, folder, now, pair, truth)?;
                self.add(batch, folder, then, motion.pair, motion.truth)?;
                scene_flow_motion(batch, &Root(folder), now, ("into_future", "IntoFuture"), motion.forward)?;
                scene_flow_motion(batch, &Root(folder), then, ("into_past", "IntoPast"), motion.backward)
            }
            Self::Middlebury | Self::Panorama => {
                let reason = format!("{self}: it holds no motion; use kitti or sceneflow");
                Err(Error::Options { option: "layout", reason })
            }
        }
    }

    /// Adds all files of a pair to a batch, and creates their folders.
    ///
    /// # Errors
    /// [`Error::Options`] for cameras that are not parallel in a layout that requires it; for toed-in eyes and
    /// lenses; for pictures with another projection than the layout's ([`Layout::is_equirectangular`]); and in
    /// Middlebury's layout for a negative disparity. [`Error::Io`] as [`Batch::add`], as [`Batch::add_kitti_disparity`]
    /// for a disparity that does not fit, and in Scene Flow's layout for an id over `2^24 - 1`.
    pub fn add(
        self,
        batch: &mut Batch,
        folder: impl AsRef<Path>,
        index: u32,
        pair: &StereoPair,
        truth: &GroundTruth,
    ) -> Result<(), Error> {
        let fault = |reason: String| Err(Error::Options { option: "layout", reason: format!("{self}: {reason}") });
        match pair.pose.projection {
            Projection::OffAxis if self.is_equirectangular() => {
                return fault("its pictures must be equirectangular, but these are planar".into());
            }
            Projection::OffAxis => {}
            Projection::ToeIn => {
                return fault("its pairs must be rectified, but the eyes of this pair are toed in".into());
            }
            Projection::Lenses(_) => {
                return fault("its pairs must be rectified, but lenses distort these: use the rectified camera".into());
            }
            Projection::Equirectangular(_) if self.is_equirectangular() => {}
            Projection::Equirectangular(_) => {
                return fault("its pictures must be planar, but these are equirectangular".into());
            }
        }
        if self.is_parallel() && pair.pose.screen_distance.is_finite() {
            return fault(format!(
                "its cameras must be parallel, but these have their screen at {}; put it at infinity",
                pair.pose.screen_distance
            ));
        }
        if self == Self::Middlebury
            && let Some(place) = negative_disparity(truth)
        {
            return fault(format!(
                "its loaders take the absolute value of a disparity, but {place}, behind the screen at {}; put the \
                 screen at infinity, or behind all visible surfaces",
                pair.pose.screen_distance
            ));
        }
        let root = Root(folder.as_ref());
        match self {
            Self::Middlebury => middlebury(batch, &root, index, pair, truth),
            Self::Kitti => kitti(batch, &root, index, pair, truth),
            Self::SceneFlow => scene_flow(batch, &root, index, pair, truth),
            Self::Panorama => panorama(batch, &root, index, pair, truth),
        }
    }
}

by_name!(Layout, "layout");

/// The next pair of a pair, and the motion between both ([`Layout::add_moving`]).
#[derive(Clone, Copy, Debug)]
pub struct LayoutMotion<'a> {
    /// The next pair.
    pub pair: &'a StereoPair,
    /// Its ground truth.
    pub truth: &'a GroundTruth,
    /// Motion of the first pair's points to the next pair.
    pub forward: &'a Flow,
    /// Motion of the next pair's points to the first pair.
    pub backward: &'a Flow,
}

/// Folder of a data set.
struct Root<'a>(&'a Path);

impl Root<'_> {
    /// Returns a file's path and creates its folder.
    fn file(&self, name: &str) -> Result<PathBuf, Error> {
        let path = self.0.join(name);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
        }
        Ok(path)
    }
}

/// Describes the first surface with a negative disparity.
fn negative_disparity(truth: &GroundTruth) -> Option<String> {
    [("left", &truth.left), ("right", &truth.right)].into_iter().find_map(|(eye, truth)| {
        let mut pixels = truth.disparity.iter().zip(truth.surfaces());
        let index = pixels.position(|(&disparity, is_surface)| is_surface && disparity < 0.0)?;
        let (column, row) = (index % truth.width as usize, index / truth.width as usize);
        Some(format!("the {eye} view has {} px at column {column}, row {row}", truth.disparity[index]))
    })
}

fn middlebury(
    batch: &mut Batch,
    root: &Root<'_>,
    index: u32,
    pair: &StereoPair,
    truth: &GroundTruth,
) -> Result<(), Error> {
    let file = |name: &str| root.file(&format!("{index:06}/{name}"));
    for (eye, (view, truth)) in [(&pair.left, &truth.left), (&pair.right, &truth.right)].into_iter().enumerate() {
        batch.add_png(file(&format!("im{eye}.png"))?, &view.picture())?;
        add_disparity(batch, &file, eye, truth)?;
    }
    batch.add_calib(file("calib.txt")?, truth)
}

/// Adds an eye's disparity and masks in Middlebury's formats. `file` returns the path of a name.
fn add_disparity(
    batch: &mut Batch,
    file: &impl Fn(&str) -> Result<PathBuf, Error>,
    eye: usize,
    truth: &EyeTruth,
) -> Result<(), Error> {
    let known = truth.disparity.iter().zip(truth.surfaces());
    let known =
        Vec::from_iter(known.map(|(&disparity, is_surface)| if is_surface { disparity } else { f32::INFINITY }));
    batch.add_pfm(file(&format!("disp{eye}.pfm"))?, truth.width, truth.height, &known)?;
    batch.add_known_nocc_mask(file(&format!("mask{eye}nocc.png"))?, truth)?;
    batch.add_sky_mask(file(&format!("mask{eye}sky.png"))?, truth)
}

fn panorama(
    batch: &mut Batch,
    root: &Root<'_>,
    index: u32,
    pair: &StereoPair,
    truth: &GroundTruth,
) -> Result<(), Error> {
    let file = |name: &str| root.file(&format!("{index:06}/{name}"));
    for (eye, (view, truth)) in [(&pair.left, &truth.left), (&pair.right, &truth.right)].into_iter().enumerate() {
        batch.add_panorama_png(file(&format!("im{eye}.png"))?, view, &pair.pose)?;
        add_disparity(batch, &file, eye, truth)?;
        batch.add_pfm(file(&format!("distance{eye}.pfm"))?, truth.width, truth.height, &truth.distance)?;
    }
    #[cfg(feature = "json")]
    batch.add_camera_json(file("camera.json")?, &pair.pose)?;
    Ok(())
}

fn kitti(batch: &mut Batch, root: &Root<'_>, index: u32, pair: &StereoPair, truth: &GroundTruth) -> Result<(), Error> {
    let file = |folder: &str| root.file(&format!("training/{folder}/{index:06}_10.png"));
    batch.add_png(file("image_2")?, &pair.left.picture())?;
    batch.add_png(file("image_3")?, &pair.right.picture())?;
    let EyeTruth { width, height, disparity, .. } = &truth.left;
    batch.add_kitti_disparity(file("disp_occ_0")?, *width, *height, disparity, &truth.left.surfaces())?;
    batch.add_kitti_disparity(file("disp_noc_0")?, *width, *height, disparity, &truth.left.surfaces_of_both())?;
    let calibration = kitti_calibration(truth)?;
    batch.add(root.file(&format!("training/calib_cam_to_cam/{index:06}.txt"))?, calibration.as_bytes())
}

fn kitti_motion(
    batch: &mut Batch,
    root: &Root<'_>,
    index: u32,
    truth: &GroundTruth,
    motion: &LayoutMotion<'_>,
) -> Result<(), Error> {
    let file = |folder: &str, number: u32| root.file(&format!("training/{folder}/{index:06}_{number}.png"));
    batch.add_png(file("image_2", 11)?, &motion.pair.left.picture())?;
    batch.add_png(file("image_3", 11)?, &motion.pair.right.picture())?;
    let (eye, flow) = (&truth.left, &motion.forward.left);
    let both = |one: Vec<bool>, other: Vec<bool>| Vec::from_iter(one.into_iter().zip(other).map(|(a, b)| a && b));
    batch.add_kitti_flow(file("flow_occ", 10)?, flow, &both(eye.surfaces(), flow.known()))?;
    batch.add_kitti_flow(file("flow_noc", 10)?, flow, &both(eye.surfaces(), flow.visible()))?;
    let then = eye.disparity.iter().zip(&flow.disparity_change).map(|(now, change)| now + change);
    let then: Vec<f32> = then.collect();
    // Points that have left the picture may have any disparity.
    let fits = then.iter().map(|&disparity| disparity > 0.0 && disparity < Layout::Kitti.disparity_limit() - 0.5);
    let valid = both(both(eye.surfaces(), flow.known()), fits.collect());
    batch.add_kitti_disparity(file("disp_occ_1", 10)?, eye.width, eye.height, &then, &valid)
}

/// Returns KITTI's calibration text. Camera 2 is the left one, at the origin of the rectified frame, and camera 3 is
/// the right one. Principal points are relative to the centre of the top left pixel.
fn kitti_calibration(truth: &GroundTruth) -> Result<String, Error> {
    let pose = &truth.pose;
    let [width, height] = pose.size;
    let Intrinsics { fx, fy, cx0, cx1, cy } = pose.planar_intrinsics()?;
    let cy = cy - 0.5;
    let mut text = String::new();
    let rounding = pose.baseline_rounding();
    // Vector from the right eye to the left eye: right, down, forward. Apart from rounding, the right eye is on the
    // left eye's x axis.
    let to_left = DVec3::new(-pose.baseline(), rounding.y, -rounding.z) + DVec3::ZERO; // avoids -0
    for (name, cx, shift) in [("02", cx0 - 0.5, DVec3::ZERO), ("03", cx1 - 0.5, to_left)] {
        let DVec3 { x, y, z } = shift;
        let (right, down) = (fx * x + cx * z, fy * y + cy * z);
        text += &format!(
            "S_{name}: {width} {height}\nK_{name}: {fx} 0 {cx} 0 {fy} {cy} 0 0 1\nD_{name}: 0 0 0 0 0\n\
             R_{name}: 1 0 0 0 1 0 0 0 1\nT_{name}: {x} {y} {z}\nS_rect_{name}: {width} {height}\n\
             R_rect_{name}: 1 0 0 0 1 0 0 0 1\nP_rect_{name}: {fx} 0 {cx} {right} 0 {fy} {cy} {down} 0 0 1 {z}\n"
        );
    }
    Ok(text)
}

fn scene_flow(
    batch: &mut Batch,
    root: &Root<'_>,
    index: u32,
    pair: &StereoPair,
    truth: &GroundTruth,
) -> Result<(), Error> {
    for (eye, view, truth) in [("left", &pair.left, &truth.left), ("right", &pair.right, &truth.right)] {
        let file = |kind: &str, ending: &str| root.file(&format!("{kind}/stereotrace/{eye}/{index:04}.{ending}"));
        batch.add_png(file("frames_finalpass", "png")?, &view.picture())?;
        batch.add_pfm(file("disparity", "pfm")?, truth.width, truth.height, &truth.disparity)?;
        for (kind, ids) in [("object_index", &truth.object), ("material_index", &truth.material)] {
            batch.add_indices_pfm(file(kind, "pfm")?, truth.width, truth.height, ids)?;
        }
    }
    let path = root.file(&format!("camera_data/stereotrace/{index:04}.txt"))?;
    batch.add(path, camera_data(index, truth).as_bytes())
}

/// Adds the flow and the change of disparity of frame `index`.
fn scene_flow_motion(
    batch: &mut Batch,
    root: &Root<'_>,
    index: u32,
    (folder, name): (&str, &str),
    flow: &Flow,
) -> Result<(), Error> {
    for (eye, letter, flow) in [("left", 'L', &flow.left), ("right", 'R', &flow.right)] {
        let file = format!("optical_flow/stereotrace/{folder}/{eye}/OpticalFlow{name}_{index:04}_{letter}.pfm");
        batch.add_flow_pfm(root.file(&file)?, flow)?;
        let file = format!("disparity_change/stereotrace/{folder}/{eye}/{index:04}.pfm");
        batch.add_pfm(root.file(&file)?, flow.width, flow.height, &flow.disparity_change)?;
    }
    Ok(())
}

/// Returns an entry of `camera_data.txt`: the matrices from an eye's frame to the world, row by row. The frame has x
/// right, y up, and the camera looks along -z.
fn camera_data(index: u32, truth: &GroundTruth) -> String {
    let pose = &truth.pose;
    let [right, up, back] = [pose.right, pose.up, -pose.forward].map(|axis| axis.as_dvec3());
    let matrix = |side: f32| {
        let eye = pose.eye_position(side);
        let rows = [0, 1, 2].map(|axis| format!("{} {} {} {}", right[axis], up[axis], back[axis], eye[axis]));
        format!("{} 0 0 0 1", rows.join(" "))
    };
    format!("Frame {index}\nL {}\nR {}\n\n", matrix(-1.0), matrix(1.0))
}
