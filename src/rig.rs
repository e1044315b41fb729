//! Eyes on one line behind one screen: which are traced, and from which the others are made.

use glam::{DVec3, Vec3};

use crate::{
    Choice, Convergence, Error, Method, PassTimes, PixelSource, Pose, ShadowBufferWork, ShadowSource, StereoCamera,
    View, Work, cpu,
    frame::uniform::{frame_uniform, same_parallax},
    layout,
};

/// Where one traced view would serve so many, two do: each other view has a nearer one, and most have one on either
/// side, so that far fewer shadow rays are left. Of 45 views of the hall the others then cost .074 of a traced one each
/// for .126, of the dragon .049 for .059.
const FOR_TWO: usize = 24;

/// Where these two stand: so far of the way between the outermost eyes from either end.
const FROM_END: f32 = 1.0 / 7.0;

/// Views of a rig at most.
pub const MAX_VIEWS: usize = 1024;

/// Eyes on one line behind one screen, for multi-view displays and light fields: a pair is a rig of two, and one eye is
/// a rig too ([`Rig::mono`]).
///
/// Eyes stand at `eye + r o e`, with the camera's midpoint, its right `r` and its interaxial `e`; `o` is an eye's
/// offset. All look through the same screen rectangle, so the parallax between two of them is `(o_b - o_a) e_px (1 -
/// d/Z)`, of either sign; parallel cameras' is `(o_a - o_b) f_px e / Z`. Some views are traced, their sources; each
/// other view is made from the source nearest to it. Of eyes that are toed in, one at a time can be rendered: as a
/// camera of its own, [`Pose::of_eye`], at offset 0.
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

impl Rig {
    /// One eye, at the camera's midpoint.
    pub fn mono(camera: StereoCamera) -> Self {
        Self::at(camera, vec![0.0])
    }

    /// Left and right, an interaxial apart; the right view is made from the left one.
    pub fn pair(camera: StereoCamera) -> Self {
        Self { camera, offsets: vec![-0.5, 0.5], traced: Some(vec![0]) }
    }

    /// So many eyes from left to right, an interaxial between neighbours, the camera's midpoint in their middle.
    pub fn row(camera: StereoCamera, eyes: usize) -> Self {
        let middle = 0.5 * eyes.saturating_sub(1) as f32;
        // What is too many is refused when it is rendered; until then it must not fill memory.
        Self::at(camera, (0..eyes.min(MAX_VIEWS + 1)).map(|eye| eye as f32 - middle).collect())
    }

    /// Eyes at given offsets from the camera's midpoint, in interaxials, to the right; in any order.
    pub fn at(camera: StereoCamera, offsets: Vec<f32>) -> Self {
        Self { camera, offsets, traced: None }
    }

    /// The views that are traced, by their places among the offsets. Without it, one is for every [`Rig::REACH`] of the
    /// picture's width that the eyes reach to both sides, and two where it would serve 24 views. By `bracket` a
    /// view with a traced one on either side asks both which lights its points see, the nearer one first.
    pub fn traced(mut self, views: Vec<usize>) -> Self {
        self.traced = Some(views);
        self
    }

    /// The eyes' offsets from the camera's midpoint, in interaxials.
    pub fn offsets(&self) -> &[f32] {
        &self.offsets
    }

    /// How far, as a share of the picture's width, a view is carried from its source at most (parallax at infinity; of
    /// parallel cameras that at the target's distance), unless [`Rig::traced`] says otherwise.
    pub const REACH: f32 = 1.0 / 8.0;

    /// # Errors
    /// [`Error::Rig`] for no eyes, too many, two in one place, several that are toed in, and sources that are no eyes;
    /// [`Error::Camera`] for a camera whose outermost or closest eyes f32 does not hold.
    pub(crate) fn eyes(&self, scene_origin: DVec3) -> Result<Eyes, Error> {
        let fault = |reason| Err(Error::Rig { reason });
        let count = self.offsets.len();
        if count == 0 || count > MAX_VIEWS {
            let count = if count == 0 { "no eyes".into() } else { format!("more than {MAX_VIEWS} eyes") };
            return fault(format!("it has {count}; 1 to {MAX_VIEWS} can be rendered"));
        }
        if let Some(offset) = self.offsets.iter().find(|offset| !offset.is_finite()) {
            return fault(format!("an eye's offset is {offset}"));
        }
        let mut sorted = self.offsets.clone();
        sorted.sort_by(f32::total_cmp);
        if let Some(two) = sorted.windows(2).find(|two| two[0] == two[1]) {
            return fault(format!("two eyes have the offset {}", two[0]));
        }
        let pose = self.camera.pose_in(scene_origin)?;
        if pose.convergence == Convergence::ToeIn {
            return match self.offsets[..] {
                [offset] => Ok(Eyes::mono(pose.of_eye(2.0 * offset))),
                _ => fault(format!(
                    "its {count} eyes are toed in, so that rows are no epipolar lines; render them as a pair, or one at a time"
                )),
            };
        }
        if pose.interaxial > 0.0 && count > 1 {
            // The outermost eyes, and the closest ones, must be a pair that a camera may have.
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

    /// Of each view the nearest one of these.
    fn sources_asked_for(&self, traced: &[usize]) -> Result<Vec<usize>, Error> {
        if traced.is_empty() {
            return Err(Error::Rig { reason: "no view is to be traced; at least one must be".into() });
        }
        if let Some(view) = traced.iter().find(|&&view| view >= self.offsets.len()) {
            let views = crate::message::counted(self.offsets.len(), "view", "views");
            return Err(Error::Rig { reason: format!("view {view} is to be traced, but there are {views}, from 0") });
        }
        Ok(self.sources(traced))
    }

    fn sources(&self, traced: &[usize]) -> Vec<usize> {
        let apart = |a: usize, b: usize| (self.offsets[a] - self.offsets[b]).abs();
        let nearest = |view| traced.iter().copied().min_by(|&a, &b| apart(a, view).total_cmp(&apart(b, view)));
        (0..self.offsets.len()).filter_map(nearest).collect()
    }

    /// As few traced views as bring each other one within [`Rig::REACH`], from left to right; twice as many where each
    /// serves many views.
    fn sources_by_rule(&self, pose: &Pose) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.offsets.len()).collect();
        order.sort_by(|&a, &b| self.offsets[a].total_cmp(&self.offsets[b]));
        let reach = Self::REACH * pose.size[0] as f32 / pose.typical_parallax_px().max(f32::MIN_POSITIVE);
        let ends = |group: &[usize]| (self.offsets[group[0]], self.offsets[group[group.len() - 1]]);
        let mut traced = Vec::new();
        // Groups of equal numbers of eyes, so many that none is wider than twice the reach.
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

/// Of each view the nearest of the sources that stand on its other side than its own one, or that again.
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

/// The eyes of a frame, checked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Eyes {
    /// Of the middle.
    pub(crate) pose: Pose,
    /// Of each eye from the middle along `pose.right`, in interaxials.
    pub(crate) offsets: Vec<f32>,
    /// Of each view the one that it is made from; one that is traced is its own.
    pub(crate) sources: Vec<usize>,
    /// Of each view the nearest one that is traced on its other side, or its source again where there is none.
    pub(crate) seconds: Vec<usize>,
}

impl Eyes {
    /// Left and right; the right view is made from the left one.
    pub(crate) fn pair(pose: &Pose) -> Self {
        Self { pose: *pose, offsets: vec![-0.5, 0.5], sources: vec![0, 0], seconds: vec![0, 0] }
    }

