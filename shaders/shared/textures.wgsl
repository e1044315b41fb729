// Textures: pictures with their mip levels, and checkerboards, in the shading table behind the sky's pixels.

// How far the rays came before they began: what mirrors and glass sent on.
var<private> travelled_before: F;

//! if textures is none
fn texture_factor(rays: Rays, hits: Hits, surface: Surface, ray: u32) -> vec3f {
    return vec3f(1.0);
}

//! if textures is some
// Of the shading table: the texel whose w is the first of the textures' heads, one each.
const TEXTURES: u32 = SKY_NADIR;

// A texture's head: its kind in the lowest four bits of x and its wrap above them. A picture has z levels, from the largest on, from the
// texel y on: first texel, width and height each. A checkerboard has z squares a side; its colours are the texels y and y + 1.
const CHECKERBOARD: u32 = 1u;
const WRAP_MIRROR: u32 = 1u;
const WRAP_CLAMP: u32 = 2u;

// Where a texture is looked up.
struct Lookup {
    uv: vec2f,
    width: f32,    // of the ray's footprint, in units of uv
}

// What textures and vertex colours multiply the albedo by where a ray hits.
fn texture_factor(rays: Rays, hits: Hits, surface: Surface, ray: u32) -> vec3f {
    let texture = material_texel(surface.material, MATERIAL_ALBEDO).w & MATERIAL_TEXTURE;
    let painted = vertex_color(rays, hits, surface, ray);
    if texture == 0u { return painted; }
    return painted * texture_color(table_texel(TEXTURES).w + texture - 1u, lookup_at(rays, hits, surface, ray));
}

fn texture_color(head_at: u32, at: Lookup) -> vec3f {
    let head = table_texel(head_at);
    let wrap = head.x >> 4u;
    if (head.x & 15u) == CHECKERBOARD {
        let first = bitcast<vec3f>(table_texel(head.y).xyz);
        let other = bitcast<vec3f>(table_texel(head.y + 1u).xyz);
        return mix(first, other, checkered(at, f32(head.z), wrap));
    }
    let largest = table_texel(head.y);
    let widest = f32(max(largest.y, largest.z));
    let level = clamp(log2(max(at.width * widest, 1e-9)), 0.0, f32(head.z - 1u));
    let finer = u32(level);
    let color = level_color(head.y + finer, at.uv, wrap);
    let share = level - f32(finer);
    if share == 0.0 { return color; }
    return mix(color, level_color(head.y + finer + 1u, at.uv, wrap), share);
}

// The other colour's share in a box of the footprint's width, exactly: the integral of a square wave (Quilez 2016, "Filterable
// procedurals").
fn checkered(at: Lookup, squares: f32, wrap: u32) -> f32 {
    let uv = select(at.uv, clamp(at.uv, vec2f(0.0), vec2f(1.0 - 1e-6)), wrap == WRAP_CLAMP);
    let place = select(uv, vec2f(mirrored_unit(uv.x), mirrored_unit(uv.y)), wrap == WRAP_MIRROR) * squares;
    let width = clamp(at.width * squares, 1e-4, 64.0);
    let a = abs(fract((place - 0.5 * width) * 0.5) - 0.5);
    let b = abs(fract((place + 0.5 * width) * 0.5) - 0.5);
    let wave = 2.0 * (a - b) / width;
    return 0.5 + 0.5 * wave.x * wave.y;
}

// There and back again between 0 and 1.
fn mirrored_unit(x: f32) -> f32 {
    return 1.0 - abs(fract(0.5 * x) * 2.0 - 1.0);
}

// Bilinear, between the centres of a level's pixels.
fn level_color(level: u32, uv: vec2f, wrap: u32) -> vec3f {
    let texel = table_texel(level);
    let size = vec2i(texel.yz);
    // Kept near 0, where f32 is fine; the first row is at the top.
    let kept = select(uv - 2.0 * floor(0.5 * uv), clamp(uv, vec2f(-1.0), vec2f(2.0)), wrap == WRAP_CLAMP);
    let place = vec2f(kept.x, 1.0 - kept.y) * vec2f(size) - 0.5;
    let corner = vec2i(floor(place));
    let share = place - floor(place);
    let top = mix(level_pixel(texel.x, corner, size, wrap), level_pixel(texel.x, corner + vec2i(1, 0), size, wrap), share.x);
    let bottom =
        mix(level_pixel(texel.x, corner + vec2i(0, 1), size, wrap), level_pixel(texel.x, corner + vec2i(1, 1), size, wrap), share.x);
    return mix(top, bottom, share.y);
}

// Two a texel, each four halves: linear red, green and blue, and alpha.
fn level_pixel(first: u32, at: vec2i, size: vec2i, wrap: u32) -> vec3f {
    let index = u32(wrapped(at.y, size.y, wrap) * size.x + wrapped(at.x, size.x, wrap));
    let two = table_texel(first + index / 2u);
    let words = select(two.xy, two.zw, (index & 1u) == 1u);
    return vec3f(unpack2x16float(words.x), unpack2x16float(words.y).x);
}

fn wrapped(at: i32, size: i32, wrap: u32) -> i32 {
    if wrap == WRAP_CLAMP { return clamp(at, 0, size - 1); }
    // Above 0, since a remainder has its dividend's sign.
    let turn = (at + 16 * size) % (2 * size);
    return select(turn % size, min(turn, 2 * size - 1 - turn), wrap == WRAP_MIRROR);
}

// Texture coordinates where a ray hits. A ball's go round it from -z as a sky's columns do, v from its lowest point to its highest. The
// footprint is a square as large as the pixel's shadow on the surface, so its side is that of the mean of both directions.
fn lookup_at(rays: Rays, hits: Hits, surface: Surface, ray: u32) -> Lookup {
    let direction = of_ray3(rays.direction, ray);
    let slot = of_ray_u(hits.slot, ray);
    let across = (of_ray(hits.t, ray) + of_ray(travelled_before, ray)) * length(frame.step_x);
    let slant = max(abs(dot(surface.geometric_normal, direction)) / length(direction), 0.01);
    let side = across / sqrt(slant);
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
    return Lookup(uv[0] * weights.x + uv[1] * weights.y + uv[2] * weights.z, side * sqrt(uv_area / area));
}

fn ball_lookup(outward: vec3f, radius: f32, side: f32) -> Lookup {
    let upright = max(abs(outward.x), abs(outward.z)) < 1e-7;
    let turn = select(atan2(outward.x, -outward.z) / 6.2831853, 0.0, upright);
    let uv = vec2f(turn + 0.5, 1.0 - acos(clamp(outward.y, -1.0, 1.0)) / 3.14159265);
    return Lookup(uv, side / (3.14159265 * max(radius, 1e-30)));
}

//! if uv is none
fn triangle_uv(slot: u32) -> array<vec2f, 3> {
    return array<vec2f, 3>();
}

//! if uv is some
fn triangle_uv(slot: u32) -> array<vec2f, 3> {
    let first = bitcast<vec4f>(primitive_texel(slot, UV_TEXEL));
    let second = bitcast<vec2f>(primitive_texel(slot, UV_TEXEL + 1u).xy);
    return array<vec2f, 3>(first.xy, first.zw, second);
}

//! if colors is none
fn vertex_color(rays: Rays, hits: Hits, surface: Surface, ray: u32) -> vec3f {
    return vec3f(1.0);
}

//! if colors is some
// Each corner's packed as 10 bits of red, 12 of green and 10 of blue.
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
