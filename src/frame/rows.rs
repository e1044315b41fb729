//! Rows of views, delivered as they finish.

use super::targets::{MOST_BYTES, too_large};
use crate::{
    Error, GBuffer, Options, PixelSource, ShadowSource, View,
    kernel::layout::{LightParts, Noisy},
    message::counted,
    view::rig::Eyes,
};

/// Callback that receives rows as they finish. Except on wasm32, it is `Send`, so that its frame can move to another
/// thread.
#[cfg(not(target_arch = "wasm32"))]
pub type OnRows<'a> = dyn FnMut(Rows) -> Result<(), Error> + Send + 'a;

/// Callback that receives rows as they finish.
#[cfg(target_arch = "wasm32")]
pub type OnRows<'a> = dyn FnMut(Rows) -> Result<(), Error> + 'a;

/// Rows of all views of a frame, delivered as they finish: see [`FrameBuilder::rows`](crate::FrameBuilder::rows).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rows {
    /// Picture row of the first of these rows.
    pub first: u32,
    /// Rows of each eye's view, in the rig's order.
    pub views: Vec<ViewRows>,
}

/// Rows of a view, and how their pixels were made.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ViewRows {
    /// The picture; its height is the number of rows.
    pub view: View,
    /// How each pixel was made, row-major.
    pub source: Vec<PixelSource>,
    /// How each pixel's visibility bits were determined, row-major. Empty except for `bracket`.
    pub shadow_source: Vec<ShadowSource>,
    /// Light of each pixel in parts, row-major; empty unless it is denoised or the albedo is kept.
    pub(crate) parts: Vec<LightParts>,
}

impl ViewRows {
    /// Returns an empty list of rows.
    pub(crate) fn new(width: u32) -> Self {
        let view = View::of_pixels(width, Vec::new());
        Self { view, source: Vec::new(), shadow_source: Vec::new(), parts: Vec::new() }
    }

    /// Returns empty lists with capacity for all rows of each view.
    ///
    /// # Errors
    /// [`Error::Limit`] if they do not fit into memory.
    pub(crate) fn with_room(eyes: &Eyes, options: &Options) -> Result<Vec<Self>, Error> {
        let [width, height] = eyes.pose.size;
        let pixels = u64::from(width) * u64::from(height);
        let (depth, ids) = (options.g_buffer != GBuffer::None, options.g_buffer == GBuffer::Ids);
        // Light in parts, denoised light, and the colours made of it.
        let denoised = (size_of::<LightParts>() + size_of::<Noisy>() + size_of::<[f32; 3]>()) as u64;
        // The sizes are bytes per pixel: 6 for colour and sources, then the requested parts.
        let each: u64 = [
            (true, 6),
            (depth, 4),
            (ids, 8),
            (options.linear, 16),
            (options.cost_map, 4),
            (options.keeps_parts(), denoised),
        ]
        .map(|(wanted, bytes)| if wanted { bytes } else { 0 })
        .iter()
        .sum();
        let views = eyes.sources.len();
        let needed = pixels.saturating_mul(each).saturating_mul(views as u64);
        let refused = || {
            let what = counted(views, "view", "views") + &format!(" of {width}x{height}");
            let remedy = "render fewer or smaller views at a time, or receive rows as they finish (FrameBuilder::rows)";
            too_large(what, needed, remedy)
        };
        if needed > MOST_BYTES {
            return Err(refused());
        }
        let room = |_| {
            let mut rows = Self::new(width);
            rows.reserve(pixels as usize, [depth, ids, options.linear, options.cost_map, options.keeps_parts()])
                .map_err(|_| refused())?;
            Ok(rows)
        };
        (0..views).map(room).collect()
    }

    fn reserve(
        &mut self,
        pixels: usize,
        [depth, ids, linear, cost, parts]: [bool; 5],
    ) -> Result<(), std::collections::TryReserveError> {
        let wanted = |wanted: bool| if wanted { pixels } else { 0 };
        self.view.rgba8.try_reserve_exact(pixels)?;
        self.view.depth.try_reserve_exact(wanted(depth))?;
        self.view.primitive.try_reserve_exact(wanted(ids))?;
        self.view.object.try_reserve_exact(wanted(ids))?;
        self.view.linear.try_reserve_exact(wanted(linear))?;
        self.view.cost.try_reserve_exact(wanted(cost))?;
        self.parts.try_reserve_exact(wanted(parts))?;
        self.source.try_reserve_exact(pixels)
    }

    /// Returns the pixel sources of the first `rows` rows, without a picture.
    pub(crate) fn first_rows(&self, rows: u32) -> Self {
        let pixels = (rows * self.view.width) as usize;
        let of_these = self.shadow_source.len().min(pixels);
        let mut first = Self::new(self.view.width);
        first.view.height = rows;
        first.source = self.source[..pixels].to_vec();
        first.shadow_source = self.shadow_source[..of_these].to_vec();
        first
    }

    /// Splits off all but the first `rows` rows.
    pub(crate) fn split_off(&mut self, rows: u32) -> Self {
        fn below<T>(list: &mut Vec<T>, place: usize) -> Vec<T> {
            list.split_off(place.min(list.len()))
        }
        let place = rows as usize * self.view.width as usize;
        let view = &mut self.view;
        let below_it = View {
            width: view.width,
            height: view.height - rows,
            rgba8: below(&mut view.rgba8, place),
            linear: below(&mut view.linear, place),
            albedo: below(&mut view.albedo, place),
            depth: below(&mut view.depth, place),
            primitive: below(&mut view.primitive, place),
            object: below(&mut view.object, place),
            cost: below(&mut view.cost, place),
        };
        view.height = rows;
        let (source, shadow_source) = (below(&mut self.source, place), below(&mut self.shadow_source, place));
        let parts = below(&mut self.parts, place);
        Self { view: below_it, source, shadow_source, parts }
    }

    /// Appends other rows below these.
    pub(crate) fn append(&mut self, mut rows: Self) {
        // Traced bands have no shadow sources. If other bands have some, all pixels of traced bands count as `Traced`.
        let pixels = self.source.len() + rows.source.len();
        if !rows.shadow_source.is_empty() || !self.shadow_source.is_empty() {
            self.shadow_source.resize(self.source.len(), ShadowSource::Traced);
            self.shadow_source.append(&mut rows.shadow_source);
            self.shadow_source.resize(pixels, ShadowSource::Traced);
        }
        self.source.append(&mut rows.source);
        self.parts.append(&mut rows.parts);
        self.view.append(rows.view);
    }
}
