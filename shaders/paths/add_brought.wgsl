// Adds the mean of what a pixel's paths brought to its colour.
//
// launch  one thread per pixel of the current rows
// reads   brought       [height * width]
// updates view          [height * width]   color
// updates linear_color  [height * width]
// writes  light_parts   [height * width]   if they are kept

//! use camera, lane, light_parts, linear, paths, pixels, scattering, view, wanted

var<storage, read> brought: array<Brought>;
var<storage, read_write> view: array<Pixel>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn add_brought(@builtin(global_invocation_id) id: vec3u) {
    let pixels = block_pixels(id);
    let wanted = inside_rows(pixels);
    if !all_rays(wanted) { return; }
    let index = pixel_index(pixel_of_ray(pixels, 0u));
    let sum = brought[index];
    if sum.paths == 0u && !has_mark(sum, DIFFUSE_KNOWN) {
        keep_no_parts(index, linear_color[index].xyz);
        return;
    }
    let vertex = vertex_at(rays_of(pixels), target_hits(pixels, wanted));
    let rest = linear_color[index].xyz * vertex.lobes.opacity;
    let color = rest + vertex.lobes.diffuse * mean_diffuse(sum) + mean_glossy(sum);
    keep_colors(pixels, wanted, all3(color));
    keep_parts(index, vertex, sum, rest);
}
