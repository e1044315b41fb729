// The pixels of a thread of a launch over a list. The last thread's spare rays repeat the last entry and are not wanted.
struct ListedPixels {
    pixels: Pixels,
    wanted: B,
}

fn listed_pixels(list: u32, thread: u32) -> ListedPixels {
    let first = thread * RAYS;
    let count = atomicLoad(&lists.heads[list].count);
    var index: U;
    var wanted: U;
    var ray = 0u;
    loop {
        let place = min(first + ray, max(count, 1u) - 1u);
        index = with_ray_u(index, ray, lists.entries[place_in(list, place)]);
        wanted = with_ray_u(wanted, ray, select(0u, 1u, first + ray < count));
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let width = frame.image_size.x;
    return ListedPixels(Pixels(index % width, index / width), wanted == U(1u));
}
