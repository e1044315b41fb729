//! Difference of two views as a picture.

use stereotrace::{View, output::Picture};

/// Draws the difference of two views of one size. Equal pixels show the view in dark grey. Different ones are yellow at
/// one 8-bit step, and redder for larger differences, up to red from 63 steps on.
pub(crate) fn picture(view: &View, truth: &View) -> Picture {
    let shown = |(a, b): (&[u8; 4], &[u8; 4])| {
        let apart = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
        if apart > 0 {
            return [255, 255 - 4 * apart.min(63), 0, 255];
        }
        let grey = b[..3].iter().map(|&channel| u32::from(channel)).sum::<u32>() / 9;
        [grey as u8, grey as u8, grey as u8, 255]
    };
    let rgba8 = view.rgba8.iter().zip(&truth.rgba8).map(shown).collect();
    Picture::new(view.width, view.height, rgba8)
}
