// The sky as a light source, which replaces ambient light if requested. Rays from a point in many directions collect
// the sky's radiance (DESIGN, section 3).

//! use aims, display, fetch, lane, sky, table

//! if surroundings is cosine or map
// Colours that four rays contribute to a white surface, each multiplied by the total number of rays.
struct FourColors {
    r: vec4f,
    g: vec4f,
    b: vec4f,
}

fn sum_of_colors(four: FourColors) -> vec3f {
    return vec3f(sum_of_four(four.r), sum_of_four(four.g), sum_of_four(four.b));
}

fn with_color(four: FourColors, index: u32, color: vec3f) -> FourColors {
    let here = vec4u(0u, 1u, 2u, 3u) == vec4u(index);
    return FourColors(
        select(four.r, vec4f(color.x), here),
        select(four.g, vec4f(color.y), here),
        select(four.b, vec4f(color.z), here),
    );
}

//! if surroundings is ambient or cosine
fn four_rays(aim: Aim, group: u32) -> Four { return spread_four(aim, indices_of(group)); }

// Returns a ray, four times.
fn one_ray(aim: Aim, index: u32) -> Four { return spread_four(aim, vec4u(index)); }

//! if surroundings is cosine
// For a sky of one colour or a gradient rays are distributed by the cosine, so all have the same weight.
fn sky_colors(aim: Aim, rays: Four) -> FourColors {
    let none = vec4f(0.0);
    var four = FourColors(none, none, none);
    var index = 0u;
    loop {
        if rays.wanted[index] {
            let direction = vec3f(rays.x[index], rays.y[index], rays.z[index]);
            four = with_color(four, index, of_ray3(sky(all3(direction)), 0u));
        }
        index += 1u;
        if index >= 4u { break; }
    }
    return four;
}

//! if surroundings is map
// A picture may contain a sun that covers few pixels. Therefore every other ray is sampled by the picture's brightness,
// and the remaining rays by the cosine. Both techniques are combined by the balance heuristic (Veach & Guibas 1995,
// "Optimally Combining Sampling Techniques").
fn bright_rays(aim: Aim) -> u32 { return aim.count / 2u; }

fn cosine_rays(aim: Aim) -> u32 { return aim.count - bright_rays(aim); }

fn four_rays(aim: Aim, group: u32) -> Four { return sky_rays(aim, indices_of(group)); }

// Returns a ray, four times. The first place of `sky_rays` is for even indices, the second for odd ones.
fn one_ray(aim: Aim, index: u32) -> Four {
    let four = sky_rays(aim, vec4u(index & ~1u, index | 1u, index & ~1u, index | 1u));
    return one_of_four(four, index & 1u);
}

fn one_of_four(four: Four, place: u32) -> Four {
    return Four(
        vec4f(four.x[place]),
        vec4f(four.y[place]),
        vec4f(four.z[place]),
        vec4f(four.far[place]),
        vec4f(four.weight[place]),
        vec4f(four.fade[place]),
        vec4<bool>(four.wanted[place]),
    );
}

fn sky_rays(aim: Aim, index: vec4u) -> Four {
    if aim.kind != SURROUNDINGS { return spread_four(aim, index); }
    let bright = (index & vec4u(1u)) == vec4u(1u);
    let count = select(vec4f(f32(cosine_rays(aim))), vec4f(max(f32(bright_rays(aim)), 1.0)), bright);
    let place = index >> vec4u(1u);
    let u = fract((vec4f(place) + 0.5) / count + aim.spin.x);
    let v = fract(vec4f(reverseBits(place) >> vec4u(8u)) / 16777216.0 + aim.spin.y);
    let turn = 6.2831853 * v;
    let p = sqrt(u) * cos(turn);
    let q = sqrt(u) * sin(turn);
    let straight = sqrt(max(1.0 - u, vec4f(0.0)));
    let x = aim.base.x * straight + aim.along.x * p + aim.up.x * q;
    let y = aim.base.y * straight + aim.along.y * p + aim.up.y * q;
    let z = aim.base.z * straight + aim.along.z * p + aim.up.z * q;
    let second = towards_brightness(u.y, v.y);
    let fourth = towards_brightness(u.w, v.w);
    return facing_four(
        aim,
        index,
        vec4f(x.x, second.x, x.z, fourth.x),
        vec4f(y.x, second.y, y.z, fourth.y),
        vec4f(z.x, second.z, z.z, fourth.z),
    );
}

