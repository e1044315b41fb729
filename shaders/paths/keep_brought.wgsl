// Keeps the light that paths brought to a view, for the next frame.
//
// launch  one thread per pixel of the current rows
// reads   view        [height * width]
// reads   brought     [height * width]
// writes  kept_light  [picture height, width]

//! use camera, dice, display, earlier_light, facets, frame, lane, paths, pixels, scattering, view, wanted

var<storage, read_write> view: array<Pixel>;
var<storage, read> brought: array<Brought>;
var kept_light: texture_storage_2d<rgba32uint, write>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn keep_brought(@builtin(global_invocation_id) id: vec3u) {
    let pixels = block_pixels(id);
    if !all_rays(inside_rows(pixels)) { return; }
    let pixel = pixel_of_ray(pixels, 0u);
    let place = pixel + vec2u(0u, frame.band.first_row);
    textureStore(kept_light, place, light_of(pixels, brought[pixel_index(pixel)], place));
}

fn light_of(pixels: Pixels, sum: Brought, place: vec2u) -> vec4u {
    let counts = path_counts(sum);
    if counts.x == 0u { return vec4u(0u); }
    let vertex = vertex_at(rays_of(pixels), target_hits(pixels, true));
    let tint = tint_of(vertex.lobes);
    let diffuse = mean_diffuse(sum);
    let glossy = mean_glossy(sum);
    let brightness = max(vec2f(luminance(diffuse), luminance(glossy)), vec2f(1e-30));
    let light = EarlierLight(
        diffuse,
        glossy / tint,
        sqrt(mean_variances(sum)) / brightness,
        counts,
        lobe_width(vertex.lobes),
        vertex.normal,
    );
    let salt = 2u * frame.paths.first;
    return packed_light(light, array(scrambled(vec3u(place, salt)), scrambled(vec3u(place, salt + 1u))));
}
