// The list of right pixels to trace; its first three words are an indirect dispatch.

struct TraceList {
    workgroups_x: atomic<u32>,
    workgroups_y: u32,
    workgroups_z: u32,
    count: atomic<u32>,
    pixels: array<u32>,
}

// Marks of right_source: checked and rejected, traced for want of a left sample; and what is left for the column.
const BAD: u32 = 0x40000000u;
const MISSED: u32 = 0x80000000u;
const COLUMN: u32 = 0x3fffffffu;
