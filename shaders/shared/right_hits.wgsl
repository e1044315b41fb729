// The hits that right pixels were found to have, as traversal returns them.
fn right_hits(pixels: Pixels, wanted: B) -> Hits {
    var found = Hits(F(FAR), U(MISS), U(0u));
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) {
            let hit = hits[right_index(pixel_of_ray(pixels, ray))];
            let slot = hit.slot & NO_SLOT;
            let there = slot != NO_SLOT;
            found.t = with_ray(found.t, ray, hit.depth);
            // Which one it is, only its slot tells.
            found.primitive = with_ray_u(found.primitive, ray, select(MISS, 0u, there));
            found.slot = with_ray_u(found.slot, ray, select(0u, slot, there));
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return found;
}
