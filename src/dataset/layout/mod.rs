//! Writes folder layouts that loaders of existing data sets can read.

mod kitti;
mod scene_flow;
mod sintel;

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{Error, EyeTruth, Flow, GroundTruth, Projection, StereoPair, error::by_name, output::Batch};

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
    /// `disp_noc_0`, and `calib_cam_to_cam/000000.txt`. Sky is not valid.
    ///
    /// Pairs with motion also have their next pair, `image_2/000000_11.png` and `image_3`, the left view's flow,
    /// `flow_occ` and `flow_noc`, and the disparity of its points at the next time, `disp_occ_1` and `disp_noc_1`.
    /// `obj_map` has 1, 2 and so on for objects that move, and 0 elsewhere.
    Kitti,
    /// Scene Flow's Monkaa and Driving (Mayer et al. 2016), with one sequence named `stereotrace`:
    /// `frames_finalpass/stereotrace/left/0000.png`, `right`, the same for `disparity`, `object_index` and
    /// `material_index` as PFM, and `camera_data/stereotrace/0000.txt`. Concatenate the camera files to get a
    /// `camera_data.txt`. As in Scene Flow, id 0 means a miss. There is no clean pass.
    ///
    /// Pairs with motion take two numbers each, for the pair and its next one. `optical_flow` and `disparity_change`
    /// hold the motion of the first one's points in `into_future`, and of the next one's points in `into_past`.
    SceneFlow,
    /// MPI Sintel (Butler et al. 2012) and its stereo pairs, with a sequence per pair, `000000`:
    /// `training/final_left/000000/frame_0001.png` and `final_right`; for the left view `disparities`, `occlusions`,
    /// `outofframe` and `camdata_left`. There is no clean pass. Disparities of sky are 0.
    ///
    /// Pairs with motion have their next pair as `frame_0002`, and the first one's flow: `final`, `flow`, `invalid`,
    /// and, as an addition, `flow_occlusions`. Stereo pairs and flow of Sintel have different masks of the name
    /// `occlusions`.
    Sintel,
    /// Equirectangular pairs, with a folder per pair, `000000/`: `im0.png` and `im1.png`, which name their projection
    /// (XMP, `GPano`), `disp0.pfm` and `disp1.pfm` in columns, `distance0.pfm` and `distance1.pfm`, the masks of
    /// [`Layout::Middlebury`], and with the feature `json` also `camera.json`. A surface at column x of the left view
    /// is at column `x - d` of the right view, modulo the width for 360 degrees. The disparity of sky is infinite.
    Panorama,
}

impl Layout {
    /// All layouts, starting with the default.
    pub const ALL: &'static [Self] = &[Self::Middlebury, Self::Kitti, Self::SceneFlow, Self::Sintel, Self::Panorama];

    /// Returns the name that [`FromStr`](std::str::FromStr) parses and [`Display`](std::fmt::Display) writes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Middlebury => "middlebury",
            Self::Kitti => "kitti",
            Self::SceneFlow => "sceneflow",
            Self::Sintel => "sintel",
            Self::Panorama => "panorama",
        }
    }

    /// Returns whether the layout requires parallel cameras. Middlebury's `doffs` allows converged cameras, but its
    /// loaders accept no negative disparities.
    pub fn is_parallel(self) -> bool {
        match self {
            Self::Kitti | Self::SceneFlow | Self::Sintel => true,
            Self::Middlebury | Self::Panorama => false,
        }
    }

    /// Returns whether the layout holds pairs with motion.
    pub fn holds_motion(self) -> bool {
        match self {
            Self::Kitti | Self::SceneFlow | Self::Sintel => true,
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
        match self {
            Self::Kitti => 256.0,
            Self::Sintel => sintel::DISPARITY_LIMIT,
            Self::Middlebury | Self::SceneFlow | Self::Panorama => f32::INFINITY,
        }
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
                kitti::motion(batch, &Root(folder), index, truth, &motion)
            }
            Self::SceneFlow => {
                let [now, then] = [2 * index, 2 * index + 1];
                self.add(batch, folder, now, pair, truth)?;
                self.add(batch, folder, then, motion.pair, motion.truth)?;
                scene_flow::motion(batch, &Root(folder), now, ("into_future", "IntoFuture"), motion.forward)?;
                scene_flow::motion(batch, &Root(folder), then, ("into_past", "IntoPast"), motion.backward)
            }
            Self::Sintel => {
                self.add(batch, folder, index, pair, truth)?;
                self.check(motion.pair, motion.truth)?;
                sintel::motion(batch, &Root(folder), index, pair, &motion)
            }
            Self::Middlebury | Self::Panorama => {
                let reason = format!("{self}: it holds no motion; use kitti, sceneflow or sintel");
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
        self.check(pair, truth)?;
        let (root, item) = (Root(folder.as_ref()), Item { index, pair, truth });
        match self {
            Self::Middlebury => middlebury(batch, &root, &item),
            Self::Kitti => kitti::pair(batch, &root, &item),
            Self::SceneFlow => scene_flow::pair(batch, &root, &item),
            Self::Sintel => sintel::pair(batch, &root, &item),
            Self::Panorama => panorama(batch, &root, &item),
        }
    }

    /// Refuses cameras that the layout can't hold.
    fn check(self, pair: &StereoPair, truth: &GroundTruth) -> Result<(), Error> {
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
        Ok(())
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

/// A pair to write.
struct Item<'a> {
    index: u32,
    pair: &'a StereoPair,
    truth: &'a GroundTruth,
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

fn middlebury(batch: &mut Batch, root: &Root<'_>, item: &Item<'_>) -> Result<(), Error> {
    let Item { index, pair, truth } = item;
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

fn panorama(batch: &mut Batch, root: &Root<'_>, item: &Item<'_>) -> Result<(), Error> {
    let Item { index, pair, truth } = item;
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
