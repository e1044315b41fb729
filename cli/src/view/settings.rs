//! Stores the window's settings, which keys and mouse change and which each frame uses.

use stereotrace::{
    Equirectangular, Method, Options, StereoCamera,
    output::{Combination, Packing},
};

use super::{
    control::Place,
    head::Head,
    show::{Look, Sight, eye_size},
};
use crate::{arguments::Stage, target::EyesArguments};

/// Size at the beginning of one eye's part of a window that shows parts of an equirectangular pair, in pixels.
const WINDOW: [u32; 2] = [960, 600];

/// Supported numbers of samples per pixel.
const SAMPLES: [u32; 8] = [1, 4, 9, 16, 25, 36, 49, 64];

/// How the window shows both views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Anaglyph,
    SideBySide,
    CrossEyed,
    /// Both views in turn.
    Wiggle,
    Left,
    Right,
}

impl Mode {
    /// All modes, in the order of the number keys.
    pub(super) const ALL: [Self; 6] =
        [Self::Anaglyph, Self::SideBySide, Self::CrossEyed, Self::Wiggle, Self::Left, Self::Right];

    /// Returns the mode of a packing, or anaglyph mode for `None`.
    ///
    /// # Errors
    /// Fails for a packing that the window can't show.
    pub(super) fn of(packing: Option<Packing>) -> Result<Self, String> {
        match packing {
            None => Ok(Self::Anaglyph),
            Some(Packing::SideBySide) => Ok(Self::SideBySide),
            Some(Packing::CrossEyed) => Ok(Self::CrossEyed),
            Some(other) => Err(format!("--packing {other}: a window can show only side-by-side and cross-eyed")),
        }
    }

    pub(super) fn packing(self) -> Option<Packing> {
        match self {
            Self::SideBySide => Some(Packing::SideBySide),
            Self::CrossEyed => Some(Packing::CrossEyed),
            Self::Anaglyph | Self::Wiggle | Self::Left | Self::Right => None,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Anaglyph => "anaglyph",
            Self::SideBySide => "side by side",
            Self::CrossEyed => "cross-eyed",
            Self::Wiggle => "wiggle",
            Self::Left => "left eye",
            Self::Right => "right eye",
        }
    }
}

/// Settings that determine the picture in the window.
#[derive(Clone, Debug)]
pub(super) struct Settings {
    pub(super) mode: Mode,
    /// Anaglyph colours, and whether the eyes are exchanged. The field's packing is unused, since `mode` replaces it.
    pub(super) eyes: EyesArguments,
    pub(super) options: Options,
    /// Size of the window in pixels. A side is 0 if the window is minimised.
    pub(super) window: [u32; 2],
    /// Pose of the eyes.
    pub(super) place: Place,
    /// The head that turns inside an equirectangular pair; `None` for planar pairs.
    pub(super) head: Option<Head>,
    /// Settings of the command line.
    begin: Begin,
}

#[derive(Clone, Debug)]
struct Begin {
    camera: StereoCamera,
    place: Place,
    /// Size of an eye's picture in pixels.
    size: [u32; 2],
    options: Options,
}

impl Settings {
    pub(super) fn new(stage: &Stage, eyes: &EyesArguments, size: [u32; 2]) -> Result<Self, Box<dyn std::error::Error>> {
        let mode = Mode::of(eyes.packing)?;
        let place = Place::of(&stage.camera)?;
        let around = stage.camera.projection_kind().equirectangular();
        let head = around.map(|Equirectangular { span, .. }| Head::new(span));
        let [width, height] = head.map_or(size, |_| WINDOW);
        let window = match mode.packing() {
            Some(_) => [width.saturating_mul(2), height],
            None => [width, height],
        };
        let options = stage.options.clone();
        let begin = Begin { camera: stage.camera, place, size, options: options.clone() };
        Ok(Self { mode, eyes: eyes.clone(), options, window, place, head, begin })
    }

