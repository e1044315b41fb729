// Keeps what a lane's primary rays saw of the view that is traced: in `color`, in its half of `hits`, and as left samples.
fn keep_pixels(pixels: Pixels, wanted: B, samples: Samples) {
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) {
            let pixel = pixel_of_ray(pixels, ray);
            color[pixel_index(pixel)] = vec4f(of_ray3(samples.color, ray), 1.0);
            let hit = sample_hit(samples, ray);
            keep_sample(pixel, samples, ray);
            if KEEP_HITS { hits[select(right_index(pixel), pixel_index(pixel), frame.eye == LEFT)] = hit; }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
}
