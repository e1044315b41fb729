// Lists of right pixels; the first three words of each one's head are an indirect dispatch.

const TO_TRACE: u32 = 0u;   // pixels that need a primary ray
const TO_LIGHT: u32 = 1u;   // pixels that need shadow rays only

struct ListHead {
    workgroups_x: atomic<u32>,
    workgroups_y: u32,
    workgroups_z: u32,
    count: atomic<u32>,
}

struct Lists {
    heads: array<ListHead, 2>,
    pixels: array<u32>,         // half for each list
}

fn place_in(list: u32, place: u32) -> u32 {
    return list * (arrayLength(&lists.pixels) / 2u) + place;
}