    /// Returns how to draw the views. In wiggle mode, `turn` selects the right one.
    pub(super) fn look(&self, turn: bool) -> Look {
        match self.mode {
            Mode::Anaglyph => Look::Both(Combination::Anaglyph(self.eyes.anaglyph)),
            Mode::SideBySide => Look::Both(Combination::Packed(Packing::SideBySide)),
            Mode::CrossEyed => Look::Both(Combination::Packed(Packing::CrossEyed)),
            Mode::Wiggle => Look::One { right: turn },
            Mode::Left => Look::One { right: false },
            Mode::Right => Look::One { right: true },
        }
    }

    /// Returns what the window shows of the views. In wiggle mode, `turn` selects the right one.
    pub(super) fn sight(&self, turn: bool) -> Sight {
        let cut = |head: Head| head.cut(self.place.interaxial().into(), self.place.screen_distance().into());
        Sight { look: self.look(turn), swap: self.eyes.swap, cut: self.head.map(cut) }
    }

    /// Returns the size in pixels of an eye's part of the window.
    pub(super) fn shown_size(&self) -> [u32; 2] {
        eye_size(self.look(false), self.window)
    }

    /// Returns the size of an eye's picture in pixels: the window's, or the command line's for equirectangular pairs.
    pub(super) fn size(&self) -> [u32; 2] {
        if self.head.is_some() { self.begin.size } else { self.shown_size() }
    }

    /// Returns whether the camera or the picture's size differs from the command line's.
    pub(super) fn is_moved(&self) -> bool {
        self.place.is_elsewhere(&self.begin.place) || self.size() != self.begin.size
    }

    /// Returns the camera of a whole picture. If nothing has moved, the result is the command line's own camera, so
    /// that pictures are identical bit for bit.
    pub(super) fn camera(&self) -> StereoCamera {
        if self.is_moved() { self.camera_of(self.size()) } else { self.begin.camera }
    }

    /// Returns the camera of the same view with another size in pixels.
    pub(super) fn camera_of(&self, [width, height]: [u32; 2]) -> StereoCamera {
        self.place.camera(self.begin.camera).size(width, height)
    }

    /// Returns the arguments for writing pictures.
    pub(super) fn eyes_written(&self) -> EyesArguments {
        let packing = match &self.begin.camera.pose() {
            Ok(pose) if self.head.is_some() => {
                EyesArguments { packing: None, ..self.eyes.clone() }.suiting(pose).packing
            }
            _ => self.mode.packing(),
        };
        EyesArguments { packing, ..self.eyes.clone() }
    }

    /// Moves the eyes.
    ///
    /// # Errors
    /// Fails if the moved camera is invalid. The eyes then do not move.
    pub(super) fn move_eyes(&mut self, by: impl FnOnce(&mut Place)) -> Result<(), String> {
        let mut place = self.place;
        by(&mut place);
        let camera = place.camera(self.begin.camera).size(self.size()[0].max(1), self.size()[1].max(1));
        camera.pose().map_err(|error| error.to_string())?;
        self.place = place;
        Ok(())
    }

    /// Resets camera and options to the values of the command line.
    pub(super) fn reset(&mut self) {
        self.place = self.begin.place;
        self.head = self.head.map(|head| head.reset());
        self.options = self.begin.options.clone();
    }

    /// Selects the next method, or the previous one.
    pub(super) fn step_method(&mut self, back: bool) {
        let all = Method::ALL;
        let at = all.iter().position(|method| *method == self.options.method);
        let next = match (at, back) {
            (None, _) => 0,
            (Some(at), false) => (at + 1) % all.len(),
            (Some(at), true) => (at + all.len() - 1) % all.len(),
        };
        self.options.method = all[next];
    }

    /// Selects more or fewer samples per pixel, and disables adaptive antialiasing.
    pub(super) fn step_samples(&mut self, fewer: bool) {
        let above = SAMPLES.partition_point(|samples| *samples <= self.options.samples);
        let next = if fewer { above.saturating_sub(2) } else { above.min(SAMPLES.len() - 1) };
        self.options.adaptive = None;
        self.options.samples = SAMPLES[next];
    }

    /// Selects the next kind of anaglyph.
    pub(super) fn step_anaglyph(&mut self) {
        let all = stereotrace::output::Anaglyph::ALL;
        let at = all.iter().position(|kind| *kind == self.eyes.anaglyph).unwrap_or(0);
        self.eyes.anaglyph = all[(at + 1) % all.len()];
    }
}
