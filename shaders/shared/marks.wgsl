// Marks of right pixels: checked and rejected, traced for want of a left sample; and in right_source what is left for the column.
const BAD: u32 = 0x40000000u;
const MISSED: u32 = 0x80000000u;
// By `bracket`: some light needed a shadow ray.
const ASKED: u32 = 0x20000000u;
const COLUMN: u32 = 0x3fffffffu;
