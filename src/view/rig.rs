//! Rigs: eyes on one line behind one screen, their traced views, and the source views of all other views.

use glam::{DVec3, Vec3};

use super::camera::Field;
use crate::{Distortion, Error, Lens, Options, Pose, Projection, StereoCamera, Visibility};

/// Least number of views for which two traced views are better than one. Each other view then has a nearer source view,
/// and most have traced views on both sides. This leaves far fewer shadow rays. With 45 views, each other view then
/// costs 0.074 of a traced view in the hall (0.049 for the dragon), instead of 0.126 (0.059).
const FOR_TWO: usize = 24;

/// Distance of two traced views from the ends of their group, as a share of the group's width.
const FROM_END: f32 = 1.0 / 7.0;

/// Maximum number of views of a rig.
pub const MAX_VIEWS: usize = 1024;

/// Eyes on one line that share one screen, for multi-view displays and light fields. A pair is a rig of two;
/// [`Rig::mono`] is a rig of one eye.
///
/// An eye is at `eye + r o e`. `eye` is the camera's midpoint, `r` its right axis, `e` its interaxial, and `o` the
/// eye's offset. All eyes look through the same screen rectangle. The parallax between eyes a and b is therefore
/// `(o_b - o_a) e_px (1 - d/Z)`, of either sign. For parallel cameras it is `(o_a - o_b) f_px e / Z`.
///
/// Some views are traced. Each other view is made from the nearest traced view, its source. Toed-in eyes can be
/// rendered only one at a time, each as a camera of its own ([`Pose::of_eye`]) at offset 0.
///
/// ```
/// use stereotrace::{Rig, StereoCamera, glam::Vec3};
///
/// let camera = StereoCamera::look_at(Vec3::new(0.0, 1.0, 5.0), Vec3::ZERO).interaxial_pixels(2.0);
/// let rig = Rig::row(camera, 5);
/// assert_eq!(rig.offsets(), [-2.0, -1.0, 0.0, 1.0, 2.0]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    camera: StereoCamera,
    offsets: Vec<f32>,
    traced: Option<Vec<usize>>,
}

/// Makes the stereo pair of a camera, as [`Rig::pair`] does.
impl From<StereoCamera> for Rig {
    fn from(camera: StereoCamera) -> Self {
        Self::pair(camera)
    }
}

impl Rig {
    /// Creates a rig of one eye at the camera's midpoint.
    pub fn mono(camera: StereoCamera) -> Self {
        Self::at(camera, vec![0.0])
    }

    /// Creates a stereo pair, left and right; the right view is made from the left one.
    pub fn pair(camera: StereoCamera) -> Self {
        Self { camera, offsets: vec![-0.5, 0.5], traced: Some(vec![0]) }
    }

    /// Creates a row of `eyes` eyes from left to right, an interaxial apart, centred at the camera's midpoint.
    pub fn row(camera: StereoCamera, eyes: usize) -> Self {
        let middle = 0.5 * eyes.saturating_sub(1) as f32;
        // Rendering rejects rows that are too long. The limit keeps them from filling memory before that.
        Self::at(camera, (0..eyes.min(MAX_VIEWS + 1)).map(|eye| eye as f32 - middle).collect())
    }

    /// Creates a rig with the given offsets to the right of the camera's midpoint, in interaxials, in any order.
    pub fn at(camera: StereoCamera, offsets: Vec<f32>) -> Self {
        Self { camera, offsets, traced: None }
    }

    /// Sets the traced views, as indices into the offsets. By default, as few views are traced as needed to keep every
    /// other view within [`Rig::REACH`] of its source. Where one traced view would serve 24 views or more, two are
    /// traced. With `bracket`, a view between two traced views queries both for visibility bits, the nearer view first.
    pub fn traced(mut self, views: Vec<usize>) -> Self {
        self.traced = Some(views);
        self
    }

    /// Returns the eyes' offsets from the camera's midpoint, in interaxials.
    pub fn offsets(&self) -> &[f32] {
        &self.offsets
    }

    /// Maximum parallax at infinity between a view and its source, as a share of the picture's width, unless
    /// [`Rig::traced`] is set. For parallel cameras the limit applies to the parallax at the target's distance.
    pub const REACH: f32 = 1.0 / 8.0;

