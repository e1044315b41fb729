//! Bands: rows of a picture that are rendered together.

use std::ops::Range;

use crate::{Gpu, kernel::layout};

/// The number of rows of a band is a multiple of this, except in the last band. A band then consists of whole
/// workgroups of the search of tiles.
const WHOLE: u32 = layout::WORKGROUP * layout::TILE;

/// Number of rows kept above and below a band for steps that read neighbouring rows. Steps read fewer rows; the others
/// keep tiles whole.
const HALO: u32 = layout::TILE;

/// Maximum number of pixels of all views of a band: 64 MiB. Bands with the minimum number of rows may have more.
const VIEWS_PIXELS: u32 = 1 << 22;

/// Returns the number of rows that buffers of the smallest bands of a picture have, at most.
pub(crate) fn fewest_rows(height: u32) -> u32 {
    if height <= WHOLE { height } else { WHOLE + 2 * HALO }
}

/// Approximate number of rays per pixel of a submission, by which bands are sized. More lights reduce the pixels.
pub(crate) const RAYS_PER_PIXEL: u32 = 6;

/// Time that a submission to a GPU may take by its measured time of a ray, in seconds. A watchdog ends submissions of
/// two seconds or more, and scenes are several times as slow as those that are measured.
const SUBMISSION_SECONDS: f32 = 0.25;

/// Returns the approximate number of pixels of a band, for [`RAYS_PER_PIXEL`] rays of both eyes. On a software adapter
/// this number corresponds to about 1.5 million rays per eye. A GPU needs work for thousands of threads, but its
/// watchdog ends a submission after a second or more. A GPU with slow rays gets smaller bands, if they are measured.
pub(crate) fn band_pixels(gpu: &Gpu, ray_seconds: f32) -> u32 {
    match gpu.adapter_info().device_type {
        wgpu::DeviceType::Cpu => 1 << 18,
        _ => gpu_band_pixels(ray_seconds),
    }
}

fn gpu_band_pixels(ray_seconds: f32) -> u32 {
    let seconds_per_pixel = ray_seconds * 2.0 * RAYS_PER_PIXEL as f32;
    // The cast of an infinite number, for rays without a measured time, is the largest number. A time that is no number
    // counts as none.
    let pixels = if seconds_per_pixel > 0.0 { SUBMISSION_SECONDS / seconds_per_pixel } else { f32::INFINITY };
    (pixels as u32).clamp(1 << 14, 1 << 21)
}

/// Maximum size of the buffers in which the results of bands wait for the host. There are always two.
pub(crate) fn read_back_bytes(gpu: &Gpu) -> u64 {
    match gpu.adapter_info().device_type {
        wgpu::DeviceType::Cpu => 0,
        _ => 1 << 28,
    }
}

/// Division of a picture's rows into bands. Rows are epipolar lines of every pair of views (DESIGN, section 2). So all
/// steps of a band can run before the next band. Data between steps take the memory of one band, for any size of
/// picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Bands {
    height: u32,
    /// Number of rows of a band. The last band may have fewer.
    pub(crate) rows: u32,
    /// Number of rows kept above and below a band.
    halo: u32,
}

/// One band, in rows of the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Band {
    pub(crate) rows: Range<u32>,
    /// Rows of the band, and the rows above and below it that some step reads.
    pub(crate) seen: Range<u32>,
    /// Picture row of the buffers' first row.
    pub(crate) first: u32,
}

impl Bands {
    /// Creates bands of about `pixels` pixels for this many views. `reaches` says whether a step reads the rows above
    /// and below.
    pub(crate) fn new([width, height]: [u32; 2], pixels: u32, views: usize, reaches: bool) -> Self {
        let pixels = pixels.min(VIEWS_PIXELS / u32::try_from(views).unwrap_or(u32::MAX).max(1));
        let most = (pixels / width).max(WHOLE);
        let alike = height.div_ceil(height.div_ceil(most));
        let rows = if height <= most { height } else { alike.next_multiple_of(WHOLE).min(height) };
        Self { height, rows, halo: if reaches && rows < height { HALO } else { 0 } }
    }

