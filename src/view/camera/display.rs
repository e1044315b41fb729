//! Chooses the interaxial and the screen's distance for a display, its viewers and a scene (DESIGN, section 2).

use std::fmt;

use super::{Aperture, Screen, StereoCamera};
use crate::Error;

/// Largest parallax behind and in front of the display, as shares of its width, by television's percentage rule.
const PERCENT_BEHIND: f64 = 0.02;
const PERCENT_BEFORE: f64 = 0.01;
/// Smallest common distance between human eyes, in metres. More parallax behind the display makes eyes diverge.
const EYES_APART: f64 = 0.063;
/// Largest angular disparity, degrees.
const MOST_DEGREES: f64 = 1.0;
/// Largest interaxial, as a share of the nearest depth.
const OF_NEAREST: f64 = 1.0 / 30.0;

/// A display that shows a pair. Each picture is as wide as the display.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Display {
    /// Width in metres.
    pub width: f32,
    /// Distance from the viewers' eyes to the display, in metres.
    pub viewing_distance: f32,
}

impl Display {
    /// Makes a display from its width and viewing distance, both in metres.
    pub fn new(width: f32, viewing_distance: f32) -> Self {
        Self { width, viewing_distance }
    }

    /// Makes a display from its diagonal in inches (2.54 cm), its aspect, such as `[16.0, 9.0]`, and its viewing
    /// distance in metres.
    pub fn diagonal(inches: f32, [width, height]: [f32; 2], viewing_distance: f32) -> Self {
        Self::new(0.0254 * inches * width / width.hypot(height), viewing_distance)
    }

    /// Returns the largest parallax behind and in front of the display, as shares of its width. Each comes with the
    /// rule that sets it.
    fn budget(&self) -> [(f64, ComfortRule); 2] {
        let [width, distance] = [self.width, self.viewing_distance].map(f64::from);
        let by_angle = (2.0 * distance * (0.5 * MOST_DEGREES).to_radians().tan() / width, ComfortRule::OneDegree);
        let behind =
            [(PERCENT_BEHIND, ComfortRule::Percentage), (EYES_APART / width, ComfortRule::Divergence), by_angle];
        let before = [(PERCENT_BEFORE, ComfortRule::Percentage), by_angle];
        let least = |rules: &[(f64, ComfortRule)]| rules.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0));
        [least(&behind), least(&before)].map(|rule| rule.unwrap_or(by_angle))
    }
}

/// A rule for a comfortable pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ComfortRule {
    /// Parallax from -1% to 2% of the display's width.
    Percentage,
    /// Parallax behind the display of at most 63 mm, so that eyes don't diverge.
    Divergence,
    /// At most one degree of angular disparity: `2 atan(p / 2v)` for a parallax p at viewing distance v.
    OneDegree,
    /// Interaxial of at most a thirtieth of the nearest depth.
    Thirtieth,
    /// No point nearer than half the screen's distance (thesis, section 2.3.2).
    HalfScreen,
}

impl fmt::Display for ComfortRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Percentage => "-1% to 2% of the display's width",
            Self::Divergence => "63 mm behind the display",
            Self::OneDegree => "1 degree of angular disparity",
            Self::Thirtieth => "a 30th of the nearest distance",
            Self::HalfScreen => "half of the screen's distance",
        })
    }
}

/// A camera chosen by a display's rules, and the rules that limit its depth.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Comfortable {
    /// The camera with the chosen interaxial and screen distance. Its field of view is unchanged.
    pub camera: StereoCamera,
    /// The chosen interaxial `e`, world units.
    pub interaxial: f32,
    /// The chosen distance `d` to the screen, world units.
    pub screen_distance: f32,
    /// Rules that a larger interaxial would break at any screen distance. The list has at least one rule.
    pub binding: Vec<ComfortRule>,
}