// Returns the sine of the angle between a map's row and the pole. It is an approximation, off by at most 0.0011. A
// pixel's weight is its luminance times this sine. The host sums the weights with the same bits (src/accel/table.rs). A
// map is bilinear: each pixel is spread over a tent two pixels wide. So the density of rays is bilinear too.
fn row_weight(row: i32, rows: i32) -> f32 {
    let inside = select(select(row, 2 * rows - 1 - row, row >= rows), -1 - row, row < 0);
    let down = (f32(inside) + 0.5) / f32(rows);
    let arc = 4.0 * down * (1.0 - down);
    return arc * (0.775 + 0.225 * arc);
}

// Inverts the cumulative distribution of a tent on [-1, 1]: returns the position below which a given share of the area
// lies.
fn tent(share: f32) -> f32 {
    return select(1.0 - sqrt(2.0 - 2.0 * share), sqrt(2.0 * share) - 1.0, share < 0.5);
}

// Samples a direction by the map's brightness: first the row, then the column, then the position within the pixel's
// tent.
fn towards_brightness(u: f32, v: f32) -> vec3f {
    let header = table_texel(SKY_NADIR);   // first texel, width, height
    let row = texel_over(u, header.x + header.y - 1u, header.y, header.z);
    let column = texel_over(v, header.x + header.y * row.index, 1u, header.y);
    let across = f32(column.index) + 0.5 + tent(column.within);
    let down = (f32(row.index) + 0.5 + tent(row.within)) / f32(header.z) * PI;
    let around = (across / f32(header.y) - 0.5) * (2.0 * PI);
    return vec3f(sin(down) * sin(around), cos(down), -sin(down) * cos(around));
}

// Colour of a map in a direction, and the density of rays sampled by brightness there, times pi steradians.
struct SkySeen {
    color: vec3f,
    density: f32,
}

fn sky_seen(d: vec3f, header: vec4u, mean: f32) -> SkySeen {
    let size = vec2i(header.yz);
    let upright = max(abs(d.x), abs(d.z)) < 1e-7;
    let turn = select(atan2(d.x, -d.z) / (2.0 * PI), 0.0, upright);
    let place = vec2f(turn + 0.5, acos(clamp(d.y, -1.0, 1.0)) / PI) * vec2f(size) - 0.5;
    let corner = vec2i(floor(place));
    let share = place - floor(place);
    let next = corner + vec2i(1, 1);
    let top = mix(sky_texel(corner, header.x, size), sky_texel(vec2i(next.x, corner.y), header.x, size), share.x);
    let bottom = mix(sky_texel(vec2i(corner.x, next.y), header.x, size), sky_texel(next, header.x, size), share.x);
    let weights = vec2f(luminance(top), luminance(bottom)) * vec2f(
        row_weight(corner.y, size.y),
        row_weight(next.y, size.y),
    );
    // A pixel covers 2 pi^2 sin / (width height) steradians.
    let sine = max(sqrt(d.x * d.x + d.z * d.z), 1e-4);
    let density = mix(weights.x, weights.y, share.y) / (mean * 2.0 * PI * sine);
    return SkySeen(mix(top, bottom, share.y), select(0.0, density, mean > 0.0));
}

// Returns the mean of the pixels' weights, which is stored in place of the last row's share.
fn map_mean(header: vec4u) -> f32 {
    return bitcast<f32>(table_texel(header.x + header.y * header.z - 1u).w);
}

fn sky_colors(aim: Aim, rays: Four) -> FourColors {
    let header = table_texel(SKY_NADIR);
    let mean = map_mean(header);
    let none = vec4f(0.0);
    var four = FourColors(none, none, none);
    var index = 0u;
    loop {
        if rays.wanted[index] {
            let direction = vec3f(rays.x[index], rays.y[index], rays.z[index]);
            let seen = sky_seen(direction, header, mean);
            let cosine = dot(direction, aim.shading_normal);
            let likely = f32(cosine_rays(aim)) * cosine + f32(bright_rays(aim)) * seen.density;
            four = with_color(four, index, seen.color * (f32(aim.count) * cosine / likely));
        }
        index += 1u;
        if index >= 4u { break; }
    }
    return four;
}
