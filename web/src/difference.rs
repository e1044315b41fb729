//! The difference of two views as a picture.

use stereotrace::{View, output::Picture};

/// What is alike is grey and dark, as a view to go by. What differs is yellow where a channel is a step of 255 apart,
/// and redder the more it is: red from 64 steps on. Views of one size.
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
