// Nothing is kept of a pixel but its colour.
struct PixelHit {
    depth: f32,
}

const KEEP_HITS: bool = false;
const KEEP_BITS: bool = false;

fn pixel_hit(depth: f32, primitive: u32, slot: u32) -> PixelHit { return PixelHit(depth); }
fn primitive_of(hit: PixelHit) -> u32 { return MISS; }
