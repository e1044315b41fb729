//! What the command lines share.

/// A picture size, as 600x400.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let numbers = text.split_once('x').map(|(width, height)| [width.parse(), height.parse()]);
    match numbers {
        Some([Ok(width), Ok(height)]) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("give width and height, as 600x400".into()),
    }
}
