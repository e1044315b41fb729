// What `bracket` keeps of each pixel: depth along the view axis (FAR: nothing hit) and the place in `primitives` (NO_SLOT: nothing
// hit), with a mark of a right pixel in the top bits.
struct PixelHit {
    depth: f32,
    slot: u32,
}

const KEEP_HITS: bool = true;
const KEEP_BITS: bool = true;
const NO_SLOT: u32 = 0x0fffffffu;

fn pixel_hit(depth: f32, primitive: u32, slot: u32) -> PixelHit {
    return PixelHit(depth, select(slot, NO_SLOT, primitive == MISS));
}
