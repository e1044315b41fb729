// Textures: pictures with mip levels, and checkerboards. They follow the sky's pixels in the shading table.

//! use camera, fetch, lane, primitive, rays, triangle

// Path length from the eye to the rays' origin, for rays that mirrors and glass reflect or transmit.
var<private> travelled_before: F;

// The head of a texture has its kind in the lowest four bits of x and its wrap mode above them. A picture has z levels,
// the largest first. Their heads begin at texel y; each holds the level's first texel, width and height. A checkerboard
// has z squares per side. Its colours are the texels y and y + 1.
const CHECKERBOARD: u32 = 1u;
const WRAP_REPEAT: u32 = 0u;
const WRAP_MIRROR: u32 = 1u;
const WRAP_CLAMP: u32 = 2u;

// Position and footprint of a texture lookup.
struct Lookup {
    uv: vec2f,
    width: f32,    // width of the ray's footprint, in units of uv
    round: bool,   // on a sphere: u repeats and v ends at the poles, for any wrap mode
}

// Returns a texture's colour and alpha.
fn texture_color(head_at: u32, at: Lookup) -> vec4f {
    let head = table_texel(head_at);
    let wrap = select(vec2u(head.x >> 4u), vec2u(WRAP_REPEAT, WRAP_CLAMP), at.round);
    if (head.x & 15u) == CHECKERBOARD {
        let first = bitcast<vec4f>(table_texel(head.y));
        let other = bitcast<vec4f>(table_texel(head.y + 1u));
        return mix(first, other, checkered(at, i32(head.z), wrap));
    }
    let largest = vec2f(table_texel(head.y).yz);
    // The level is chosen by area, since the footprint is a square. The level whose pixels have the footprint's size
    // comes nearest to the mean of 64 rays per pixel. Half a level finer or coarser is less exact, or flickers more
    // between the eyes (tests/it/textures/filter.rs).
    let pixels = at.width * sqrt(largest.x * largest.y);
    let level = clamp(log2(max(pixels, 1e-9)), 0.0, f32(head.z - 1u));
    let finer = u32(level);
    let color = level_color(head.y + finer, at.uv, wrap);
    let share = level - f32(finer);
    if share == 0.0 { return color; }
    return mix(color, level_color(head.y + finer + 1u, at.uv, wrap), share);
}

// Returns the exact share of the second colour in a square of the footprint's size.
fn checkered(at: Lookup, squares: i32, wrap: vec2u) -> f32 {
    let width = min(at.width * f32(squares), 64.0);
    let place = vec2f(near_unit(at.uv.x, wrap.x), near_unit(at.uv.y, wrap.y)) * f32(squares);
    return 0.5 - 0.5 * wave_mean(place.x, width, squares, wrap.x) * wave_mean(place.y, width, squares, wrap.y);
}

// Returns an equivalent texture coordinate near 0, where f32 is precise enough.
fn near_unit(x: f32, wrap: u32) -> f32 {
    return select(x - 2.0 * floor(0.5 * x), clamp(x, -64.0, 65.0), wrap == WRAP_CLAMP);
}

// Returns the mean of a square wave over an interval of this width around `place`. The wave is 1 in a row's first
// square, -1 in its second and so on. It is wrapped like the texture.
fn wave_mean(place: f32, width: f32, squares: i32, wrap: u32) -> f32 {
    // For a small width, the difference of integrals would suffer from cancellation. The interval then contains one
    // edge at most.
    if width < 1.0 {
        let edge = floor(place + 0.5);
        let before = clamp((edge - place) / max(width, 1e-6) + 0.5, 0.0, 1.0);
        return mix(wave(i32(edge), squares, wrap), wave(i32(edge) - 1, squares, wrap), before);
    }
    return (wave_sum(place + 0.5 * width, squares, wrap) - wave_sum(place - 0.5 * width, squares, wrap)) / width;
}

fn wave(square: i32, squares: i32, wrap: u32) -> f32 {
    return f32(1 - 2 * (wrapped(square, squares, wrap) & 1));
}

// Returns the integral of the wave from 0 to x.
fn wave_sum(x: f32, squares: i32, wrap: u32) -> f32 {
    let all = f32(squares);
    let odd = f32(squares & 1);
    if wrap == WRAP_CLAMP {
        return zigzag(clamp(x, 0.0, all)) + min(x, 0.0) + max(x - all, 0.0) * (2.0 * odd - 1.0);
    }
    if wrap == WRAP_MIRROR {
        let turns = floor(0.5 * x / all);
        let y = x - 2.0 * all * turns;
        let there = zigzag(min(y, 2.0 * all - y));
        return 2.0 * odd * turns + select(there, 2.0 * odd - there, y > all);
    }
    let turns = floor(x / all);
    return odd * turns + zigzag(x - all * turns);
}

// Returns a triangle wave of period 2, which rises from 0 to 1 and falls again.
fn zigzag(x: f32) -> f32 {
    return 1.0 - abs(fract(0.5 * x) * 2.0 - 1.0);
}

