// Draws a pixel of the window: both views mixed by two matrices, or side by side, with text over them. Of
// equirectangular views it draws planar parts.
//
// reads   left, right   [height * width]  the views, sRGB-encoded; stretched to the window if their size differs
// reads   panel         text with alpha, sRGB-encoded, at the window's top left corner

struct Shown {
    // Linear light of each encoded byte, with four values per vector. Drivers decode sRGB textures by approximations.
    // Their errors become visible where a matrix subtracts dark channels.
    decoded: array<vec4f, 64>,
    of_left: mat3x3f,
    of_right: mat3x3f,
    // For equirectangular views: from a ray of the window (right, up, ahead) to the coordinates of the pair.
    left_to_pair: mat3x3f,
    right_to_pair: mat3x3f,
    // Size of the window in pixels, or of one eye's half if views are side by side.
    size: vec2u,
    beside: u32,
    // 1 if the target takes sRGB-encoded values, 0 if it takes linear light.
    encoded: u32,
    // For equirectangular views: the share of a full turn that they show, and the tangent of a pixel's angle in the
    // window's middle. Both are 0 for planar views.
    turn: f32,
    pixel: f32,
}

@group(0) @binding(0) var<uniform> shown: Shown;
@group(0) @binding(1) var left: texture_2d<f32>;
@group(0) @binding(2) var right: texture_2d<f32>;
@group(0) @binding(3) var panel: texture_2d<f32>;
@group(0) @binding(4) var stretch: sampler;
@group(0) @binding(5) var wrap: sampler;

const PI = 3.14159265;

@vertex
fn whole_window(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(4.0 * f32(index & 1u) - 1.0, 4.0 * f32(index >> 1u) - 1.0, 0.0, 1.0);
}

fn decode(encoded: vec3f) -> vec3f {
    let byte = vec3u(round(encoded * 255.0));
    return vec3f(
        shown.decoded[byte.r / 4u][byte.r % 4u],
        shown.decoded[byte.g / 4u][byte.g % 4u],
        shown.decoded[byte.b / 4u][byte.b % 4u],
    );
}

// Returns the light that an eye of an equirectangular pair sees at a place of the window.
fn light_around(eye: texture_2d<f32>, to_pair: mat3x3f, place: vec2u) -> vec3f {
    let at = shown.pixel * (vec2f(place) + 0.5 - 0.5 * vec2f(shown.size));
    let ray = to_pair * vec3f(at.x, -at.y, 1.0);
    let column = 0.5 + atan2(ray.x, ray.z) / (2.0 * PI * shown.turn);
    let row = 0.5 - atan2(ray.y, length(ray.xz)) / PI;
    if shown.turn < 1.0 && abs(column - 0.5) > 0.5 { return vec3f(0.0); }
    return decode(textureSampleLevel(eye, wrap, vec2f(column, row), 0.0).rgb);
}

fn light(eye: texture_2d<f32>, to_pair: mat3x3f, place: vec2u) -> vec3f {
    if shown.turn > 0.0 { return light_around(eye, to_pair, place); }
    // A view that needs no stretching is shown without interpolation.
    if all(textureDimensions(eye) == shown.size) { return decode(textureLoad(eye, place, 0).rgb); }
    return decode(textureSampleLevel(eye, stretch, (vec2f(place) + 0.5) / vec2f(shown.size), 0.0).rgb);
}

fn encode(light: f32) -> f32 {
    return select(1.055 * pow(light, 1.0 / 2.4) - 0.055, 12.92 * light, light <= 0.0031308);
}

@fragment
fn show(@builtin(position) position: vec4f) -> @location(0) vec4f {
    var place = vec2u(position.xy);
    let second = shown.beside != 0u && place.x >= shown.size.x;
    if second { place.x -= shown.size.x; }
    // In a window of odd width, one column belongs to no eye.
    if any(place >= shown.size) { return vec4f(0.0, 0.0, 0.0, 1.0); }
    var color: vec3f;
    if shown.beside == 0u {
        color = shown.of_left * light(left, shown.left_to_pair, place);
        color += shown.of_right * light(right, shown.right_to_pair, place);
    } else if second {
        color = light(right, shown.right_to_pair, place);
    } else {
        color = light(left, shown.left_to_pair, place);
    }
    color = clamp(color, vec3f(0.0), vec3f(1.0));
    if all(place < textureDimensions(panel)) {
        let text = textureLoad(panel, place, 0);
        color = mix(color, decode(text.rgb), text.a);
    }
    if shown.encoded != 0u { color = vec3f(encode(color.r), encode(color.g), encode(color.b)); }
    return vec4f(color, 1.0);
}
