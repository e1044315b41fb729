//! What is shown and how: what keys and mouse change, and what a frame is made of.

use stereotrace::{Method, Options, StereoCamera, output::Packing};

use super::{
    control::Place,
    show::{Look, eye_size},
};
use crate::{arguments::Stage, target::EyesArguments};

/// Numbers of samples that there are.
const SAMPLES: [u32; 8] = [1, 4, 9, 16, 25, 36, 49, 64];

/// How both eyes come to the eyes of who looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Anaglyph,
    SideBySide,
    CrossEyed,
    /// One after the other.
    Wiggle,
    Left,
    Right,
}

impl Mode {
    /// Every mode, as the number keys have them.
    pub(super) const ALL: [Self; 6] =
        [Self::Anaglyph, Self::SideBySide, Self::CrossEyed, Self::Wiggle, Self::Left, Self::Right];

    /// The mode that shows what a packing is.
    pub(super) fn of(packing: Option<Packing>) -> Result<Self, String> {
        match packing {
            None => Ok(Self::Anaglyph),
            Some(Packing::SideBySide) => Ok(Self::SideBySide),
            Some(Packing::CrossEyed) => Ok(Self::CrossEyed),
            Some(other) => Err(format!("--packing {other}: a window shows side-by-side and cross-eyed")),
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

/// What is shown and how.
#[derive(Clone, Debug)]
pub(super) struct Settings {
    pub(super) mode: Mode,
    /// Colours, and whether the eyes are exchanged; its packing is the mode's.
    pub(super) eyes: EyesArguments,
    pub(super) options: Options,
    /// Of the window, pixels; a side is 0 where it is minimised.
    pub(super) window: [u32; 2],
    /// Where the eyes are.
    pub(super) place: Place,
    /// As the command line says it.
    begin: Begin,
}

#[derive(Clone, Debug)]
struct Begin {
    camera: StereoCamera,
    place: Place,
    /// Of an eye's picture.
    size: [u32; 2],
    options: Options,
}

impl Settings {
    pub(super) fn new(stage: &Stage, eyes: &EyesArguments, size: [u32; 2]) -> Result<Self, Box<dyn std::error::Error>> {
        let mode = Mode::of(eyes.packing)?;
        let place = Place::of(&stage.camera)?;
        let window = match mode.packing() {
            Some(_) => [size[0].saturating_mul(2), size[1]],
            None => size,
        };
        let options = stage.options.clone();
        let begin = Begin { camera: stage.camera, place, size, options: options.clone() };
        Ok(Self { mode, eyes: eyes.clone(), options, window, place, begin })
    }

    /// How eyes are shown, in wiggle mode the right one in its turn.
    pub(super) fn look(&self, turn: bool) -> Look {
        match self.mode {
            Mode::Anaglyph => Look::Anaglyph(self.eyes.anaglyph),
            Mode::SideBySide => Look::Beside { crossed: false },
            Mode::CrossEyed => Look::Beside { crossed: true },
            Mode::Wiggle => Look::One { right: turn },
            Mode::Left => Look::One { right: false },
            Mode::Right => Look::One { right: true },
        }
    }

    /// Of an eye's picture, pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        eye_size(self.look(false), self.window)
    }

    /// Whether the camera is the command line's no more.
    pub(super) fn is_moved(&self) -> bool {
        self.place != self.begin.place || self.size() != self.begin.size
    }

    /// The camera of a whole frame. Where nothing has been moved it is the command line's own, so that pictures are the
    /// same to the bit.
    pub(super) fn camera(&self) -> StereoCamera {
        if self.is_moved() { self.camera_of(self.size()) } else { self.begin.camera }
    }

    /// The same view in another number of pixels.
    pub(super) fn camera_of(&self, [width, height]: [u32; 2]) -> StereoCamera {
        self.place.camera(self.begin.camera).size(width, height)
    }

    /// How both eyes become what is written.
    pub(super) fn eyes_written(&self) -> EyesArguments {
        EyesArguments { packing: self.mode.packing(), ..self.eyes.clone() }
    }

    /// Moves the eyes, unless there is no picture from there: then it says why.
    pub(super) fn move_eyes(&mut self, by: impl FnOnce(&mut Place)) -> Result<(), String> {
        let mut place = self.place;
        by(&mut place);
        let camera = place.camera(self.begin.camera).size(self.size()[0].max(1), self.size()[1].max(1));
        camera.pose().map_err(|error| error.to_string())?;
        self.place = place;
        Ok(())
    }

    /// Back to where the command line begins.
    pub(super) fn reset(&mut self) {
        self.place = self.begin.place;
        self.options = self.begin.options.clone();
    }

    /// The next method, or the one before.
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

    /// More samples, or fewer. They take the place of adaptive ones.
    pub(super) fn step_samples(&mut self, fewer: bool) {
        let above = SAMPLES.partition_point(|samples| *samples <= self.options.samples);
        let next = if fewer { above.saturating_sub(2) } else { above.min(SAMPLES.len() - 1) };
        self.options.adaptive = None;
        self.options.samples = SAMPLES[next];
    }

    /// The next kind of anaglyph.
    pub(super) fn step_anaglyph(&mut self) {
        let all = stereotrace::output::Anaglyph::ALL;
        let at = all.iter().position(|kind| *kind == self.eyes.anaglyph).unwrap_or(0);
        self.eyes.anaglyph = all[(at + 1) % all.len()];
    }
}
