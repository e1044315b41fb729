// What is kept of each pixel: depth along the view axis (FAR: nothing hit).
struct PixelHit {
    depth: f32,
}

const KEEP_HITS: bool = true;

fn pixel_hit(depth: f32, primitive: u32) -> PixelHit { return PixelHit(depth); }
fn primitive_of(hit: PixelHit) -> u32 { return MISS; }
