// Draws a window: `view` draws an eye's part of it, and `show` a picture of one or both parts with text over it. All
// colours are sRGB-encoded.
//
// reads   picture  for `view`, what was rendered for an eye; for `show`, what the window shows
// reads   panel    text with alpha, at the window's left edge from row `first_row` on

// The part of a view that an eye sees.
struct Part {
    // For equirectangular views: from a ray of the window (right, up, ahead) to the coordinates of the pair.
    to_pair: mat3x3f,
    // Size of the part in pixels.
    size: vec2f,
    // For equirectangular views: the share of a full turn that they show, and the tangent of a pixel's angle in the
    // window's middle. Both are 0 for planar views, which are stretched to the part's size.
    turn: f32,
    pixel: f32,
}

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var panel: texture_2d<f32>;
@group(0) @binding(2) var<uniform> part: Part;
@group(0) @binding(3) var between: sampler;
@group(0) @binding(4) var<uniform> first_row: vec4u;

const PI = 3.14159265;

@vertex
fn whole_target(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(4.0 * f32(index & 1u) - 1.0, 4.0 * f32(index >> 1u) - 1.0, 0.0, 1.0);
}

@fragment
fn view(@builtin(position) position: vec4f) -> @location(0) vec4f {
    var place = position.xy / part.size;
    if part.turn > 0.0 {
        let at = part.pixel * (position.xy - 0.5 * part.size);
        let ray = part.to_pair * vec3f(at.x, -at.y, 1.0);
        place = vec2f(atan2(ray.x, ray.z) / (2.0 * PI * part.turn), -atan2(ray.y, length(ray.xz)) / PI) + 0.5;
        if part.turn < 1.0 && abs(place.x - 0.5) > 0.5 { return vec4f(0.0, 0.0, 0.0, 1.0); }
    }
    return textureSampleLevel(picture, between, place, 0.0);
}

@fragment
fn show(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = vec2u(position.xy);
    // In a window of odd width, one column belongs to no eye.
    var color = vec3f(0.0);
    if all(place < textureDimensions(picture)) { color = textureLoad(picture, place, 0).rgb; }
    // Above the first row this is no place of the panel, since it wraps around.
    let written = vec2u(place.x, place.y - first_row.x);
    if all(written < textureDimensions(panel)) {
        let text = textureLoad(panel, written, 0);
        color = mix(color, text.rgb, text.a);
    }
    return vec4f(color, 1.0);
}
