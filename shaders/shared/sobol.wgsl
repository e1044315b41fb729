// Random points of paths: the Sobol (0,2)-sequence, shuffled and scrambled for each pixel and dimension (Burley 2020,
// "Practical Hash-based Owen Scrambling").

//! use dice, frame

//! if light is paths
// Number of the current path among those of its pixel, and a random word of the pixel.
var<private> path_number: u32;
var<private> pixel_word: u32;

fn begin_points(pixel: vec2u, number: u32) {
    path_number = number;
    pixel_word = scrambled(vec3u(pixel.x, pixel.y + frame.band.first_row, frame.lighting.seed)).x;
}

// Permutes numbers so that each bit depends on the lower bits only (Laine & Karras 2011, "Stratified Sampling for
// Stochastic Transparency"). Applied to reversed bits, this is an Owen scrambling.
fn permuted(bits: u32, seed: u32) -> u32 {
    var x = bits + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    return x ^ (x * 0x8d22f6e6u);
}

// Returns the product of a number's bits with Pascal's triangle modulo 2: the second dimension of the sequence, with
// reversed bits.
fn second_dimension(index: u32) -> u32 {
    var x = index;
    x ^= (x >> 1u) & 0x55555555u;
    x ^= (x >> 2u) & 0x33333333u;
    x ^= (x >> 4u) & 0x0f0f0f0fu;
    x ^= (x >> 8u) & 0x00ff00ffu;
    return x ^ (x >> 16u);
}

// Returns the current path's point in a pair of dimensions, in [0, 1).
fn random_point(pair: u32) -> vec2f {
    let seeds = scrambled(vec3u(pixel_word, pair, 0x9e3779b9u));
    let index = reverseBits(permuted(reverseBits(path_number), seeds.x));
    let bits = vec2u(permuted(index, seeds.y), permuted(second_dimension(index), seeds.z));
    return vec2f(reverseBits(bits) >> vec2u(8u)) / 16777216.0;
}
