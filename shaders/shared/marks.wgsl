// Marks of the pixels of a view that is not traced: checked and rejected, traced for want of a source's sample; and what is left for
// the key of the source's pixel that is taken over.
const BAD: u32 = 0x40000000u;
const MISSED: u32 = 0x80000000u;
// By `bracket`: some light needed a shadow ray.
const ASKED: u32 = 0x20000000u;
const KEY: u32 = 0x1fffffffu;

// No sample landed here.
const EMPTY: u32 = 0u;
