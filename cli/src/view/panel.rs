//! Draws the text over the picture on the host with a bitmap font.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use stereotrace::output::Picture;

const TEXT: [u8; 4] = [240, 240, 240, 255];
const GROUND: [u8; 4] = [0, 0, 0, 92];
/// Margin around the text, in widths of a character.
const MARGIN: usize = 1;

/// Rows of characters.
type Rows = Vec<Vec<char>>;

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

    /// Lays out texts one after the other, in few rows of a window of this size.
    pub(super) fn strip(&self, texts: &[String], window: [u32; 2]) -> Rows {
        let [columns, most] = self.fitting(window);
        let mut lines: Vec<String> = Vec::new();
        for text in texts {
            let joined = lines.last().map(|line| format!("{line} | {text}"));
            let joined = joined.filter(|joined| joined.chars().count() <= columns);
            if joined.is_some() {
                lines.pop();
            }
            lines.push(joined.unwrap_or_else(|| text.clone()));
        }
        let mut rows = Vec::from_iter(lines.iter().flat_map(|line| broken(line, columns)));
        rows.truncate(most);
        rows
    }

    /// Lays out lines in as few pages as a window of this size takes. Each of several ends with `more` and its number.
    pub(super) fn pages(&self, lines: &[String], more: &str, window: [u32; 2]) -> Vec<Rows> {
        let [columns, most] = self.fitting(window);
        let rows = Vec::from_iter(lines.iter().flat_map(|line| broken(line, columns)));
        if rows.len() <= most || most < 2 {
            return vec![rows.into_iter().take(most).collect()];
        }
        let mut pages = Vec::from_iter(rows.chunks(most - 1).map(<[_]>::to_vec));
        let last = pages.len();
        for (index, page) in pages.iter_mut().enumerate() {
            page.extend(broken(&format!("{more} ({} of {last})", index + 1), columns).into_iter().take(1));
        }
        pages
    }

    /// Returns how many columns and rows of text a window of this size has.
    fn fitting(&self, window: [u32; 2]) -> [usize; 2] {
        let margins = 2 * MARGIN * get_raster_width(FontWeight::Regular, self.size);
        let [width, height] = window.map(|side| (side as usize).saturating_sub(margins));
        [width / get_raster_width(FontWeight::Regular, self.size), height / self.size.val()]
    }

    /// Draws rows of text.
    pub(super) fn picture(&self, lines: &Rows) -> Picture {
        let (w, h) = (get_raster_width(FontWeight::Regular, self.size), self.size.val());
        let margin = MARGIN * w;
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
                let mut laid_out = panel.pages(&lines, "more", size);
                laid_out.push(panel.strip(&lines, size));
                for rows in laid_out {
                    let Picture { width, height, rgba8, .. } = panel.picture(&rows);
                    assert!(width <= size[0].max(1) && height <= size[1].max(1), "{width}x{height} in {size:?}");
                    assert_eq!(rgba8.len(), (width * height) as usize);
                }
            }
            let shown = panel.picture(&panel.strip(&lines[..1], [900, 100]));
            assert!(shown.rgba8.contains(&TEXT) && shown.rgba8.contains(&GROUND));
        }
    }

    #[test]
    fn a_strip_has_few_rows_and_pages_have_all_lines() {
        let panel = Panel::new(1.0);
        let text = |rows: &Rows| Vec::from_iter(rows.iter().map(String::from_iter));
        let texts = ["one", "two", "three"].map(str::to_owned);
        // A window with room for so many columns and rows.
        let room = |columns: usize, rows: usize| {
            let (w, h) = (get_raster_width(FontWeight::Regular, panel.size), panel.size.val());
            [w * (columns + 2 * MARGIN), 2 * MARGIN * w + h * rows].map(|side| side as u32)
        };
        assert_eq!(text(&panel.strip(&texts, room(17, 9))), ["one | two | three"]);
        assert_eq!(text(&panel.strip(&texts, room(16, 9))), ["one | two", "three"]);
        assert_eq!(text(&panel.strip(&texts, room(16, 1))), ["one | two"]);
        let pages = |rows| Vec::from_iter(panel.pages(&texts, "H: more", room(20, rows)).iter().map(text));
        assert_eq!(pages(3), [texts.to_vec()]);
        let more = |line: &str, page| vec![line.to_owned(), format!("H: more ({page} of 3)")];
        assert_eq!(pages(2), [more("one", 1), more("two", 2), more("three", 3)]);
        assert_eq!(pages(1), [["one"]]);
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
