// Places in a list for a lane's pixels, side by side, so that neighbours are traced together. The order of the list depends on the
// threads; each entry writes only its own pixel, so the picture does not.
fn reserve(list: u32, count: u32) -> u32 {
    if count == 0u { return 0u; }
    let place = atomicAdd(&lists.heads[list].count, count);
    let workgroup = LIST_WORKGROUP * RAYS;
    let begun = (place + count + workgroup - 1u) / workgroup - (place + workgroup - 1u) / workgroup;
    if begun > 0u { atomicAdd(&lists.heads[list].workgroups_x, begun); }
    return place;
}

fn append(list: u32, place: u32, pixel: u32) {
    lists.pixels[place_in(list, place)] = pixel;
}
