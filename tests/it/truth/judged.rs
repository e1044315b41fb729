//! Compares views with the truth.

use stereotrace::{
    Method, Options, Renderer, Scene, StereoCamera, View,
    blocking::Wait,
    glam::DVec3,
    testing::cpu::{Eye, Frame},
};

use super::{Seen, Truth};

/// Errors of a view: the number of pixels that show another primitive, and the largest errors of the other pixels.
/// `depth` is relative to the depth. `depth_by_slope` is also multiplied by the slope at which the ray meets the
/// surface.
#[derive(Debug, Default)]
pub(crate) struct Judged {
    pub others: usize,
    pub depth: f64,
    pub depth_by_slope: f64,
    /// Largest error of a linear colour. It excludes pixels whose light changes within a step of 0.02 pixels, and
    /// pixels whose slope is too small.
    pub color: f64,
    pub seen: usize,
}

fn judge(view: &View, truth: &[Seen], beside: &[Vec<Seen>], least_slope: f64) -> Judged {
    let mut judged = Judged::default();
    for (index, seen) in truth.iter().enumerate() {
        if view.primitive[index] != seen.primitive {
            judged.others += 1;
        } else if seen.t.is_finite() {
            judged.seen += 1;
            let error = (f64::from(view.depth[index]) / seen.t - 1.0).abs();
            judged.depth = judged.depth.max(error);
            judged.depth_by_slope = judged.depth_by_slope.max(error * seen.slope);
            let found = DVec3::from_array([0, 1, 2].map(|c| f64::from(view.linear[index][c])));
            let smooth = |other: &Vec<Seen>| {
                other[index].primitive == seen.primitive && other[index].linear.distance(seen.linear) < 1e-3
            };
            if seen.slope > least_slope && beside.iter().all(smooth) {
                judged.color = judged.color.max((found - seen.linear).abs().max_element());
            }
        }
    }
    judged
}

/// Renders both views of a scene by `Naive` and compares them. Colours count only where rays meet surfaces at more than
/// this slope.
pub(crate) fn judged(renderer: &mut Renderer, scene: &Scene, camera: &StereoCamera, least_slope: f64) -> [Judged; 2] {
    let uploaded = renderer.upload(scene).wait().unwrap();
    let pair =
        renderer.pair(&uploaded, camera).options(&Options::new(Method::Naive).linear(true)).read().wait().unwrap();
    let frame = Frame::new(&pair.pose);
    let truth = Truth::new(scene);
    let [width, height] = frame.size();
    [(Eye::Left, &pair.left), (Eye::Right, &pair.right)].map(|(eye, view)| {
        let around = [(0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02)].map(|(x, y)| {
            let direction = |index: usize| {
                let at = frame.direction(eye, index % width, index / width);
                let [right, down] = [frame.direction(eye, 1, 0), frame.direction(eye, 0, 1)];
                at + x * (right - frame.direction(eye, 0, 0)) + y * (down - frame.direction(eye, 0, 0))
            };
            (0..width * height).map(|index| truth.see(frame.eye(eye), direction(index))).collect::<Vec<_>>()
        });
        judge(view, &truth.view(&frame, eye), &around, least_slope)
    })
}
