// Samples of an earlier frame's view, and where they are in the current view (docs/BRACKET.md, "Earlier frames").

//! use frame, pixels

// Samples like those of source_samples.wgsl. The row after the last one begins with the eye of the earlier frame, one
// vector a texel. Boxes around objects that have moved since follow, two texels each. w of the first four texels holds
// the number of the frame, the lights whose bits hold, the number of boxes, and that of paths per sample.
var history: texture_2d<u32>;

// The eye of the earlier frame: its position, and directions to the picture's top left corner and from a pixel to its
// right neighbour and to the one below.
struct EarlierEye {
    place: vec3f,
    corner: vec3f,
    step_x: vec3f,
    step_y: vec3f,
}

fn history_size() -> vec2u { return textureDimensions(history) - vec2u(0u, 1u); }

fn earlier_eye() -> EarlierEye { return EarlierEye(eye_word(0u), eye_word(1u), eye_word(2u), eye_word(3u)); }

fn eye_word(index: u32) -> vec3f {
    return bitcast<vec3f>(textureLoad(history, vec2u(index, history_size().y), 0).xyz);
}

fn eye_tag(index: u32) -> u32 { return textureLoad(history, vec2u(index, history_size().y), 0).w; }

// Returns the number of the earlier frame in its film.
fn earlier_frame() -> u32 { return eye_tag(0u); }

// Where a sample lands in the current view: column and row in pixels, and depth; 0 behind the eye.
struct Landed {
    place: vec2f,
    depth: f32,
}

//! if camera is around
// Equirectangular views have no history.
fn landed_of(eye: EarlierEye, pixel: vec2u) -> Landed { return Landed(vec2f(0.0), 0.0); }

//! if camera is planar
fn landed_of(eye: EarlierEye, pixel: vec2u) -> Landed {
    let depth = bitcast<f32>(textureLoad(history, pixel, 0).x);
    let at = vec2f(pixel) + 0.5;
    let direction = eye.corner + eye.step_x * at.x + eye.step_y * at.y;
    // Where a ray missed, its direction counts.
    let is_sky = depth >= FAR;
    let there = select(direction * depth + (eye.place - frame.eyes.target_eye), direction, is_sky);
    let ahead = dot(there, frame.eyes.forward);
    if !(ahead > 0.0) || depth <= 0.0 { return Landed(vec2f(0.0), 0.0); }
    let aside = there / ahead - frame.eyes.target_corner;
    return Landed(in_steps_of(aside, frame.eyes.step_x, frame.eyes.step_y), select(ahead, FAR, is_sky));
}

//! end
// Returns the column and row of a place on an eye's screen, given from the picture's corner, in pixels.
fn in_steps_of(aside: vec3f, step_x: vec3f, step_y: vec3f) -> vec2f {
    return vec2f(dot(aside, step_x) / dot(step_x, step_x), dot(aside, step_y) / dot(step_y, step_y));
}