// Returns a level's colour and alpha, filtered bilinearly between the centres of pixels.
fn level_color(level: u32, uv: vec2f, wrap: vec2u) -> vec4f {
    let texel = table_texel(level);
    let size = vec2i(texel.yz);
    // The first row is at the top.
    let place = vec2f(near_unit(uv.x, wrap.x), 1.0 - near_unit(uv.y, wrap.y)) * vec2f(size) - 0.5;
    let corner = vec2i(floor(place));
    let share = place - floor(place);
    let top = mix(
        level_pixel(texel.x, corner, size, wrap),
        level_pixel(texel.x, corner + vec2i(1, 0), size, wrap),
        share.x,
    );
    let bottom =
        mix(
            level_pixel(texel.x, corner + vec2i(0, 1), size, wrap),
            level_pixel(texel.x, corner + vec2i(1, 1), size, wrap),
            share.x,
        );
    return mix(top, bottom, share.y);
}

// Reads a pixel of a level. A texel holds two pixels of four 16-bit floats each: linear red, green and blue, and alpha.
fn level_pixel(first: u32, at: vec2i, size: vec2i, wrap: vec2u) -> vec4f {
    let index = u32(wrapped(at.y, size.y, wrap.y) * size.x + wrapped(at.x, size.x, wrap.x));
    let two = table_texel(first + index / 2u);
    let words = select(two.xy, two.zw, (index & 1u) == 1u);
    return vec4f(unpack2x16float(words.x), unpack2x16float(words.y));
}

fn wrapped(at: i32, size: i32, wrap: u32) -> i32 {
    if wrap == WRAP_CLAMP { return clamp(at, 0, size - 1); }
    // The index is made positive first, since a remainder has its dividend's sign.
    let turn = (at + 2 * size) % (2 * size);
    return select(turn % size, min(turn, 2 * size - 1 - turn), wrap == WRAP_MIRROR);
}

// Returns texture coordinates at a hit. The footprint is a square with the area of the pixel's footprint on the
// surface, so its side is the mean of both directions.
fn lookup_at(rays: Rays, hits: Hits, surface: Surface, ray: u32) -> Lookup {
    let direction = of_ray3(rays.direction, ray);
    let slot = of_ray_u(hits.slot, ray);
    let across = footprint(of_ray(hits.t, ray) + of_ray(travelled_before, ray), direction);
    // Directions have length 1 along the view axis. The directions of oblique pixels are longer, so they are not
    // normalised here.
    let side = across * inverseSqrt(max(abs(dot(surface.geometric_normal, direction)), 0.01));
    if (surface.component & IS_SPHERE) != 0u { return ball_lookup(surface.outward, surface.radius, side); }
    let corners = triangle_corners(slot);
    let weights = corner_weights(rays, corners, ray);
    let uv = triangle_uv(slot);
    let e = uv[1] - uv[0];
    let f = uv[2] - uv[0];
    let uv_area = abs(e.x * f.y - e.y * f.x);
    let longest = largest_one(cross(largest_one(corners[1] - corners[0]), largest_one(corners[2] - corners[0])));
    let normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
    let area = max(dot(normal, longest) / length(longest), 1e-30);
    return Lookup(uv[0] * weights.x + uv[1] * weights.y + uv[2] * weights.z, side * sqrt(uv_area / area), false);
}

// Returns texture coordinates on a sphere. Seen from outside, a texture's middle is at +z, its right at +x and its top
// at +y.
fn ball_lookup(outward: vec3f, radius: f32, side: f32) -> Lookup {
    let from_axis = length(outward.xz);
    let turn = select(atan2(outward.x, outward.z) / 6.2831853, 0.0, from_axis < 1e-7);
    let uv = vec2f(turn + 0.5, 1.0 - acos(clamp(outward.y, -1.0, 1.0)) / 3.14159265);
    // On the unit sphere, a unit of uv covers an area of 2 pi^2 times the distance from the axis.
    let area = 19.7392088 * max(from_axis, 0.01);
    return Lookup(uv, side / (max(radius, 1e-30) * sqrt(area)), true);
}

//! if uv is none
fn triangle_uv(slot: u32) -> array<vec2f, 3> {
    return array<vec2f, 3>();
}

//! if uv is some
fn triangle_uv(slot: u32) -> array<vec2f, 3> {
    // Coordinates are clamped: larger ones would look the same, but their products may overflow.
    let first = clamp(bitcast<vec4f>(primitive_texel(slot, UV_TEXEL)), vec4f(-1e15), vec4f(1e15));
    let second = clamp(bitcast<vec2f>(primitive_texel(slot, UV_TEXEL + 1u).xy), vec2f(-1e15), vec2f(1e15));
    return array<vec2f, 3>(first.xy, first.zw, second);
}

//! if colors is none
fn vertex_color(rays: Rays, hits: Hits, surface: Surface, ray: u32) -> vec3f {
    return vec3f(1.0);
}

//! if colors is some
// Unpacks a corner's colour: 10 bits of red, 12 of green and 10 of blue.
fn corner_color(word: u32) -> vec3f {
    let parts = vec3u(word & 1023u, (word >> 10u) & 4095u, word >> 22u);
    return vec3f(parts) / vec3f(1023.0, 4095.0, 1023.0);
}

fn vertex_color(rays: Rays, hits: Hits, surface: Surface, ray: u32) -> vec3f {
    if (surface.component & IS_SPHERE) != 0u { return vec3f(1.0); }
    let slot = of_ray_u(hits.slot, ray);
    let words = primitive_texel(slot, COLOR_TEXEL);
    let weights = corner_weights(rays, triangle_corners(slot), ray);
    return corner_color(words.x) * weights.x + corner_color(words.y) * weights.y + corner_color(words.z) * weights.z;
}
