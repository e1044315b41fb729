// What right pixels ask of left samples is kept in a texture, since software adapters read those faster: see samples_read.wgsl.
@group(1) @binding(15) var left_samples: texture_storage_2d<rgba32uint, write>;

fn keep_sample(pixel: vec2u, samples: Samples, ray: u32) {
    let depth = bitcast<u32>(of_ray(samples.depth, ray));
    let other = of_ray_u(select(samples.slot, found_occluders, U(u32(KEEP_OCCLUDERS)) == U(1u)), ray);
    textureStore(left_samples, pixel, vec4u(depth, other, of_ray_u(samples.component, ray), of_ray_u(samples.bits, ray)));
}