impl StereoCamera {
    /// Chooses the interaxial and the screen's distance for a display and a scene. The scene's visible points lie
    /// between depths `nearest` and `farthest` (`f32::INFINITY` if sky is visible). The camera shows as much depth as
    /// every [`ComfortRule`] allows.
    ///
    /// A point at depth Z has the parallax `p(Z) = e f (1/d - 1/Z)` in widths of the display. Here `f` is the focal
    /// length in widths of the picture. Let `N` and `F` be the nearest and farthest depth, and `v` the viewing
    /// distance. The largest parallax behind the display is `A = min(2%, 63 mm / width, 2 v tan 0.5° / width)`. The
    /// largest parallax in front of it is `B = min(1%, 2 v tan 0.5° / width)`. The interaxial is the least of
    ///
    /// - `(A + B) / (f (1/N - 1/F))`: the range of parallax,
    /// - `A / (f (1/2N - 1/F))`, if that is above 0: the screen is no farther than `2N`,
    /// - `N / 30`.
    ///
    /// The screen's distance is given by `1/d = 1/F + (1/N - 1/F) A / (A + B)`, which uses A and B equally. If the
    /// rules forbid this distance, the nearest allowed value is chosen. [`View::depth_range`](crate::View::depth_range)
    /// returns the depths of a picture, and [`Pose::depth_range_of`](crate::Pose::depth_range_of) the depths of a box.
    /// For toed-in eyes the formulas hold on the axis between the eyes.
    ///
    /// ```
    /// use stereotrace::{Builtin, camera::{ComfortRule, Display}};
    ///
    /// let camera = Builtin::Hall.camera(1920, 1080).vertical_fov_degrees(20.0);
    /// let chosen = camera.comfortable((2.5, 30.0), &Display::diagonal(55.0, [16.0, 9.0], 2.5))?;
    /// assert_eq!(chosen.binding, [ComfortRule::Percentage]);
    /// let pose = chosen.camera.pose()?;
    /// assert!((pose.parallax_px(30.0) / 1920.0 - 0.02).abs() < 1e-6);
    /// assert!((pose.parallax_px(2.5) / 1920.0 + 0.01).abs() < 1e-6);
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// - [`Error::Options`] for depths that are not above 0 or not in order, and for a display without width or
    ///   distance.
    /// - [`Error::Camera`] if this camera or the chosen camera is invalid.
    pub fn comfortable(&self, (nearest, farthest): (f32, f32), display: &Display) -> Result<Comfortable, Error> {
        if !(nearest > 0.0 && nearest.is_finite() && farthest >= nearest) {
            let reason = format!(
                "they are {nearest} to {farthest}; the nearest must be finite and above 0, the farthest at least as far"
            );
            return Err(Error::Options { option: "depths", reason });
        }
        for (what, length) in [("width", display.width), ("viewing distance", display.viewing_distance)] {
            if !(length > 0.0 && length.is_finite()) {
                let reason = format!("its {what} is {length}; it must be a number of metres above 0");
                return Err(Error::Options { option: "display", reason });
            }
        }
        let wide = self.focal_in_widths()?;
        let [(behind, behind_rule), (before, before_rule)] = display.budget();
        let [near, far] = [nearest, farthest].map(|z| 1.0 / f64::from(z));
        // A quotient by 0 is infinite and does not limit the interaxial, for example if all points have one depth.
        let by_range = (behind + before) / (wide * (near - far));
        let by_half = if 0.5 * near > far { behind / (wide * (0.5 * near - far)) } else { f64::INFINITY };
        let by_nearest = OF_NEAREST * f64::from(nearest);
        let interaxial = by_range.min(by_half).min(by_nearest);
        let rules = [
            (by_range, behind_rule),
            (by_range, before_rule),
            (by_half, behind_rule),
            (by_half, ComfortRule::HalfScreen),
            (by_nearest, ComfortRule::Thirtieth),
        ];
        let mut binding = Vec::new();
        for (_, rule) in rules.into_iter().filter(|(bound, _)| *bound == interaxial) {
            if !binding.contains(&rule) {
                binding.push(rule);
            }
        }
        let alike = far + (near - far) * behind / (behind + before);
        let per_depth = interaxial * wide;
        let screen = alike.max(near - before / per_depth).max(0.5 * near).min(far + behind / per_depth);
        let (interaxial, screen_distance) = (interaxial as f32, (1.0 / screen) as f32);
        let camera = self.seen_through(screen_distance).interaxial(interaxial);
        camera.pose()?;
        Ok(Comfortable { camera, interaxial, screen_distance, binding })
    }