    /// Checks the rig and returns its eyes, for a scene with this origin.
    ///
    /// # Errors
    /// [`Error::Rig`] for no eyes, too many eyes, equal offsets, several toed-in eyes, or invalid sources.
    /// [`Error::Camera`] if f32 does not resolve the outermost or the closest eyes.
    pub(crate) fn eyes(&self, scene_origin: DVec3) -> Result<Eyes, Error> {
        let fault = |reason| Err(Error::Rig { reason });
        let count = self.offsets.len();
        if count == 0 || count > MAX_VIEWS {
            let count = if count == 0 { "no eyes".into() } else { format!("more than {MAX_VIEWS} eyes") };
            return fault(format!("it has {count}; 1 to {MAX_VIEWS} can be rendered"));
        }
        if let Some(offset) = self.offsets.iter().find(|offset| !offset.is_finite()) {
            return fault(format!("an eye's offset is {offset}; it must be finite"));
        }
        let mut sorted = self.offsets.clone();
        sorted.sort_by(f32::total_cmp);
        if let Some(two) = sorted.windows(2).find(|two| two[0] == two[1]) {
            return fault(format!("two eyes have the offset {}", two[0]));
        }
        let pose = self.camera.pose_in(scene_origin)?;
        match (pose.projection, &self.offsets[..]) {
            (Projection::OffAxis, _) => {}
            (Projection::ToeIn, [offset]) => return Ok(Eyes::mono(pose.of_eye(2.0 * offset))),
            (Projection::ToeIn, _) => {
                return fault(format!(
                    "its {count} eyes are toed in, so rows are not epipolar lines; render them as a pair, or one at a \
                     time"
                ));
            }
            (Projection::Lenses([left, right]), [offset]) if *offset != 0.0 || left == right => {
                return Ok(Eyes::mono(pose.of_eye(2.0 * offset)));
            }
            (Projection::Lenses(_), [_]) => {
                return fault("its lenses differ, and the midpoint has neither; render its eyes as a pair".into());
            }
            (Projection::Lenses(_), _) => {
                return fault(format!(
                    "the lenses of its {count} eyes distort the pictures, so rows are not epipolar lines; render them \
                     as a pair, or one at a time"
                ));
            }
            (Projection::Equirectangular(_), [0.0] | [-0.5, 0.5]) => {}
            (Projection::Equirectangular(_), offsets) => {
                return fault(format!(
                    "its eyes have the offsets {offsets:?}; equirectangular pictures are rendered as a pair, or as one \
                     picture from the midpoint"
                ));
            }
        }
        if pose.interaxial > 0.0 && count > 1 {
            // The outermost eye with its mirror image, and the two closest eyes, must each form a valid pair.
            let span = 2.0 * sorted[0].abs().max(sorted[count - 1].abs());
            let gap = sorted.windows(2).map(|two| two[1] - two[0]).fold(f32::INFINITY, f32::min);
            for apart in [span, gap] {
                self.camera.check_apart(&pose, apart)?;
            }
        }
        let sources = match &self.traced {
            Some(traced) => self.sources_asked_for(traced)?,
            None => self.sources_by_rule(&pose),
        };
        let seconds = seconds(&self.offsets, &sources);
        Ok(Eyes { pose, offsets: self.offsets.clone(), sources, seconds })
    }

    /// Returns the nearest of the given views for each view.
    fn sources_asked_for(&self, traced: &[usize]) -> Result<Vec<usize>, Error> {
        if traced.is_empty() {
            return Err(Error::Rig { reason: "no view is traced; at least one must be".into() });
        }
        if let Some(view) = traced.iter().find(|&&view| view >= self.offsets.len()) {
            let views = crate::message::counted(self.offsets.len(), "view", "views");
            return Err(Error::Rig {
                reason: format!("view {view} is to be traced, but there are {views}, counted from 0"),
            });
        }
        Ok(self.sources(traced))
    }

