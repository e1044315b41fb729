// Marks of the pixels of a target view. BAD: the pixel was checked and rejected. MISSED: no sample landed, so the pixel
// was traced. KEY: bits of the key of the reused source pixel.
const BAD: u32 = 0x40000000u;
const MISSED: u32 = 0x80000000u;
// For `bracket` only: some light of the pixel needed a shadow ray.
const ASKED: u32 = 0x20000000u;
const KEY: u32 = 0x1fffffffu;

// Key of a pixel on which no sample landed.
const EMPTY: u32 = 0u;
