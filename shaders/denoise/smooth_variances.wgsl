// Bounds single bright pixels, and raises the variances of pixels to the mean of those around them on the same surface.
// A pixel's own variance is uncertain after few paths, and low where its paths found little light. It is high where one
// path found much.
//
// launch  one thread per pixel of the strip
// reads   noisy_light, guides  [height * width]
// writes  smooth_light         [height * width]

//! use noisy, octahedral, pixels

const REACH: i32 = 3;
// Weights of all pixels around a pixel below which it is bounded.
const FEW: f32 = 2.0;

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
    let is_bounded = vec2<bool>(false, guide.lobe_width < SMOOTH_WIDTH) | (weights < vec2f(FEW));
    if any(is_bounded) {
        let scale = select(vec2f(1.0), bound_by_chance(id.xy, light), is_bounded);
        light.diffuse *= scale.x;
        light.glossy *= scale.y;
    }
    let means = sum / max(weights, vec2f(1.0));
    if kinds.x > 0.0 { light.diffuse_variance = max(light.diffuse_variance, means.x); }
    if kinds.y > 0.0 { light.glossy_variance = max(light.glossy_variance, means.y); }
    smooth_light[index] = light;
}

// Deviations from the brightest pixel beside it by which chance may explain that a pixel is brighter.
const BOUND_DEVIATIONS: f32 = 2.0;

// Returns the factors of a pixel's light, diffuse and glossy, that make it as bright as the brightest of the pixels
// beside it. They are 1 where it is darker than that, or brighter than chance explains.
fn bound_by_chance(pixel: vec2u, light: Noisy) -> vec2f {
    var limit = vec2f(-1.0);
    for (var y = -1; y <= 1; y += 1) {
        for (var x = -1; x <= 1; x += 1) {
            let other = index_beside(pixel, vec2i(x, y));
            if other == NOWHERE || (x == 0 && y == 0) { continue; }
            if guides[other].normal == NO_NORMAL { continue; }
            let there = noisy_light[other];
            limit = max(limit, select(vec2f(-1.0), brightness_of(there), reflected_kinds(there) > vec2f(0.0)));
        }
    }
    let own = brightness_of(light);
    let chance = BOUND_DEVIATIONS * sqrt(variances_of(light));
    let is_over = (limit >= vec2f(0.0)) & (own > limit) & (own - limit <= chance);
    return select(vec2f(1.0), limit / max(own, vec2f(1e-30)), is_over);
}
