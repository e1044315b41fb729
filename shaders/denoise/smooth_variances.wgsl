// Raises the variances of pixels to the mean of those around them on the same surface. A pixel's own variance is
// uncertain after few paths, and low where its paths found little light. It is high where one path found much.
//
// launch  one thread per pixel of the strip
// reads   noisy_light, guides  [height * width]
// writes  smooth_light         [height * width]

//! use noisy, octahedral, pixels

const REACH: i32 = 3;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn smooth_variances(@builtin(global_invocation_id) id: vec3u) {
    let index = index_beside(id.xy, vec2i(0));
    if index == NOWHERE { return; }
    var light = noisy_light[index];
    let guide = guides[index];
    if guide.normal == NO_NORMAL { smooth_light[index] = light; return; }
    let normal = from_octahedral(guide.normal);
    var sum = vec2f(0.0);
    var weights = vec2f(0.0);
    for (var y = -REACH; y <= REACH; y += 1) {
        for (var x = -REACH; x <= REACH; x += 1) {
            let other = index_beside(id.xy, vec2i(x, y));
            if other == NOWHERE { continue; }
            let there = noisy_light[other];
            let weight = alike(guide, normal, guides[other]) * reflected_kinds(there);
            sum += weight * vec2f(there.diffuse_variance, there.glossy_variance);
            weights += weight;
        }
    }
    // A pixel's weight for itself is 1, or 0 for light that it does not reflect.
    let kinds = reflected_kinds(light);
    let means = sum / max(weights, vec2f(1.0));
    if kinds.x > 0.0 { light.diffuse_variance = max(light.diffuse_variance, means.x); }
    if kinds.y > 0.0 { light.glossy_variance = max(light.glossy_variance, means.y); }
    smooth_light[index] = light;
}
