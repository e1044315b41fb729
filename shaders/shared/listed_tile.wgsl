// The pixels of a thread of a launch over a list of tiles: its block of one of them.
fn listed_tile_pixels(list: u32, thread: u32) -> ListedPixels {
    let threads = TILE_PIXELS / RAYS;
    let count = atomicLoad(&lists.heads[list].count);
    let place = thread / threads;
    let tile = lists.entries[place_in(list, min(place, max(count, 1u) - 1u))];
    let corner = vec2u(tile % tiles_across(), tile / tiles_across()) * TILE + vec2u(0u, frame.row_begin);
    let block = thread % threads;
    let across = TILE / BLOCK.x;
    let first = corner + vec2u(block % across, block / across) * BLOCK;
    let pixels = Pixels(RAY_X + U(first.x), RAY_Y + U(first.y));
    return ListedPixels(pixels, inside_rows(pixels) & (U(place) < U(count)));
}