    /// Returns the next smaller number of rows of a band, or `None` for the smallest bands.
    pub(crate) fn fewer_rows(self) -> Option<u32> {
        (self.rows > WHOLE).then(|| (self.rows - 1) / WHOLE * WHOLE)
    }

    pub(crate) fn count(self) -> u32 {
        self.height.div_ceil(self.rows)
    }

    /// Returns the number of rows of all bands.
    pub(crate) fn height(self) -> u32 {
        self.height
    }

    /// Returns the number of rows of a frame's buffers.
    pub(crate) fn rows_kept(self) -> u32 {
        self.rows + 2 * self.halo
    }

    pub(crate) fn get(self, index: u32) -> Band {
        let begin = index * self.rows;
        let end = self.height.min(begin + self.rows);
        // Two rows above the band are needed, since the four rays of a lane take two rows, which stay together.
        let (above, below) = (self.halo.min(2), self.halo.min(1));
        Band {
            rows: begin..end,
            seen: begin.saturating_sub(above)..self.height.min(end + below),
            first: begin.saturating_sub(self.halo),
        }
    }
}

impl Band {
    /// Moves the band down, for a picture whose bands begin at row `top`.
    pub(crate) fn moved_down(self, top: u32) -> Self {
        let moved = |rows: Range<u32>| rows.start + top..rows.end + top;
        Self { rows: moved(self.rows), seen: moved(self.seen), first: self.first + top }
    }

    /// Returns the band's rows, counted from the first row of the buffers.
    pub(crate) fn place(&self) -> Range<u32> {
        self.rows.start - self.first..self.rows.end - self.first
    }

    pub(crate) fn count(&self) -> u32 {
        self.rows.end - self.rows.start
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_of_a_gpu_takes_a_quarter_of_a_second_by_its_measured_rays_at_most() {
        for unmeasured in [0.0, -1.0, f32::NAN, 1e-9, 9e-9] {
            assert_eq!(gpu_band_pixels(unmeasured), 1 << 21, "{unmeasured}");
        }
        for ray in [2e-8, 1e-7, 1e-6] {
            let seconds = gpu_band_pixels(ray) as f32 * ray * 2.0 * RAYS_PER_PIXEL as f32;
            assert!((0.24..=0.25).contains(&seconds), "{ray}: {seconds}");
        }
        assert_eq!([1.0, f32::INFINITY].map(gpu_band_pixels), [1 << 14; 2]);
    }

    #[test]
    fn bands_are_whole_workgroups_and_cover_a_picture_once() {
        for size in [[1, 1], [63, 65], [1280, 720], [3840, 2160], [100_000, 7], [7, 100_000], [16384, 16384]] {
            for (views, reaches) in [(1, true), (2, false), (45, true), (1024, false)] {
                let bands = Bands::new(size, 1 << 18, views, reaches);
                let mut next = 0;
                for band in (0..bands.count()).map(|index| bands.get(index)) {
                    assert_eq!(band.rows.start, next);
                    next = band.rows.end;
                    assert!(band.count() % WHOLE == 0 || next == size[1], "{size:?} {band:?}");
                    assert!(
                        band.place().start % layout::TILE == 0 && band.first <= band.seen.start,
                        "{size:?} {band:?}"
                    );
                    assert!(band.seen.end - band.first <= bands.rows_kept(), "{size:?} {band:?}");
                    let looks = u32::from(reaches && bands.count() > 1);
                    assert_eq!(band.seen.start, band.rows.start.saturating_sub(2 * looks));
                    assert_eq!(band.seen.end, size[1].min(next + looks));
                }
                assert_eq!(next, size[1]);
            }
        }
        assert_eq!(Bands::new([1200, 1200], 1 << 18, 2, false).rows, 256);
        assert_eq!(Bands::new([16384, 8192], 1 << 18, 2, false).rows, 64);
    }
}
