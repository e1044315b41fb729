//! Tidies text from files for messages of the library and of programs that use it. A name in a file must neither
//! control a terminal nor fill it.

use std::fmt::Display;

/// Maximum length of a word. Longer words are cut in the middle, so that the quotation mark and colon at a name's end
/// stay.
const LONGEST_WORD: usize = 80;
/// Number of characters of a cut word behind the cut.
const WORD_END: usize = 8;
/// Maximum length of a text. Longer texts, such as lists of known names, are cut at their end.
const LONGEST_TEXT: usize = 2000;

/// Tidies a text that may quote a file: escapes control characters and cuts long words and very long texts.
pub fn tidy(text: &str) -> String {
    let tidied = escaped(text).split(' ').map(cut_word).collect::<Vec<_>>().join(" ");
    match tidied.char_indices().nth(LONGEST_TEXT) {
        Some((end, _)) => format!("{}…", &tidied[..end]),
        None => tidied,
    }
}

/// Escapes characters that move the cursor or change the writing direction.
pub fn escaped(text: &str) -> String {
    let steers = |c: char| c.is_control() || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let mut result = String::with_capacity(text.len());
    for c in text.chars() {
        if steers(c) { result.extend(c.escape_default()) } else { result.push(c) }
    }
    result
}

/// Formats a number with its noun: `1 triangle`, `2 triangles`.
pub fn counted<N: Copy + Display + PartialEq + From<u8>>(count: N, one: &str, many: &str) -> String {
    format!("{count} {}", noun(count, one, many))
}

/// Returns the noun that agrees with a number.
pub fn noun<'a, N: PartialEq + From<u8>>(count: N, one: &'a str, many: &'a str) -> &'a str {
    if count == N::from(1) { one } else { many }
}

fn cut_word(word: &str) -> String {
    let count = word.chars().count();
    if count <= LONGEST_WORD {
        return word.into();
    }
    let start = word.chars().take(LONGEST_WORD - WORD_END - 1);
    start.chain(['…']).chain(word.chars().skip(count - WORD_END)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_terminal_is_escaped_and_the_rest_stays() {
        assert_eq!(tidy("red\u{1b}[2J\r\n\u{7f}\u{9b}\u{202e}x"), r"red\u{1b}[2J\r\n\u{7f}\u{9b}\u{202e}x");
        let plain = r"C:\models\'é', 日本 – e\u{301} and two  spaces";
        assert_eq!(tidy(plain), plain);
    }

    #[test]
    fn words_over_80_characters_are_cut_and_keep_their_ends() {
        let longest = "é".repeat(80);
        assert_eq!(tidy(&format!("a {longest} b")), format!("a {longest} b"));
        let cut = tidy(&format!("mesh '{}':", "n".repeat(90)));
        assert_eq!(cut, format!("mesh '{}…nnnnnn':", "n".repeat(70)));
        assert_eq!(cut.split(' ').nth(1).unwrap().chars().count(), 80);
        // Escaping comes first, so words of control characters are cut too.
        assert_eq!(tidy(&"\u{1}".repeat(50)).chars().count(), 80);
    }

    #[test]
    fn one_is_singular_and_all_else_plural() {
        let counts = [0, 1, 2, 11].map(|count: usize| counted(count, "vertex", "vertices"));
        assert_eq!(counts, ["0 vertices", "1 vertex", "2 vertices", "11 vertices"]);
    }

    #[test]
    fn texts_of_many_short_words_end() {
        assert_eq!(tidy(&"ab ".repeat(1_000_000)).chars().count(), 2001);
    }
}
