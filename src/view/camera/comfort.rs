//! Viewing comfort of a stereo pair (thesis, section 2.3.2 and equation 12).

use super::{HUMAN_INTERAXIAL, Pose, Projection};

impl Pose {
    /// Returns the viewing comfort of a pair on a display `display_width` metres wide. The pair's hits lie between
    /// depths `nearest` and `farthest` (`f32::INFINITY` if sky is visible).
    /// [`StereoCamera::comfortable`](super::StereoCamera::comfortable) chooses a comfortable camera.
    pub fn comfort(&self, nearest: f32, farthest: f32, display_width: f32) -> Comfort {
        let width = self.size[0] as f32;
        let positive_px = self.parallax_px(farthest).max(0.0);
        let negative_px = self.parallax_px(nearest).min(0.0);
        Comfort {
            interaxial_ratio: self.interaxial_px / width,
            interaxial_limit: HUMAN_INTERAXIAL / display_width,
            nearest_ratio: nearest / self.screen_distance,
            vertical_parallax_px: self.vertical_parallax_px(nearest, farthest),
            positive_parallax_px: positive_px,
            negative_parallax_px: negative_px,
            positive_parallax_percent: 100.0 * positive_px / width,
            negative_parallax_percent: 100.0 * negative_px / width,
            display_width,
            shown: match self.projection {
                Projection::Equirectangular(_) => Shown::Around,
                _ if self.screen_distance.is_infinite() => Shown::Parallel,
                _ => Shown::ThroughScreen,
            },
        }
    }
}

/// Vertical parallax of toed-in eyes, in pixels, above which a warning is given.
const MOST_VERTICAL_PX: f32 = 1.0;

/// Viewing comfort of a stereo pair. It leads to warnings, never to an error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Comfort {
    /// `e / w`, the parallax at infinity as a share of the picture's width (thesis, eq. 12, left side). It is 0 for
    /// parallel cameras.
    pub interaxial_ratio: f32,
    /// `e_real / w_display`: 6.5 cm over the display's width (thesis, eq. 12, right side).
    pub interaxial_limit: f32,
    /// Depth of the nearest hit over the screen's distance; below 0.5 it is too near (thesis, section 2.3.2). It is 0
    /// for parallel cameras, which show everything in front of the display.
    pub nearest_ratio: f32,
    /// Largest parallax behind the screen, in pixels, at least 0.
    pub positive_parallax_px: f32,
    /// Largest parallax in front of the screen, in pixels, at most 0.
    pub negative_parallax_px: f32,
    /// Largest parallax behind the screen, in percent of the picture's width.
    pub positive_parallax_percent: f32,
    /// Largest parallax in front of the screen, in percent of the picture's width.
    pub negative_parallax_percent: f32,
    /// Largest vertical parallax, in pixels, of points in the corners of either picture at the two depths. It is 0
    /// unless the eyes are toed in.
    pub vertical_parallax_px: f32,
    /// Width of the display in metres.
    pub display_width: f32,
    shown: Shown,
}

/// Where a display is relative to what it shows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shown {
    ThroughScreen,
    /// The screen is at infinity.
    Parallel,
    /// The pictures surround the viewer, so rules for displays don't apply.
    Around,
}

impl Comfort {
    /// Returns whether viewers can fuse the pair without diverging eyes (thesis, eq. 12).
    pub fn converges(&self) -> bool {
        self.interaxial_ratio < self.interaxial_limit
    }

    /// Returns whether nothing is nearer than half the screen's distance (thesis, section 2.3.2).
    pub fn nothing_too_near(&self) -> bool {
        self.nearest_ratio >= 0.5
    }

    /// Returns a sentence for each violated rule; the list is empty for a comfortable pair. The rules are for pictures
    /// on a display, and not for equirectangular ones.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.shown == Shown::Around {
            return warnings;
        }
        if !self.converges() {
            warnings.push(format!(
                "the interaxial is {:.2}% of the width, over the {:.2}% at which eyes diverge on a display {:.2} m \
                 wide",
                100.0 * self.interaxial_ratio,
                100.0 * self.interaxial_limit,
                self.display_width
            ));
        }
        if self.shown == Shown::Parallel {
            warnings.push(format!(
                "the screen is at infinity, so everything appears in front of the display, by up to {:.1} px: choose a \
                 distance, or shift the pictures apart",
                -self.negative_parallax_px
            ));
        } else if !self.nothing_too_near() {
            warnings.push(format!(
                "the nearest surface is at {:.2} of the screen's distance, nearer than one half",
                self.nearest_ratio
            ));
        }
        if self.vertical_parallax_px > MOST_VERTICAL_PX {
            warnings.push(format!(
                "the eyes are toed in: points are up to {:.1} px higher in one picture than in the other",
                self.vertical_parallax_px
            ));
        }
        warnings
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use crate::StereoCamera;

    #[test]
    fn comfort_follows_equation_12() {
        let camera = StereoCamera::look_at(5.0 * Vec3::Z, Vec3::ZERO).size(200, 100).screen_width(4.0);
        let pose = camera.screen_distance(5.0).interaxial(0.2).pose().unwrap();
        let comfort = pose.comfort(2.6, f32::INFINITY, 0.5);
        assert_eq!(comfort.interaxial_ratio, 0.05);
        assert!(comfort.converges() && comfort.nothing_too_near() && comfort.warnings().is_empty());
        assert_eq!(comfort.positive_parallax_percent, 5.0);
        let parallel = camera.screen_distance(f32::INFINITY).vertical_fov_degrees(40.0).interaxial(0.2).pose().unwrap();
        let comfort = parallel.comfort(4.0, f32::INFINITY, 0.5);
        assert_eq!((comfort.interaxial_ratio, comfort.positive_parallax_px), (0.0, 0.0));
        // Parallax is f e / Z. The focal length f is half the height over the tangent of half the angle.
        let f = 50.0 / 20.0_f32.to_radians().tan();
        assert!((comfort.negative_parallax_px + f * 0.05).abs() < 1e-4, "{comfort:?}");
        assert!(comfort.converges() && !comfort.nothing_too_near());
        assert!(comfort.warnings().len() == 1 && comfort.warnings()[0].contains("at infinity"), "{comfort:?}");
        let cinema = pose.comfort(2.4, 10.0, 12.0);
        assert!(!cinema.converges() && !cinema.nothing_too_near());
        assert_eq!(cinema.warnings().len(), 2);
    }
}
