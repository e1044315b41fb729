//! Reads a band back to the host.

use super::{
    ViewRows,
    bands::Band,
    driver::Driver,
    plan::{Launch, Made, Step},
    targets::{Shape, Targets},
};
use crate::{
    PixelSource, ShadowSource, View,
    frame::show::PACK,
    kernel::{Resource, layout},
};

/// Ids of primitives by slot, and ids of objects by primitive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ids<'a> {
    pub(crate) of_slots: &'a [u32],
    pub(crate) objects: &'a [u32],
}

/// Layout of a band in a staging buffer. Each view has the pixels of `pack`, linear colour, costs and counters. Times
/// follow the last view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReadBack {
    shape: Shape,
    /// Whether pictures are read back, or only counters.
    pictures: bool,
    linear: bool,
    /// Whether light is read back in parts.
    parts: bool,
}

/// Parts of a view in the staging buffer.
#[derive(Clone, Copy)]
enum Part {
    /// Colour, with marks in place of alpha.
    Color,
    Depth,
    /// Slot of the primitive that was hit.
    Slot,
    Linear,
    LightParts,
    Cost,
    Counters,
}

impl Part {
    const ALL: [Self; 7] =
        [Self::Color, Self::Depth, Self::Slot, Self::Linear, Self::LightParts, Self::Cost, Self::Counters];
}

impl ReadBack {
    pub(crate) fn new(shape: Shape, [linear, parts]: [bool; 2], pictures: bool) -> Self {
        Self { shape, pictures, linear, parts }
    }

    /// Returns the size of a part's row in bytes; 0 if the part is not requested.
    fn row_bytes(&self, part: Part) -> u64 {
        let width = u64::from(self.shape.size[0]);
        let words = self.shape.words_read();
        match part {
            Part::Color if self.pictures => width * 4,
            Part::Depth if self.pictures && words > 1 => width * 4,
            Part::Slot if self.pictures && words > 2 => width * 4,
            Part::Linear if self.pictures && self.linear => width * 16,
            Part::LightParts if self.pictures && self.parts => width * size_of::<layout::LightParts>() as u64,
            Part::Cost if self.pictures && self.shape.cost_map => width * 4,
            Part::Counters => layout::COUNTERS as u64 * 4,
            _ => 0,
        }
    }

    fn view_bytes(&self) -> u64 {
        let row: u64 = Part::ALL.into_iter().map(|part| self.row_bytes(part)).sum();
        row * u64::from(self.shape.bands.rows)
    }

    fn offset(&self, view: usize, part: Part) -> u64 {
        let before = Part::ALL.into_iter().take(part as usize).map(|part| self.row_bytes(part));
        view as u64 * self.view_bytes() + before.sum::<u64>() * u64::from(self.shape.bands.rows)
    }

    /// Returns the offset of times, which is the size of all views in bytes.
    pub(crate) fn times_offset(&self) -> u64 {
        self.shape.views as u64 * self.view_bytes()
    }

    /// Encodes the copies of a band's rows to a staging buffer.
    pub(crate) fn encode(
        &self,
        driver: &mut Driver<'_>,
        targets: &Targets,
        encoder: &mut wgpu::CommandEncoder,
        band: &Band,
        to: &wgpu::Buffer,
    ) {
        let [first, rows] = [band.place().start, band.count()].map(u64::from);
        let kept = u64::from(band.seen.end - band.first);
        for view in 0..self.shape.views {
            if self.pictures {
                let step = Step::Run { name: PACK.name, kernel: &PACK, view, launch: Launch::Pixels, part: 0 };
                driver.encode(encoder, step);
            }
            for part in Part::ALL {
                let row = self.row_bytes(part);
                let (place, begin) = match part {
                    Part::Color => ((Resource::Packed, 0), 0),
                    Part::Depth => ((Resource::Packed, 0), kept * row),
                    Part::Slot => ((Resource::Packed, 0), 2 * kept * row),
                    Part::Linear => ((Resource::Linear, view), 0),
                    Part::LightParts => ((Resource::LightParts, view), 0),
                    Part::Cost => ((Resource::Counters, view), kept * layout::COUNTERS as u64 * 4),
                    Part::Counters => ((Resource::Counters, view), 0),
                };
                if row > 0 {
                    let source = targets.get(place.0, place.1);
                    let offset = self.offset(view, part);
                    encoder.copy_buffer_to_buffer(source, begin + first * row, to, offset, Some(rows * row));
                }
            }
        }
    }

