// Marks of pixels of a view that is not traced. BAD: checked and rejected. MISSED: traced, since no sample landed. KEY:
// bits for the key of the reused source pixel.
const BAD: u32 = 0x40000000u;
const MISSED: u32 = 0x80000000u;
// `bracket` only: some light needed a shadow ray.
const ASKED: u32 = 0x20000000u;
const KEY: u32 = 0x1fffffffu;

// No sample landed here.
const EMPTY: u32 = 0u;
