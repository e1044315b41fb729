// A list of rays that start at one point, frame.source_eye: two texels of the table each, direction and t_min, then t_max.
// frame.image_size.x is their number.

struct ListedRays {
    rays: Rays,
    t_min: F,
    t_max: F,
}

fn listed_rays(first: u32) -> ListedRays {
    var direction: F3;
    var t_min: F;
    var t_max = F(NEVER);
    var ray = 0u;
    loop {
        if first + ray < frame.image_size.x {
            let near = bitcast<vec4f>(table_texel(2u * (first + ray)));
            direction = with_ray3(direction, ray, near.xyz);
            t_min = with_ray(t_min, ray, near.w);
            t_max = with_ray(t_max, ray, bitcast<f32>(table_texel(2u * (first + ray) + 1u).x));
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return ListedRays(Rays(frame.source_eye, direction), t_min, t_max);
}
