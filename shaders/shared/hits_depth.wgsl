// What is kept of each pixel: depth along the view axis (FAR: nothing hit).
struct PixelHit {
    depth: f32,
}

const KEEP_HITS: bool = true;
const KEEP_BITS: bool = false;

fn pixel_hit(depth: f32, primitive: u32, slot: u32) -> PixelHit { return PixelHit(depth); }
fn primitive_of(hit: PixelHit) -> u32 { return MISS; }
