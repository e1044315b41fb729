// Layout of the shading table. A texel holds the bits of three floats in x, y and z. The table is not a uniform buffer:
// Mesa's software driver recompiles a kernel for each dispatch in which a loop's end is a uniform.

//! use fetch

const AMBIENT: u32 = 0u;      // linear RGB; the number of lights in w
// Linear RGB of the sky straight down. For a map: first texel, width and height. w holds the index of the first texture
// head.
const SKY_NADIR: u32 = 1u;
const SKY_ZENITH: u32 = 2u;   // linear RGB straight up, or of the whole sky
// First texel of the lights, LIGHT_TEXELS each: position and kind, intensity and size, two sides for some kinds, three
// texels of a projector (projectors.wgsl). The materials follow (materials.wgsl), then a map's pixels, then textures
// (textures.wgsl).
const LIGHTS: u32 = 3u;

fn shading_vector(index: u32) -> vec3f {
    return bitcast<vec3f>(table_texel(index).xyz);
}

// Texel of the shading table whose w is the index of the first texture head. There is one head per texture.
const TEXTURES: u32 = SKY_NADIR;

// Texel of the shading table whose w is the index of a texel with what paths need: first texel of the shares that
// facets reflect (facets.wgsl), first texel and number of the emitting primitives (emitters.wgsl), and their total
// power.
const FOR_PATHS: u32 = SKY_ZENITH;

// Result of a search in cumulative shares, which are stored in w of texels. `index` is the first texel whose w exceeds
// the given share. `within` is the position of the share between the previous texel's w and its own, 0 to 1. The last
// texel's w counts as 1.
struct TexelOver {
    index: u32,
    within: f32,
}

fn texel_over(share: f32, first: u32, stride: u32, count: u32) -> TexelOver {
    var low = 0u;
    var high = count - 1u;
    var below = 0.0;
    var above = 1.0;
    loop {
        if low >= high { break; }
        let middle = (low + high) / 2u;
        let here = bitcast<f32>(table_texel(first + stride * middle).w);
        if here > share {
            high = middle;
            above = here;
        } else {
            low = middle + 1u;
            below = here;
        }
    }
    return TexelOver(low, select(0.5, clamp((share - below) / (above - below), 0.0, 1.0), above > below));
}
