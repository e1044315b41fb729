// One of several passes that average light over ever larger steps, where it is on the same surface and chance explains
// its differences (Dammertz et al. 2010, "Edge-Avoiding À-Trous Wavelet Transform"; Schied et al. 2017, "Spatiotemporal
// Variance-Guided Filtering", section 4.3).
//
// launch  one thread per pixel of the strip
// reads   noisy_light, guides  [height * width]
// writes  smooth_light         [height * width]

//! use frame, noisy, octahedral, pixels

// Weights of a cubic B-spline at distances 0, 1 and 2.
const SPLINE: array<f32, 3> = array(0.375, 0.25, 0.0625);
// Difference of brightness at which the weight falls to 1/e, in standard deviations. Mirrors, glass and narrow
// highlights show edges that no guide tells of, so less is allowed there.
const DEVIATIONS: f32 = 4.0;
const NARROW_DEVIATIONS: f32 = 1.5;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn smooth_light_once(@builtin(global_invocation_id) id: vec3u) {
    let index = index_beside(id.xy, vec2i(0));
    if index == NOWHERE { return; }
    let light = noisy_light[index];
    let guide = guides[index];
    if guide.normal == NO_NORMAL { smooth_light[index] = light; return; }
    let normal = from_octahedral(guide.normal);
    let own = brightness_of(light);
    let smoothness = clamp(guide.lobe_width / SMOOTH_WIDTH, 0.0, 1.0);
    let deviations = vec2f(DEVIATIONS, mix(NARROW_DEVIATIONS, DEVIATIONS, smoothness));
    let variances = variances_around(id.xy);
    var diffuse = vec4f(0.0);
    var glossy = vec4f(0.0);
    var weights = vec2f(0.0);
    for (var y = -2; y <= 2; y += 1) {
        for (var x = -2; x <= 2; x += 1) {
            let other = index_beside(id.xy, vec2i(x, y) * i32(frame.paths.ray));
            if other == NOWHERE { continue; }
            let there = noisy_light[other];
            let tolerance = deviations * sqrt(variances + variances_of(there)) + 1e-9;
            let off = abs(brightness_of(there) - own) / tolerance;
            let spline = SPLINE[abs(x)] * SPLINE[abs(y)];
            let weight = spline * alike(guide, normal, guides[other]) * reflected_kinds(there) * exp(-off);
            diffuse += vec4f(weight.x * there.diffuse, weight.x * weight.x * there.diffuse_variance);
            glossy += vec4f(weight.y * there.glossy, weight.y * weight.y * there.glossy_variance);
            weights += weight;
        }
    }
    // A pixel's weight for itself is above 0, but for light that it does not reflect.
    let kinds = reflected_kinds(light);
    var result = light;
    if kinds.x > 0.0 {
        result.diffuse = diffuse.xyz / weights.x;
        result.diffuse_variance = diffuse.w / (weights.x * weights.x);
    }
    if kinds.y > 0.0 {
        result.glossy = glossy.xyz / weights.y;
        result.glossy_variance = glossy.w / (weights.y * weights.y);
    }
    smooth_light[index] = result;
}

// Returns the variances of a pixel, averaged with those beside it.
fn variances_around(pixel: vec2u) -> vec2f {
    let size = vec2i(frame.band.size);
    var sum = vec2f(0.0);
    for (var y = -1; y <= 1; y += 1) {
        for (var x = -1; x <= 1; x += 1) {
            let place = clamp(vec2i(pixel) + vec2i(x, y), vec2i(0), size - 1);
            let there = noisy_light[u32(place.y) * frame.band.size.x + u32(place.x)];
            let weight = 1.0 / f32((1 + abs(x)) * (1 + abs(y)));
            sum += weight * variances_of(there);
        }
    }
    return sum / 4.0;
}
