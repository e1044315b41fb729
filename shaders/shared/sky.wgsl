// The colour of rays that miss.

//! use fetch, lane, table

//! if sky is constant
// The sky has one colour.
fn sky(direction: F3) -> F3 {
    return all3(shading_vector(SKY_ZENITH));
}

//! if sky is gradient
// The sky is a gradient along the world's y axis.
fn sky(direction: F3) -> F3 {
    let height = 0.5 + 0.5 * direction.y / sqrt(dot3(direction, direction));
    return add3(
        times3(all3(shading_vector(SKY_NADIR)), 1.0 - height),
        times3(all3(shading_vector(SKY_ZENITH)), height),
    );
}

//! if sky is map
// The sky is an equirectangular picture, filtered bilinearly. Its top row is straight up, its middle column faces -z,
// and columns proceed to the right. Columns wrap at the seam. Beyond a pole a row continues at the opposite column.
const PI: f32 = 3.14159265;

fn sky(direction: F3) -> F3 {
    let header = table_texel(SKY_NADIR);   // first texel, width, height
    let size = vec2i(header.yz);
    var color: F3;
    var ray = 0u;
    loop {
        color = with_ray3(color, ray, sky_color(normalize(of_ray3(direction, ray)), header.x, size));
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return color;
}

fn sky_color(d: vec3f, first: u32, size: vec2i) -> vec3f {
    // For directions straight up and down, the column is arbitrary.
    let upright = max(abs(d.x), abs(d.z)) < 1e-7;
    let turn = select(atan2(d.x, -d.z) / (2.0 * PI), 0.0, upright);
    let place = vec2f(turn + 0.5, acos(clamp(d.y, -1.0, 1.0)) / PI) * vec2f(size) - 0.5;
    let corner = vec2i(floor(place));
    let share = place - floor(place);
    let top = mix(sky_texel(corner, first, size), sky_texel(corner + vec2i(1, 0), first, size), share.x);
    let bottom =
        mix(sky_texel(corner + vec2i(0, 1), first, size), sky_texel(corner + vec2i(1, 1), first, size), share.x);
    return mix(top, bottom, share.y);
}

fn sky_texel(at: vec2i, first: u32, size: vec2i) -> vec3f {
    let beyond = at.y < 0 || at.y >= size.y;
    let row = select(select(at.y, 2 * size.y - 1 - at.y, at.y >= size.y), -1 - at.y, at.y < 0);
    let column = (at.x + select(0, size.x / 2, beyond) + 2 * size.x) % size.x;
    return shading_vector(first + u32(row * size.x + column));
}