    fn sources(&self, traced: &[usize]) -> Vec<usize> {
        let apart = |a: usize, b: usize| (self.offsets[a] - self.offsets[b]).abs();
        let nearest = |view| traced.iter().copied().min_by(|&a, &b| apart(a, view).total_cmp(&apart(b, view)));
        (0..self.offsets.len()).filter_map(nearest).collect()
    }

    /// Chooses as few traced views as needed to keep every other view within [`Rig::REACH`]. A group of at least
    /// `FOR_TWO` views gets two traced views. Returns the source of each view.
    fn sources_by_rule(&self, pose: &Pose) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.offsets.len()).collect();
        order.sort_by(|&a, &b| self.offsets[a].total_cmp(&self.offsets[b]));
        let reach = Self::REACH * pose.size[0] as f32 / pose.typical_parallax_px().max(f32::MIN_POSITIVE);
        let ends = |group: &[usize]| (self.offsets[group[0]], self.offsets[group[group.len() - 1]]);
        let mut traced = Vec::new();
        // Splits the eyes into the fewest groups of equal size that are no wider than twice the reach.
        let fits = |groups: &usize| {
            order.chunks(order.len().div_ceil(*groups)).all(|group| ends(group).1 - ends(group).0 <= 2.0 * reach)
        };
        let groups = (1..=order.len()).find(fits).unwrap_or(order.len());
        for group in order.chunks(order.len().div_ceil(groups)) {
            let (first, last) = ends(group);
            let at = |way: f32| {
                let off = |view: &usize| (self.offsets[*view] - (first + way * (last - first))).abs();
                group.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(group[0])
            };
            traced.extend(if group.len() < FOR_TWO { vec![at(0.5)] } else { vec![at(FROM_END), at(1.0 - FROM_END)] });
        }
        self.sources(&traced)
    }
}

/// Returns for each view the nearest traced view on the opposite side from its source, or else its source.
fn seconds(offsets: &[f32], sources: &[usize]) -> Vec<usize> {
    let second = |(view, &source): (usize, &usize)| {
        let side = (offsets[source] - offsets[view]).signum();
        let traced = (0..sources.len()).filter(|&other| sources[other] == other);
        let beyond = traced.filter(|&other| source != view && (offsets[other] - offsets[view]) * side < 0.0);
        let apart = |other: &usize| (offsets[*other] - offsets[view]).abs();
        beyond.min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(source)
    };
    sources.iter().enumerate().map(second).collect()
}

/// The section of `shaders/shared/camera.wgsl` that computes rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum CameraModel {
    /// All rays of a view start at its eye.
    Planar,
    /// Rays are tangents of a viewing circle.
    Around,
    /// All rays of a view start at its eye, and pass through a lens.
    Lens(LensModel),
}

/// The section of `shaders/shared/lens.wgsl` that computes the radial part of a distortion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum LensModel {
    Radial,
    Fisheye,
}

/// The checked eyes of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Eyes {
    /// Camera at the rig's midpoint.
    pub(crate) pose: Pose,
    /// Offset of each eye from the midpoint along `pose.right`, in interaxials.
    pub(crate) offsets: Vec<f32>,
    /// Source of each view; a traced view is its own source.
    pub(crate) sources: Vec<usize>,
    /// Second source of each view: the nearest traced view on the opposite side from its source, or else its source.
    pub(crate) seconds: Vec<usize>,
}

impl Eyes {
    /// Returns the eyes of a pair; the right view is made from the left one.
    pub(crate) fn pair(pose: &Pose) -> Self {
        Self { pose: *pose, offsets: vec![-0.5, 0.5], sources: vec![0, 0], seconds: vec![0, 0] }
    }

    /// Returns a single, traced eye.
    pub(crate) fn mono(pose: Pose) -> Self {
        Self { pose, offsets: vec![0.0], sources: vec![0], seconds: vec![0] }
    }

    /// Returns the eyes' positions relative to the scene's origin. Those of an equirectangular pair look ahead.
    pub(crate) fn positions(&self) -> Vec<Vec3> {
        self.offsets.iter().map(|offset| self.pose.eye_in_scene(2.0 * offset)).collect()
    }