    /// Returns the focal length in widths of the picture, independent of interaxial and screen.
    fn focal_in_widths(&self) -> Result<f64, Error> {
        let alone = match self.aperture {
            Aperture::ScreenWidth(_) => *self,
            _ => self.screen_distance(f32::INFINITY),
        };
        let Some([focal, _]) = alone.interaxial(0.0).pose()?.focal_px() else {
            let reason = "it is for pictures on a screen, and not for equirectangular ones".into();
            return Err(Error::Options { option: "display", reason });
        };
        Ok(focal / f64::from(self.width))
    }

    /// Returns a camera with the same field of view and another screen distance.
    fn seen_through(self, distance: f32) -> Self {
        match (self.aperture, self.screen) {
            (Aperture::ScreenWidth(width), Screen::Distance(before)) => {
                self.screen_width(width * (distance / before)).screen_distance(distance)
            }
            _ => self.screen_distance(distance),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::{random::Random, view::camera::Intrinsics};

    /// A camera whose focal length is the picture's width.
    fn camera() -> StereoCamera {
        StereoCamera::look_at(Vec3::Z, Vec3::ZERO).size(1000, 500).screen_width(3.0).screen_distance(3.0)
    }

    #[test]
    fn each_rule_binds_where_the_closed_form_says() {
        let (set, cinema, close) = (Display::new(1.0, 2.0), Display::new(12.0, 15.0), Display::new(0.5, 0.3));
        let by_angle = 2.0 * 0.3 * 0.5_f32.to_radians().tan() / 0.5;
        let inf = f32::INFINITY;
        use ComfortRule::{Divergence, HalfScreen, OneDegree, Percentage, Thirtieth};
        for (depths, display, e, d, rules) in [
            // e = 3% (1/2)^-1, and 1/d = 1/2 2/3.
            ((2.0, inf), set, 0.06, 3.0, vec![Percentage]),
            // 3% (1/2 - 1/8)^-1 would be .08, so a thirtieth of 2 binds; 1/d = 1/8 + 3/8 2/3.
            ((2.0, 8.0), set, 2.0 / 30.0, 8.0 / 3.0, vec![Thirtieth]),
            ((5.0, 5.0), set, 5.0 / 30.0, 5.0, vec![Thirtieth]),
            // 63 mm of 12 m are 0.525%. Both the range of parallax and the limit of 2N bind.
            ((1.0, inf), cinema, 0.0105, 2.0, vec![Divergence, HalfScreen]),
            // A = 0.525%, B = 1%, and 1/d = 1/3 + 2/3 0.525/1.525.
            (
                (1.0, 3.0),
                cinema,
                0.022_875,
                1.0 / (1.0 / 3.0 + 2.0 / 3.0 * 0.525 / 1.525),
                vec![Divergence, Percentage],
            ),
            // At 30 cm, one degree is 1.05% of 50 cm.
            (
                (2.0, inf),
                close,
                2.0 * (by_angle + 0.01),
                2.0 * (by_angle + 0.01) / by_angle,
                vec![OneDegree, Percentage],
            ),
        ] {
            let found = camera().comfortable(depths, &display).unwrap();
            assert!((found.interaxial / e - 1.0).abs() < 1e-5, "{depths:?}: {found:?}");
            assert!((found.screen_distance / d - 1.0).abs() < 1e-5, "{depths:?}: {found:?}");
            assert_eq!(found.binding, rules, "{depths:?}");
            // The field of view is unchanged.
            let (before, after) = (camera().pose().unwrap(), found.camera.pose().unwrap());
            assert!((after.focal_px().unwrap()[0] / before.focal_px().unwrap()[0] - 1.0).abs() < 1e-6);
            assert_eq!((after.interaxial, after.screen_distance), (found.interaxial, found.screen_distance));
        }
        let diagonal = Display::diagonal(55.0, [16.0, 9.0], 2.0);
        assert!((diagonal.width - 1.2176).abs() < 1e-4, "{diagonal:?}");
    }

    /// Returns whether every rule holds, computed from parallax alone.
    fn holds(pose: &crate::Pose, (near, far): (f32, f32), display: &Display, slack: f32) -> bool {
        let share = |z: f32| pose.parallax_px(z) / pose.size[0] as f32;
        let degrees =
            |z: f32| (0.5 * share(z).abs() * display.width / display.viewing_distance).atan().to_degrees() * 2.0;
        share(far) <= 0.02 * slack
            && share(near) >= -0.01 * slack
            && share(far) * display.width <= 0.063 * slack
            && degrees(near).max(degrees(far)) <= slack
            && pose.interaxial <= near / 30.0 * slack
            && near / pose.screen_distance >= 0.5 / slack
    }

    #[test]
    fn what_is_chosen_keeps_every_rule_and_no_larger_interaxial_does() {
        let mut random = Random::new(8);
        for number in 0..300 {
            let power = |random: &mut Random, low: f32, high: f32| 10_f32.powf(random.between(low, high));
            let near = power(&mut random, -1.0, 2.0);
            let far = if number % 3 == 0 { f32::INFINITY } else { near * power(&mut random, 0.01, 2.0) };
            let display = Display::new(power(&mut random, -1.0, 1.2), power(&mut random, -0.5, 1.3));
            let camera = match number % 4 {
                0 => camera(),
                1 => camera().vertical_fov_degrees(random.between(5.0, 100.0)),
                2 => camera().vertical_fov_degrees(50.0).screen_distance(f32::INFINITY),
                _ => camera().intrinsics(Intrinsics::new([900.0, 700.0], [300.0, 290.0]).right_cx(310.0)),
            };
            let found = camera.comfortable((near, far), &display).unwrap();
            assert!(!found.binding.is_empty());
            let pose = found.camera.pose().unwrap();
            assert!(holds(&pose, (near, far), &display, 1.0 + 1e-4), "{number}: {found:?}");
            let wider = found.camera.interaxial(1.01 * found.interaxial);
            for step in 0..400 {
                let distance = near * 2.2 * 0.5_f32.powf(step as f32 / 60.0 - 1.0);
                let pose = wider.seen_through(distance).pose().unwrap();
                assert!(!holds(&pose, (near, far), &display, 1.0), "{number}: {found:?} {distance}");
            }
        }
    }

    #[test]
    fn depths_and_displays_that_are_none_are_refused() {
        let display = Display::new(1.0, 2.0);
        for depths in
            [(0.0, 1.0), (-1.0, 5.0), (2.0, 1.0), (f32::NAN, 1.0), (1.0, f32::NAN), (f32::INFINITY, f32::INFINITY)]
        {
            assert!(camera().comfortable(depths, &display).unwrap_err().to_string().contains("depths"));
        }
        for display in [Display::new(0.0, 1.0), Display::new(1.0, f32::NAN), Display::new(f32::INFINITY, 1.0)] {
            assert!(camera().comfortable((1.0, 2.0), &display).unwrap_err().to_string().contains("display"));
        }
        assert!(camera().size(0, 1).comfortable((1.0, 2.0), &display).is_err());
        let parallel_by_width = camera().screen_distance(f32::INFINITY);
        assert!(parallel_by_width.comfortable((1.0, 2.0), &display).unwrap_err().to_string().contains("screen_width"));
    }

    #[test]
    fn a_box_s_depths_are_those_of_its_corners() {
        let pose = StereoCamera::look_at(Vec3::new(1.0, 2.0, 9.0), Vec3::new(0.0, 2.0, 0.0)).pose().unwrap();
        let (low, high) = (DVec3::new(-1.0, -2.0, -3.0), DVec3::new(2.0, 1.0, 4.0));
        let depths = (0..8).map(|corner| {
            let at = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            pose.project(DVec3::new(at(0), at(1), at(2)), 0.0)[2]
        });
        let (near, far) = depths.fold((f32::INFINITY, 0.0_f32), |(near, far), z| (near.min(z), far.max(z)));
        let found = pose.depth_range_of((low, high));
        assert!((found.0 - near).abs() < 1e-5 && (found.1 - far).abs() < 1e-5, "{found:?} {near} {far}");
    }
}