    /// One eye, which is traced.
    pub(crate) fn mono(pose: Pose) -> Self {
        Self { pose, offsets: vec![0.0], sources: vec![0], seconds: vec![0] }
    }

    /// Where they are, relative to the scene's origin.
    pub(crate) fn positions(&self) -> Vec<Vec3> {
        self.offsets.iter().map(|offset| self.pose.eye_in_scene(2.0 * offset)).collect()
    }

    /// As kernels read a view and its source.
    pub(crate) fn frame(&self, view: usize) -> layout::Frame {
        let apart = self.offsets[view] - self.offsets[self.seconds[view]];
        layout::Frame {
            second_parallax_px: self.pose.parallax().times(apart).scale_px,
            second_same_parallax: same_parallax(&self.pose, apart),
            ..frame_uniform(&self.pose, self.offsets[self.sources[view]], self.offsets[view])
        }
    }

    /// Whether some view has a source on either side.
    pub(crate) fn has_seconds(&self) -> bool {
        self.seconds != self.sources
    }

    /// The same for the kernels' twins.
    pub(crate) fn cpu_frame(&self, view: usize) -> cpu::Frame {
        cpu::Frame::between(&self.pose, self.offsets[self.sources[view]], self.offsets[view])
    }

    /// A view and its source as a pair: the pose whose interaxial is the distance between them.
    pub(crate) fn pair_of(&self, view: usize) -> Pose {
        self.pose.apart((self.offsets[view] - self.offsets[self.sources[view]]).abs())
    }
}

/// The views of a rig.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Views {
    /// One an eye, in the rig's order.
    pub views: Vec<RigView>,
    /// The camera in the middle of the rig.
    pub pose: Pose,
    /// Time of each pass in order; `None` where the adapter has no timestamps, or too few for so many passes.
    pub times: Option<PassTimes>,
    /// Whether threads left work to further dispatches: see [`Statistics::in_steps`](crate::Statistics::in_steps).
    pub in_steps: bool,
    /// Device memory of the buffers between the passes in bytes, without the views themselves.
    pub intermediate_bytes: u64,
    /// What filling shadow-buffers cost: see [`Statistics::shadow_buffer`](crate::Statistics::shadow_buffer).
    pub shadow_buffer: ShadowBufferWork,
}

impl Views {
    /// The cost of all views that are not traced relative to that of one traced view, by counters and a view (DESIGN,
    /// section 7). NaN unless counting was asked for.
    pub fn other_views(&self) -> f64 {
        let sum = |traced: bool| {
            let costs = self.views.iter().enumerate().filter(|(index, view)| (view.made_from == *index) == traced);
            costs.fold((0.0, 0.0), |(cost, views), (_, view)| (cost + view.work.cost() as f64, views + 1.0))
        };
        let ((traced, sources), (made, others)) = (sum(true), sum(false));
        (made / others) / (traced / sources)
    }
}

/// A view of a rig, and how it came about.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RigView {
    /// What the eye sees.
    pub view: View,
    /// The eye's offset from the rig's midpoint, in interaxials.
    pub offset: f32,
    /// The view that it was made from; its own place if it was traced.
    pub made_from: usize,
    /// The method that made it; why, where [`Method::Auto`] chose.
    pub method: Method,
    /// Why [`Method::Auto`] chose it; `None` by other methods.
    pub choice: Option<Choice>,
    /// Where each pixel came from, row-major.
    pub source: Vec<PixelSource>,
    /// How it is known which lights each pixel sees, row-major; by `bracket` only, else empty.
    pub shadow_source: Vec<ShadowSource>,
    /// What it cost.
    pub work: Work,
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
