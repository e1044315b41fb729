// Layout of the shading table. A texel holds the bits of three floats in x, y and z. The table is not a uniform buffer:
// Mesa's software driver recompiles a kernel for each dispatch in which a loop's end is a uniform.

//! use fetch

const AMBIENT: u32 = 0u;      // linear RGB; the number of lights in w
// Linear RGB of the sky straight down. For a map: first texel, width and height. w holds the index of the first texture
// head.
const SKY_NADIR: u32 = 1u;
const SKY_ZENITH: u32 = 2u;   // linear RGB straight up, or of the whole sky
// First texel of the lights, LIGHT_TEXELS each: position and kind, intensity and size, two sides for some kinds. The
// materials follow (materials.wgsl), then a map's pixels, then textures (textures.wgsl).
const LIGHTS: u32 = 3u;

fn shading_vector(index: u32) -> vec3f {
    return bitcast<vec3f>(table_texel(index).xyz);
}

// Texel of the shading table whose w is the index of the first texture head. There is one head per texture.
const TEXTURES: u32 = SKY_NADIR;
