//! Formats text of the page and its plots: counts and days in words, escaped markup, and base64.

pub(super) use crate::common::text::escape;
use crate::record::Record;

/// Returns the first and last day of some records.
pub(super) fn days<'a>(records: impl IntoIterator<Item = &'a &'a Record>) -> String {
    let mut days: Vec<&str> = records.into_iter().map(|r| r.date.split('T').next().unwrap_or(&r.date)).collect();
    days.sort_unstable();
    match (days.first(), days.last()) {
        (Some(first), Some(last)) if first != last => format!("{first} to {last}"),
        (first, _) => first.copied().unwrap_or_default().to_owned(),
    }
}

/// Formats 1234567 and triangle as 1,234,567 triangles.
pub(super) fn count(number: usize, noun: &str) -> String {
    let digits = number.to_string();
    let groups: Vec<_> = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).collect();
    format!("{} {noun}{}", groups.join(","), if number == 1 { "" } else { "s" })
}

/// Encodes bytes as base64 by RFC 4648, with padding.
pub(super) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |index: usize| u32::from(chunk.get(index).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let index = (bits >> (18 - 6 * digit)) & 63;
            text.push(if digit <= chunk.len() { char::from(DIGITS[index as usize]) } else { '=' });
        }
    }
    text
}
