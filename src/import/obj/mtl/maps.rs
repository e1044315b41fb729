//! Parses statements that name texture files.

use glam::{Vec2, Vec3};

use crate::import::warnings::Warnings;

/// Property of a surface that a texture sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    Color,
    CutOut,
    Roughness,
    Metallic,
    Emission,
    Normal,
}

impl Use {
    /// The statements that name textures, and what these are for.
    pub(super) const ALL: [(&str, Self); 8] = [
        ("map_Kd", Self::Color),
        ("map_d", Self::CutOut),
        ("map_Pr", Self::Roughness),
        ("map_Pm", Self::Metallic),
        ("map_Ke", Self::Emission),
        ("norm", Self::Normal),
        ("map_Bump", Self::Normal),
        ("map_bump", Self::Normal),
    ];

    /// Returns the statement of this keyword and its use.
    pub(super) fn named(keyword: &str) -> Option<(&'static str, Self)> {
        Self::ALL.into_iter().find(|(name, _)| *name == keyword)
    }

    /// Returns whether the picture's values are data rather than colours.
    #[cfg_attr(not(feature = "textures"), allow(dead_code, reason = "textures are not read"))]
    pub(super) fn is_data(self) -> bool {
        matches!(self, Self::Roughness | Self::Metallic | Self::Normal)
    }
}

/// A statement that names a texture.
pub(super) struct Map {
    pub(super) keyword: &'static str,
    pub(super) purpose: Use,
    pub(super) line: usize,
    /// Name of the file, as written.
    pub(super) name: String,
    #[cfg_attr(not(feature = "textures"), allow(dead_code, reason = "textures are not read"))]
    pub(super) clamp: bool,
    pub(super) placement: Placement,
}

/// Map from texture coordinates to the texture: scale first, then offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::import::obj) struct Placement {
    scale: Vec2,
    offset: Vec2,
}

impl Default for Placement {
    fn default() -> Self {
        Self { scale: Vec2::ONE, offset: Vec2::ZERO }
    }
}

impl Placement {
    /// Returns the texture coordinates of a surface point in the picture.
    pub(in crate::import::obj) fn place(&self, uv: Vec2) -> Vec2 {
        uv * self.scale + self.offset
    }
}

/// Parses a statement's options and the file name behind them, which may have spaces; `None` without a name.
pub(super) fn parse_map(
    (keyword, purpose): (&'static str, Use),
    words: &str,
    line: usize,
    warnings: &mut Warnings,
) -> Option<Map> {
    let (mut clamp, mut placement) = (false, Placement::default());
    let mut rest = words.trim();
    loop {
        let (option, after) = split_word(rest);
        match option {
            "-clamp" => {
                let (word, after) = split_word(after);
                (clamp, rest) = (word == "on", after);
            }
            "-s" => {
                let (numbers, after) = take_numbers(after, Vec3::ONE);
                (placement.scale, rest) = (numbers.truncate(), after);
            }
            "-o" => {
                let (numbers, after) = take_numbers(after, Vec3::ZERO);
                (placement.offset, rest) = (numbers.truncate(), after);
            }
            "-t" => rest = take_numbers(after, Vec3::ZERO).1,
            "-mm" => rest = split_word(split_word(after).1).1,
            "-blendu" | "-blendv" | "-bm" | "-boost" | "-cc" | "-imfchan" | "-texres" | "-type" => {
                rest = split_word(after).1;
            }
            _ => break,
        }
        if matches!(option, "-t" | "-mm" | "-cc" | "-imfchan") {
            warnings.left_out("options of textures (-t, -mm, -cc, -imfchan)", line);
        }
    }
    (!rest.is_empty()).then(|| Map { keyword, purpose, line, name: rest.into(), clamp, placement })
}

fn split_word(words: &str) -> (&str, &str) {
    let (word, rest) = words.split_once(char::is_whitespace).unwrap_or((words, ""));
    (word, rest.trim_start())
}

/// Parses up to three numbers and returns the rest. The last word is a file name, even if it is a number.
fn take_numbers(words: &str, otherwise: Vec3) -> (Vec3, &str) {
    let (mut numbers, mut rest) = (otherwise, words);
    for axis in 0..3 {
        let (word, after) = split_word(rest);
        match word.parse().ok().filter(|value: &f32| value.is_finite() && !after.is_empty()) {
            Some(value) => (numbers[axis], rest) = (value, after),
            None => break,
        }
    }
    (numbers, rest)
}