    /// Checks that the options are for these eyes.
    ///
    /// # Errors
    /// [`Error::Options`] for equirectangular pictures, and pictures of lenses, by the T-buffer.
    pub(crate) fn check(&self, options: &Options) -> Result<(), Error> {
        if self.model() == CameraModel::Around && options.visibility == Visibility::TBuffer {
            let reason = "the T-buffer makes planar pictures only, no equirectangular ones".into();
            return Err(Error::Options { option: "visibility", reason });
        }
        if matches!(self.model(), CameraModel::Lens(_)) && options.visibility == Visibility::TBuffer {
            let reason = "the T-buffer draws straight edges, which lenses with distortion bend".into();
            return Err(Error::Options { option: "visibility", reason });
        }
        Ok(())
    }

    /// Returns the camera model of kernels.
    pub(crate) fn model(&self) -> CameraModel {
        match self.pose.field {
            Field::Screen(_) => CameraModel::Planar,
            Field::Sphere(_) => CameraModel::Around,
            Field::Lenses([Lens { distortion: Distortion::RadialTangential { .. }, .. }, _]) => {
                CameraModel::Lens(LensModel::Radial)
            }
            Field::Lenses([Lens { distortion: Distortion::Fisheye { .. }, .. }, _]) => {
                CameraModel::Lens(LensModel::Fisheye)
            }
        }
    }

    /// Returns whether any view has a second source.
    pub(crate) fn has_seconds(&self) -> bool {
        self.seconds != self.sources
    }

    /// Returns the pose of a view and its source as a pair: its interaxial is the distance between the two eyes.
    pub(crate) fn pair_of(&self, view: usize) -> Pose {
        self.pose.apart((self.offsets[view] - self.offsets[self.sources[view]]).abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> StereoCamera {
        StereoCamera::look_at(5.0 * Vec3::Z, Vec3::ZERO).size(512, 512).interaxial_pixels(2.0)
    }

    #[test]
    fn no_view_is_farther_from_its_source_than_the_rule_says() {
        for (eyes, traced) in [(1, 1), (2, 1), (23, 1), (24, 2), (45, 2), (65, 2), (66, 4), (200, 8)] {
            let rig = Rig::row(camera(), eyes);
            let sources = rig.eyes(DVec3::ZERO).unwrap().sources;
            let found: std::collections::BTreeSet<_> = sources.iter().copied().collect();
            assert_eq!(found.len(), traced, "{eyes} eyes: {found:?}");
            for (view, &source) in sources.iter().enumerate() {
                assert_eq!(sources[source], source, "{eyes}: {view}'s source is none");
                let apart = (rig.offsets[view] - rig.offsets[source]).abs() * 2.0;
                assert!(apart <= Rig::REACH * 512.0, "{eyes}: {view} from {source}, {apart} px");
            }
        }
    }

    #[test]
    fn rigs_that_cannot_be_rendered_are_refused_by_name() {
        let refused = |rig: Rig| rig.eyes(DVec3::ZERO).unwrap_err().to_string();
        assert!(refused(Rig::row(camera(), 0)).contains("no eyes"));
        assert!(refused(Rig::row(camera(), usize::MAX)).contains("more than 1024 eyes"));
        assert!(refused(Rig::at(camera(), vec![1.0, 0.0, 1.0])).contains("two eyes have the offset 1"));
        assert!(refused(Rig::at(camera(), vec![f32::NAN])).contains("NaN"));
        assert!(
            refused(Rig::row(camera(), 3).traced(vec![3])).contains("view 3 is to be traced, but there are 3 views")
        );
        assert!(refused(Rig::row(camera(), 3).traced(vec![])).contains("at least one"));
        assert!(refused(Rig::at(camera(), vec![0.0, 1e9])).contains("interaxial"));
        assert!(refused(Rig::at(camera().eye(Vec3::splat(1e7)), vec![0.0, 1e-3])).contains("interaxial"));
    }

    #[test]
    fn the_sources_that_are_asked_for_serve_the_views_beside_them() {
        let rig = Rig::row(camera(), 6).traced(vec![4, 1]);
        assert_eq!(rig.eyes(DVec3::ZERO).unwrap().sources, [1, 1, 1, 4, 4, 4]);
    }
}
