// What right pixels ask of left samples is kept in a texture, since software adapters read those faster: see samples_read.wgsl.
@group(1) @binding(15) var source_samples: texture_storage_2d<rgba32uint, write>;

fn keep_sample(pixel: vec2u, samples: Samples, ray: u32) {
    let depth = bitcast<u32>(of_ray(samples.depth, ray));
    var other = samples.slot;
    if KEEP_OCCLUDERS { other = found_occluders; }
    textureStore(source_samples, pixel, vec4u(depth, of_ray_u(other, ray), of_ray_u(samples.component, ray), of_ray_u(samples.bits, ray)));
}
