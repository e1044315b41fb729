//! Flicker: errors that come and go from frame to frame, which an eye notices sooner than errors that stay.

/// Follows a method's errors through a film.
#[derive(Default)]
pub(crate) struct Flicker {
    /// Which pixels of the last frame are wrong; empty before the first one.
    wrong: Vec<bool>,
    /// Sum of the shares that changed, percent.
    sum: f64,
    /// How many frames had one before them.
    count: usize,
}

impl Flicker {
    /// The next frame and its true picture, of the same size as those before. Any difference in 8-bit colour is an
    /// error; alpha is no colour.
    pub(crate) fn add(&mut self, picture: &[[u8; 4]], truth: &[[u8; 4]]) {
        let wrong: Vec<bool> = picture.iter().zip(truth).map(|(a, b)| a[..3] != b[..3]).collect();
        if !self.wrong.is_empty() {
            let changed = wrong.iter().zip(&self.wrong).filter(|(now, before)| now != before).count();
            self.sum += 100.0 * changed as f64 / wrong.len() as f64;
            self.count += 1;
        }
        self.wrong = wrong;
    }

    /// The pixels that are wrong in exactly one of two successive frames: percent of the picture, mean of all frames
    /// but the first. `None` before the second frame.
    pub(crate) fn percent(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}
