// Keeps what a lane's primary rays saw of the view that is traced.
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