    fn part<'a>(&self, bytes: &'a [u8], band: &Band, view: usize, part: Part) -> &'a [u8] {
        let (begin, count) = (self.offset(view, part), self.row_bytes(part) * u64::from(band.count()));
        &bytes[begin as usize..(begin + count) as usize]
    }

    /// Returns the counters of a view's band.
    pub(crate) fn counts(&self, bytes: &[u8], band: &Band, view: usize) -> Counts {
        Counts::of(&words(self.part(bytes, band, view, Part::Counters)))
    }

    /// Returns a band's rows of a view, given how it was made. Returns `None` if no pictures are requested.
    pub(crate) fn rows(&self, bytes: &[u8], band: &Band, view: usize, made: Made, ids: Ids<'_>) -> Option<ViewRows> {
        if !self.pictures {
            return None;
        }
        let all = |part| words_of(self.part(bytes, band, view, part));
        let depth = |bits| {
            let depth = f32::from_bits(bits);
            if depth < crate::FAR { depth } else { f32::INFINITY }
        };
        let id = |slot: u32| ids.of_slots.get(slot as usize).copied().unwrap_or(crate::MISS);
        let color = |word: u32| (word | !layout::PACKED_COLOR).to_le_bytes();
        let primitive: Vec<u32> = all(Part::Slot).map(id).collect();
        let object = |id: &u32| ids.objects.get(*id as usize).copied().unwrap_or(crate::MISS);
        let count = all(Part::Color).len();
        let source = match made {
            Made::Traced | Made::Drawn | Made::Chosen | Made::Recalled => vec![PixelSource::Traced; count],
            Made::Copied => vec![PixelSource::Reused; count],
            Made::Marked { .. } | Made::Bracketed => all(Part::Color).map(pixel_source).collect(),
        };
        let linear = self.part(bytes, band, view, Part::Linear).chunks_exact(16);
        let parts = self.part(bytes, band, view, Part::LightParts).chunks_exact(size_of::<layout::LightParts>());
        let parts = parts.map(bytemuck::pod_read_unaligned).collect();
        let marked = if made == Made::Bracketed { count } else { 0 };
        let shadow_source = all(Part::Color).take(marked).map(shadow_source_of).collect();
        let view = View {
            width: self.shape.size[0],
            height: band.count(),
            rgba8: all(Part::Color).map(color).collect(),
            linear: linear.map(bytemuck::pod_read_unaligned).collect(),
            depth: all(Part::Depth).map(depth).collect(),
            object: primitive.iter().map(object).collect(),
            primitive,
            albedo: Vec::new(),
            cost: words(self.part(bytes, band, view, Part::Cost)),
        };
        Some(ViewRows { view, source, shadow_source, parts })
    }
}

fn words_of(bytes: &[u8]) -> impl ExactSizeIterator<Item = u32> {
    bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned)
}

fn words(bytes: &[u8]) -> Vec<u32> {
    words_of(bytes).collect()
}

/// Counters of a view's band.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    pub(crate) shadow_rays: u64,
    /// Secondary rays, which mirrors, glass and transparent surfaces reflect or transmit.
    pub(crate) sent_rays: u64,
    /// Shadow rays from mirrored surfaces, included in `shadow_rays`.
    pub(crate) own_shadow_rays: u64,
    pub(crate) nodes: u64,
    pub(crate) primitive_tests: u64,
    pub(crate) bad: u64,
    pub(crate) missed: u64,
    pub(crate) gaps: u64,
    pub(crate) lost_candidates: u64,
    /// Number of threads whose loops the adapter ended early.
    pub(crate) cut_short: u64,
    /// Choice that the kernel `choose` made.
    chosen: u64,
}

impl Counts {
    fn of(counters: &[u32]) -> Self {
        let sum = |word| counters.iter().skip(word).step_by(layout::COUNTERS).map(|&n| u64::from(n)).sum();
        Self {
            shadow_rays: sum(layout::SHADOW_RAYS),
            sent_rays: sum(layout::SENT_RAYS),
            own_shadow_rays: sum(layout::OWN_SHADOW_RAYS),
            nodes: sum(layout::NODES_VISITED),
            primitive_tests: sum(layout::PRIMITIVES_TESTED),
            bad: sum(layout::BAD_PIXELS),
            missed: sum(layout::MISSED_PIXELS),
            gaps: sum(layout::GAP_PIXELS),
            lost_candidates: sum(layout::LOST_CANDIDATES),
            cut_short: sum(layout::CUT_SHORT),
            chosen: sum(layout::CHOSEN),
        }
    }

    /// Returns how the band was made, given how its view was made.
    pub(crate) fn made(&self, made: Made) -> Made {
        match made {
            Made::Chosen if self.chosen == u64::from(layout::BRACKET_CHOSEN) => Made::Bracketed,
            Made::Chosen => Made::Traced,
            made => made,
        }
    }
}

fn pixel_source(mark: u32) -> PixelSource {
    match mark {
        mark if mark & layout::MISSED != 0 => PixelSource::Missed,
        mark if mark & layout::BAD != 0 => PixelSource::Bad,
        _ => PixelSource::Reused,
    }
}

fn shadow_source_of(mark: u32) -> ShadowSource {
    if mark & layout::ASKED != 0 { ShadowSource::Traced } else { ShadowSource::Taken }
}
