//! Measures flicker: errors that come and go from frame to frame. Viewers notice them sooner than lasting errors.

/// Tracks a method's errors through a film.
#[derive(Default)]
pub struct Flicker {
    /// Wrong pixels of the previous frame; empty before the first frame.
    wrong: Vec<bool>,
    /// Sum of the percentages of pixels that changed.
    sum: f64,
    /// Number of frames that had a previous frame.
    count: usize,
}

impl Flicker {
    /// Adds the next frame and its true picture, of the same size as the previous ones. Any difference in 8-bit colour
    /// is an error; alpha does not count.
    pub fn add(&mut self, picture: &[[u8; 4]], truth: &[[u8; 4]]) {
        let wrong: Vec<bool> = picture.iter().zip(truth).map(|(a, b)| a[..3] != b[..3]).collect();
        if !self.wrong.is_empty() {
            let changed = wrong.iter().zip(&self.wrong).filter(|(now, before)| now != before).count();
            self.sum += 100.0 * changed as f64 / wrong.len() as f64;
            self.count += 1;
        }
        self.wrong = wrong;
    }

    /// Returns the percentage of pixels that are wrong in exactly one of two successive frames, averaged over all
    /// frames but the first. Returns `None` before the second frame.
    pub fn percent(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}
