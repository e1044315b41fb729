//! Draws the text over the picture on the host with a bitmap font.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use stereotrace::output::Picture;

const TEXT: [u8; 4] = [240, 240, 240, 255];
const GROUND: [u8; 4] = [0, 0, 0, 92];
/// Margin around the text, in widths of a character.
const MARGIN: usize = 1;

/// Draws text in one font size.
pub(super) struct Panel {
    size: RasterHeight,
}

impl Panel {
    /// Chooses the font size for a display's scale factor.
    pub(super) fn new(scale: f64) -> Self {
        let size = match scale {
            scale if scale < 1.25 => RasterHeight::Size16,
            scale if scale < 1.75 => RasterHeight::Size24,
            _ => RasterHeight::Size32,
        };
        Self { size }
    }

    /// Draws lines of text. Lines are broken at the width of the window, and cut at its height.
    pub(super) fn picture(&self, lines: &[String], [width, height]: [u32; 2]) -> Picture {
        let (w, h) = (get_raster_width(FontWeight::Regular, self.size), self.size.val());
        let margin = MARGIN * w;
        let columns = (width as usize).saturating_sub(2 * margin) / w;
        let rows = (height as usize).saturating_sub(2 * margin) / h;
        let mut lines: Vec<Vec<char>> = lines.iter().flat_map(|line| broken(line, columns)).collect();
        lines.truncate(rows);
        let longest = lines.iter().map(Vec::len).max().unwrap_or(0);
        if longest == 0 {
            return Picture::new(1, 1, vec![[0; 4]]);
        }
        let size = [longest * w + 2 * margin, lines.len() * h + 2 * margin];
        let mut pixels = vec![GROUND; size[0] * size[1]];
        for (row, line) in lines.iter().enumerate() {
            for (column, character) in line.iter().enumerate() {
                let corner = (margin + row * h) * size[0] + margin + column * w;
                self.draw(*character, &mut pixels[corner..], size[0]);
            }
        }
        Picture::new(size[0] as u32, size[1] as u32, pixels)
    }

    /// Draws a character with its top left corner at the first pixel. `stride` is the length of a row in pixels.
    fn draw(&self, character: char, pixels: &mut [[u8; 4]], stride: usize) {
        let raster = |character| get_raster(character, FontWeight::Regular, self.size);
        let Some(raster) = raster(character).or_else(|| raster('?')) else { return };
        for (y, row) in raster.rows().enumerate() {
            for (x, share) in row.iter().enumerate() {
                pixels[y * stride + x] = between(GROUND, TEXT, *share);
            }
        }
    }
}

/// Interpolates two colours; `share` is 0 to 255.
fn between(from: [u8; 4], to: [u8; 4], share: u8) -> [u8; 4] {
    let mixed = |a: u8, b: u8| (u32::from(a) * (255 - u32::from(share)) + u32::from(b) * u32::from(share)) / 255;
    [0, 1, 2, 3].map(|channel| mixed(from[channel], to[channel]) as u8)
}

/// Breaks a line into parts of at most this many columns, at spaces if possible. Later parts are indented.
fn broken(line: &str, columns: usize) -> Vec<Vec<char>> {
    const INDENT: usize = 2;
    if columns <= 2 * INDENT {
        return Vec::new();
    }
    let mut rest = Vec::from_iter(line.chars());
    let mut parts = Vec::new();
    while rest.len() > columns {
        let space = rest[..=columns].iter().rposition(|c| *c == ' ').filter(|at| *at > INDENT);
        let tail = rest.split_off(space.unwrap_or(columns));
        parts.push(rest);
        rest = vec![' '; INDENT];
        rest.extend(tail.into_iter().skip_while(|c| *c == ' '));
    }
    parts.push(rest);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strings(line: &str, columns: usize) -> Vec<String> {
        broken(line, columns).into_iter().map(String::from_iter).collect()
    }

    #[test]
    fn lines_are_broken_at_spaces_and_long_words_anywhere() {
        assert_eq!(strings("one two three", 9), ["one two", "  three"]);
        assert_eq!(strings("one two three", 13), ["one two three"]);
        assert_eq!(strings("abcdefghijkl", 6), ["abcdef", "  ghij", "  kl"]);
        assert_eq!(strings("", 6), [""]);
        assert!(strings("one", 4).is_empty());
        assert_eq!(strings("              x", 6).last().unwrap(), "  x");
    }

    #[test]
    fn text_is_drawn_and_fits_its_window() {
        let lines = ["parallax ← é \u{10ffff}".to_owned(), "x".repeat(500)];
        for scale in [1.0, 1.5, 2.0] {
            let panel = Panel::new(scale);
            for size in [[300, 200], [60, 30], [7, 7], [1, 1], [0, 0]] {
                let Picture { width, height, rgba8, .. } = panel.picture(&lines, size);
                assert!(width <= size[0].max(1) && height <= size[1].max(1), "{width}x{height} in {size:?}");
                assert_eq!(rgba8.len(), (width * height) as usize);
            }
            let shown = panel.picture(&lines[..1], [900, 100]);
            assert!(shown.rgba8.contains(&TEXT) && shown.rgba8.contains(&GROUND));
        }
    }

    #[test]
    fn every_line_of_help_has_its_characters() {
        for (key, does) in super::super::keys::HELP {
            for scale in [1.0, 1.5, 2.0] {
                let panel = Panel::new(scale);
                for character in key.chars().chain(does.chars()) {
                    let raster = get_raster(character, FontWeight::Regular, panel.size);
                    assert!(raster.is_some(), "{character} at {scale}");
                }
            }
        }
    }
}
