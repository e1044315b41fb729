//! What the command lines share.

/// A picture size, as 600x400.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let numbers = text.split_once('x').map(|(width, height)| [width.parse(), height.parse()]);
    match numbers {
        Some([Ok(width), Ok(height)]) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("give width and height, as 600x400".into()),
    }
}

/// Whether it is a quick look: asked for by `--smoke`, or run as a test; cargo says so when it benchmarks.
pub fn is_quick() -> bool {
    let is_given = |name: &str| std::env::args().any(|argument| argument == name);
    is_given("--smoke") || !is_given("--bench")
}

/// The scenes that are named on the command line, or else the usual ones; for a quick look the hall.
pub fn scenes_named(usual: &[&str]) -> Vec<String> {
    let named: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let usual = if is_quick() { &["hall"] } else { usual };
    if named.is_empty() { usual.iter().map(|&name| name.to_owned()).collect() } else { named }
}
