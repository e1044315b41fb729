// Makes one picture of both eyes' pictures, for coloured glasses, displays or free viewing.
//
// launch  one thread per pixel of the picture
// reads   left_picture, right_picture  [height, width]  sRGB-encoded
// writes  picture                      sRGB-encoded, alpha 1

//! use pixels

struct Combining {
    // Linear light of each encoded byte, with four values per vector.
    decoded: array<vec4f, 64>,
    of_left: mat3x3f,       // for MIXED: light of the picture by light of each eye
    of_right: mat3x3f,
    size: vec2u,            // of an eye's picture
    arrangement: u32,
    _pad: u32,
}

var<uniform> combining: Combining;
var left_picture: texture_2d<f32>;
var right_picture: texture_2d<f32>;
var picture: texture_storage_2d<rgba8unorm, write>;

// Arrangements of both eyes.
const MIXED: u32 = 0u;
const BESIDE: u32 = 1u;
const CROSSED: u32 = 2u;
const HALF_BESIDE: u32 = 3u;
const STACKED: u32 = 4u;
const HALF_STACKED: u32 = 5u;
const ROWS: u32 = 6u;
const COLUMNS: u32 = 7u;
const CHECKERBOARD: u32 = 8u;

fn encoded_at(is_right: bool, place: vec2u) -> vec3f {
    if is_right { return textureLoad(right_picture, place, 0).rgb; }
    return textureLoad(left_picture, place, 0).rgb;
}

fn light_of(encoded: vec3f) -> vec3f {
    let byte = vec3u(round(encoded * 255.0));
    return vec3f(
        combining.decoded[byte.r / 4u][byte.r % 4u],
        combining.decoded[byte.g / 4u][byte.g % 4u],
        combining.decoded[byte.b / 4u][byte.b % 4u],
    );
}

// Returns the sRGB code of light, rounded to whole bytes (IEC 61966-2-1).
fn encoded_of(light: vec3f) -> vec3f {
    let bounded = clamp(light, vec3f(0.0), vec3f(1.0));
    let bent = 1.055 * pow(bounded, vec3f(1.0 / 2.4)) - 0.055;
    let encoded = select(bent, 12.92 * bounded, bounded <= vec3f(0.0031308));
    return floor(encoded * 255.0 + 0.5) / 255.0;
}

// Returns the mean light of two pixels of an eye. The last pixel of an odd number stands alone.
fn mean(is_right: bool, first: vec2u, step: vec2u) -> vec3f {
    let second = min(first + step, combining.size - 1u);
    return encoded_of(0.5 * (light_of(encoded_at(is_right, first)) + light_of(encoded_at(is_right, second))));
}

fn combined(place: vec2u) -> vec3f {
    let size = combining.size;
    switch combining.arrangement {
        case BESIDE, CROSSED: {
            let is_second = place.x >= size.x;
            let is_right = is_second == (combining.arrangement == BESIDE);
            return encoded_at(is_right, vec2u(select(place.x, place.x - size.x, is_second), place.y));
        }
        case HALF_BESIDE: {
            let half = (size.x + 1u) / 2u;
            let is_right = place.x >= half;
            return mean(is_right, vec2u(2u * select(place.x, place.x - half, is_right), place.y), vec2u(1u, 0u));
        }
        case STACKED: {
            let is_right = place.y >= size.y;
            return encoded_at(is_right, vec2u(place.x, select(place.y, place.y - size.y, is_right)));
        }
        case HALF_STACKED: {
            let half = (size.y + 1u) / 2u;
            let is_right = place.y >= half;
            return mean(is_right, vec2u(place.x, 2u * select(place.y, place.y - half, is_right)), vec2u(0u, 1u));
        }
        case ROWS: { return encoded_at(place.y % 2u == 1u, place); }
        case COLUMNS: { return encoded_at(place.x % 2u == 1u, place); }
        case CHECKERBOARD: { return encoded_at((place.x + place.y) % 2u == 1u, place); }
        default: {
            let of_left = combining.of_left * light_of(encoded_at(false, place));
            return encoded_of(of_left + combining.of_right * light_of(encoded_at(true, place)));
        }
    }
}

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn combine(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(picture)) { return; }
    textureStore(picture, id.xy, vec4f(combined(id.xy), 1.0));
}
