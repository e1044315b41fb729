// Access to the pixels of the current view.

//! use display, kept_samples, lane, light, linear, pixels, rays, wanted

// Stores the samples of a lane's primary rays.
fn keep_view(pixels: Pixels, wanted: B, samples: Samples) {
    let packed = packed_srgb(samples.color);
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) {
            let pixel = pixel_of_ray(pixels, ray);
            let index = pixel_index(pixel);
            view[index] = pixel_of(samples, packed, ray);
            keep_linear(index, of_ray3(samples.color, ray));
            keep_sample(pixel, samples, ray);
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
}

// Stores the hits of pixels: depth and slot.
fn keep_hits(pixels: Pixels, wanted: B, hits: Hits) {
    let slots = select(hits.slot, U(MISS), hits.primitive == U(MISS));
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) {
            let index = pixel_index(pixel_of_ray(pixels, ray));
            view[index].depth = of_ray(hits.t, ray);
            view[index].slot = of_ray_u(slots, ray);
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
}

// Stores the shaded colours of pixels, given as linear colours.
fn keep_colors(pixels: Pixels, wanted: B, colors: F3) {
    let packed = packed_srgb(colors);
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) {
            let index = pixel_index(pixel_of_ray(pixels, ray));
            view[index].color = of_ray_u(packed, ray);
            keep_linear(index, of_ray3(colors, ray));
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
}

// Returns the stored hits of target pixels, in the form that traversal returns.
fn target_hits(pixels: Pixels, wanted: B) -> Hits {
    var found = Hits(F(FAR), U(MISS), U(0u));
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) {
            let pixel = view[pixel_index(pixel_of_ray(pixels, ray))];
            let there = pixel.slot != MISS;
            found.t = with_ray(found.t, ray, pixel.depth);
            // Only the slot identifies the primitive.
            found.primitive = with_ray_u(found.primitive, ray, select(MISS, 0u, there));
            found.slot = with_ray_u(found.slot, ray, select(0u, pixel.slot, there));
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return found;
}

//! if wanted is all
fn leave_out(pixels: Pixels, wanted: B) {}

//! if wanted is masked
// Marks unwanted pixels of a source, so that other views do not mistake them for samples.
fn leave_out(pixels: Pixels, wanted: B) {
    let inside = in_picture(pixels);
    var ray = 0u;
    loop {
        if of_ray_b(inside, ray) && !of_ray_b(wanted, ray) {
            let pixel = pixel_of_ray(pixels, ray);
            view[pixel_index(pixel)].depth = LEFT_OUT;
            keep_no_sample(pixel);
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
}
