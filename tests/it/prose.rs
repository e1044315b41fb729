//! Tests the text of code and documents: the length of lines, the names of files, and the words of a glossary.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use crate::common::files_below;

/// Maximum length of a line of code, comments and pages, in characters.
const LONGEST: usize = 120;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the files with these extensions in the repository's folders of sources and pages.
fn files(endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for folder in ["benches", "cli", "docs", "examples", "python", "shaders", "src", "studies", "tests", "web"] {
        found.extend(files_below(&root().join(folder), endings));
    }
    for page in ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md"] {
        if endings.contains(&"md") {
            found.push(root().join(page));
        }
    }
    found
}

fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

/// Returns whether a line may be longer, such as a row of a table or text without a space to break at.
fn may_be_long(line: &str) -> bool {
    let text = line.trim_start_matches(['/', '!', ' ', '#', '*', '-', '>']);
    text.starts_with('|') || line.contains("http") || !text.trim_end().contains(' ')
}

#[test]
fn lines_are_at_most_120_characters_long() {
    let mut long = Vec::new();
    for path in files(&["rs", "wgsl", "md", "py"]) {
        let text = fs::read_to_string(&path).unwrap();
        let too_long = |line: &&str| line.chars().count() > LONGEST && !may_be_long(line);
        long.extend(text.lines().filter(too_long).map(|line| format!("{}: {line}", shown(&path))));
    }
    assert!(long.is_empty(), "{} lines:\n{}", long.len(), long.join("\n"));
}

/// Returns the words of a text that name files of the repository by their path.
fn named_files(text: &str) -> BTreeSet<&str> {
    let words = text.split(|letter: char| !letter.is_ascii_alphanumeric() && !"/._-*".contains(letter));
    let begins = ["src/", "shaders/", "tests/", "benches/", "studies/", "docs/", "examples/", "scripts/", "cli/"];
    let ends = [".rs", ".wgsl", ".md", ".sh", ".py"];
    let is_file =
        |word: &&str| begins.iter().any(|begin| word.starts_with(begin)) && ends.iter().any(|end| word.ends_with(end));
    words.map(|word| word.trim_end_matches('.')).filter(|word| !word.contains('*')).filter(is_file).collect()
}

#[test]
fn files_that_pages_and_comments_name_are_there() {
    let mut missing = Vec::new();
    for path in files(&["rs", "wgsl", "md"]) {
        let package = ["cli", "python", "web", "studies"].iter().find(|folder| path.starts_with(root().join(folder)));
        let text = fs::read_to_string(&path).unwrap();
        for name in named_files(&text) {
            let of_package = package.is_some_and(|folder| root().join(folder).join(name).exists());
            if !root().join(name).exists() && !of_package {
                missing.push(format!("{} names {name}", shown(&path)));
            }
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

/// Returns the anchors of a page's headings, as GitHub makes them.
fn anchors(page: &str) -> BTreeSet<String> {
    let mut in_code = false;
    let mut found = BTreeSet::new();
    for line in page.lines() {
        in_code ^= line.trim_start().starts_with("```");
        if let Some(heading) = line.strip_prefix('#').filter(|_| !in_code) {
            let heading = heading.trim_start_matches('#').trim().to_lowercase();
            let kept = heading.chars().filter(|letter| letter.is_alphanumeric() || " -_".contains(*letter));
            found.insert(kept.collect::<String>().replace(' ', "-"));
        }
    }
    found
}

#[test]
fn links_of_pages_resolve() {
    let mut broken = Vec::new();
    for path in files(&["md"]) {
        let text = fs::read_to_string(&path).unwrap();
        for (at, _) in text.match_indices("](") {
            let link = text[at + 2..].split(')').next().unwrap_or_default();
            if link.contains("://") || link.starts_with("mailto:") || link.contains(char::is_whitespace) {
                continue;
            }
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            let has_anchor = || anchors(&fs::read_to_string(&target).unwrap_or_default()).contains(anchor);
            let is_page = target.extension().is_some_and(|ending| ending == "md");
            if !target.exists() || (is_page && !anchor.is_empty() && !has_anchor()) {
                broken.push(format!("{}: {link}", shown(&path)));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Words of a private dialect, each with the words that the field uses.
const GLOSSARY: [(&str, &str); 12] = [
    ("put off as", "deferred"),
    ("taken over from", "reused from"),
    ("takes over from", "reuses"),
    ("What is doubtful", "uncertain hits"),
    ("stands aside of", "is offset from"),
    ("as so many", "as many"),
    ("of the same kind as ever", "as before"),
    ("it is told by", "it follows from"),
    ("what flatters", "automatic settings"),
    ("are asked anew", "are traced again"),
    ("the house", "the code"),
    ("is vouched for", "is confirmed"),
];

#[test]
fn pages_and_help_use_words_of_the_field() {
    let mut found = Vec::new();
    for path in files(&["rs", "wgsl", "md", "py"]).iter().filter(|path| !path.ends_with("tests/it/prose.rs")) {
        let text = fs::read_to_string(path).unwrap();
        for (line, number) in text.lines().zip(1..) {
            let words = GLOSSARY.iter().filter(|(words, _)| line.contains(words));
            found.extend(words.map(|(words, better)| format!("{}:{number}: '{words}', better: {better}", shown(path))));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_long_line_a_missing_file_and_a_broken_anchor_are_seen() {
    assert!(!may_be_long("let a = 1;") && may_be_long("| a | b |") && may_be_long("// https://example.org/a b"));
    assert_eq!(
        named_files("see src/lib.rs, (docs/DESIGN.md). lib.rs"),
        BTreeSet::from(["src/lib.rs", "docs/DESIGN.md"])
    );
    assert!(anchors("# A head, two\n```\n# code\n```\n## 3. Last").contains("a-head-two"));
    assert_eq!(anchors("# A\n```\n# code\n```\n## 3. Last"), BTreeSet::from(["a".into(), "3-last".into()]));
}
