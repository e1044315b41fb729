// Places in a list of pixels for a lane's, side by side, so that neighbours are traced together. The order of the list depends on the
// threads; each entry writes only its own pixel, so the picture does not.
fn reserve(list: u32, count: u32) -> u32 {
    return reserve_for(list, count, LIST_WORKGROUP * RAYS);
}

// The same where a workgroup takes so many entries.
fn reserve_for(list: u32, count: u32, workgroup: u32) -> u32 {
    if count == 0u { return 0u; }
    let place = atomicAdd(&lists.heads[list].count, count);
    let begun = (place + count + workgroup - 1u) / workgroup - (place + workgroup - 1u) / workgroup;
    if begun > 0u { atomicAdd(&lists.heads[list].workgroups_x, begun); }
    return place;
}

fn append(list: u32, place: u32, entry: u32) {
    lists.entries[place_in(list, place)] = entry;
}
