//! 3D buffer of the method `buffer`. It is sized when its depth is known (thesis, 3.1.2).

use crate::{
    BufferDepth, Error, Pose,
    gpu::{Gpu, check_bytes},
};

/// The 3D buffer. Until it is sized for this frame, it is the buffer of the last frame.
pub(super) struct Slots<'a> {
    buffer: &'a mut Option<wgpu::Buffer>,
    /// Size of the part that the current rows use, in bytes.
    bytes: u64,
    /// Largest size in bytes and largest depth of all bands so far.
    most_bytes: u64,
    most_depth: u32,
}

impl<'a> Slots<'a> {
    pub(super) fn new(buffer: &'a mut Option<wgpu::Buffer>) -> Self {
        Self { buffer, bytes: 0, most_bytes: 0, most_depth: 0 }
    }

    pub(super) fn most_bytes(&self) -> u64 {
        self.most_bytes
    }

    pub(super) fn most_depth(&self) -> u32 {
        self.most_depth
    }

    /// Allocates the buffer for up to `rows` rows of pixels, unless it is large enough. Returns the number of rows that
    /// fit one binding, and the buffer.
    ///
    /// # Errors
    /// [`Error::Limit`] if one row does not fit, and [`Error::OutOfMemory`].
    pub(super) async fn size(
        &mut self,
        gpu: &Gpu,
        width: u32,
        rows: u32,
        depth: u32,
    ) -> Result<(u32, &wgpu::Buffer), Error> {
        let row_bytes = u64::from(width) * u64::from(depth) * 4;
        let allowed = gpu.binding_limit();
        check_bytes(&format!("one row of a 3D buffer of depth {depth}"), row_bytes, allowed, "use a smaller depth")?;
        let rows = (allowed / row_bytes).min(u64::from(rows)) as u32;
        self.bytes = u64::from(rows) * row_bytes;
        if self.buffer.as_ref().is_none_or(|slots| slots.size() < self.bytes) {
            // A buffer that is too small is freed before the new one is created.
            self.buffer.take().iter().for_each(wgpu::Buffer::destroy);
            *self.buffer = Some(gpu.checked(|| Ok(gpu.storage_buffer("slots", self.bytes))).await?);
        }
        self.most_bytes = self.most_bytes.max(self.bytes);
        self.most_depth = self.most_depth.max(depth);
        Ok((rows, self.buffer.as_ref().expect("made above")))
    }

    /// Encodes a clear of the part that the current rows use.
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        let slots = self.buffer.as_ref().expect("sized before the step that empties it");
        encoder.clear_buffer(slots, 0, Some(self.bytes));
    }
}

impl BufferDepth {
    /// Returns the number of slots per right pixel for left depths in `[nearest, farthest]`, from 1 to the picture's
    /// width.
    pub(crate) fn slots(self, pose: &Pose, (nearest, farthest): (f32, f32)) -> u32 {
        let depth = match self {
            Self::Fixed(slots) => f64::from(slots.get()),
            Self::TwiceInteraxial => f64::from(2.0 * pose.typical_parallax_px()).ceil(),
            // The landing position X is rounded to f32, which can move two samples closer together by a thousandth of a
            // pixel.
            Self::Adaptive => (lemma1(pose, nearest, farthest) + 1e-3).floor() + 2.0,
        };
        // Depths of 0 make the bound infinite or NaN; `max` turns NaN into 1.
        depth.min(f64::from(pose.size[0])).max(1.0) as u32
    }
}

/// Returns Lemma 1's bound `B = e_px d (1/Z_near - 1/Z_far)`. For parallel cameras `f_px e` replaces `e_px d`. Two left
/// samples in one right column are fewer than `B + 1` columns apart (thesis, Lemma 1, with rounding as in DESIGN,
/// section 2). An infinite farthest depth counts as 1/Z = 0.
pub(crate) fn lemma1(pose: &Pose, nearest: f32, farthest: f32) -> f64 {
    pose.parallax().between(nearest, farthest)
}
