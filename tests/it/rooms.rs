//! Tests that each module of src/ (a room) imports only modules below it.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

use crate::common::files_below;

/// The modules and single files of src/, from the lowest to the highest.
const FLOORS: [&str; 24] = [
    "message",
    "error",
    "random",
    "srgb",
    "ask",
    "view",
    "scene",
    "gpu",
    "import",
    "kernel",
    "accel",
    "frame",
    "steps",
    "t_buffer",
    "shadow_buffer",
    "methods",
    "sampling",
    "render",
    "truth",
    "report",
    "output",
    "dataset",
    "blocking",
    "testing",
];
/// Modules of optional parts, and the modules that may import them: those that make plans and run frames.
const OPTIONAL: [(&str, &[&str]); 2] =
    [("t_buffer", &["shadow_buffer", "methods", "render"]), ("shadow_buffer", &["render", "testing"])];
/// Files above all modules.
const ROOF: [&str; 2] = ["lib", "guide"];

/// Returns a file's text without comments and unit tests.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Returns the first word of each entry between an opening brace and the matching closing brace.
fn entries(text: &str) -> Vec<&str> {
    let (mut depth, mut begin, mut found) = (0, 1, Vec::new());
    for (at, letter) in text.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if (letter == ',' && depth == 1) || depth == 0 {
            found.push(first_word(text[begin..at].trim()));
            begin = at + 1;
        }
        if depth == 0 {
            break;
        }
    }
    found.retain(|word| !word.is_empty());
    found
}

fn first_word(text: &str) -> &str {
    let end = text.find(|letter: char| !letter.is_alphanumeric() && letter != '_');
    &text[..end.unwrap_or(text.len())]
}

/// Returns the words after `crate::` in a text.
fn imports(text: &str) -> BTreeSet<&str> {
    let after = text.match_indices("crate::").map(|(at, found)| &text[at + found.len()..]);
    after.flat_map(|rest| if rest.starts_with('{') { entries(rest) } else { vec![first_word(rest)] }).collect()
}

/// Returns the room of each name that the crate's root exports.
fn exports(root: &str) -> BTreeMap<&str, &str> {
    let mut rooms = BTreeMap::new();
    for statement in root.split("pub use ").skip(1) {
        let statement = statement.split(';').next().unwrap_or_default();
        let words = statement.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
        rooms.extend(words.filter(|word| !word.is_empty()).map(|word| (word, first_word(statement))));
    }
    rooms
}

#[test]
fn no_room_imports_a_room_above_it() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let root = code(&src.join("lib.rs"));
    let exports = exports(&root);
    let floor = |room: &str| FLOORS.iter().position(|other| *other == room);
    let mut seen = 0;
    for path in files_below(&src, &["rs"]) {
        let inside = path.strip_prefix(&src).unwrap();
        let names: Vec<_> = inside.iter().map(|name| name.to_str().unwrap().trim_end_matches(".rs")).collect();
        if ROOF.contains(&names[0]) || names.contains(&"tests") {
            continue;
        }
        let own = floor(names[0]).unwrap_or_else(|| panic!("no floor has {}", names[0]));
        let text = code(&path);
        for word in imports(&text) {
            let room = if floor(word).is_some() { word } else { exports.get(word).copied().unwrap_or(word) };
            let importers = OPTIONAL.iter().find(|(optional, _)| *optional == room).map(|(_, importers)| importers);
            if let Some(importers) = importers.filter(|_| room != names[0] && room == word) {
                assert!(importers.contains(&names[0]), "{} imports {room}", inside.display());
            }
            match floor(room) {
                Some(other) => {
                    assert!(other <= own, "{} imports {word} of {room}, which is above it", inside.display())
                }
                None => assert!(["glam", "wgpu"].contains(&word), "{}: whose is {word}?", inside.display()),
            }
            seen += 1;
        }
    }
    assert!(seen > 500, "{seen}");
}
