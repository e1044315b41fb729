//! Parses parts of the command lines that benchmarks share.

/// Parses a picture size such as 600x400.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let numbers = text.split_once('x').map(|(width, height)| [width.parse(), height.parse()]);
    match numbers {
        Some([Ok(width), Ok(height)]) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("give width and height, as 600x400".into()),
    }
}

/// Returns whether this is a smoke run: `--smoke` was given, or the benchmark runs as a test. Cargo passes `--bench`
/// only when it benchmarks.
pub fn is_quick() -> bool {
    let is_given = |name: &str| std::env::args().any(|argument| argument == name);
    is_given("--smoke") || !is_given("--bench")
}

/// Returns the scenes named on the command line. The default is `usual`, and the hall in smoke runs.
pub fn scenes_named(usual: &[&str]) -> Vec<String> {
    let named: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let usual = if is_quick() { &["hall"] } else { usual };
    if named.is_empty() { usual.iter().map(|&name| name.to_owned()).collect() } else { named }
}
