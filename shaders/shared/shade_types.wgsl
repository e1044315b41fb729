// What shading reads of the scene besides its table (fetch_texture.wgsl, fetch_buffer.wgsl).

struct Shading {
    ambient: vec3f,       // linear RGB
    light_count: u32,
    sky_nadir: vec3f,     // linear RGB straight down
    _pad0: u32,
    sky_zenith: vec3f,    // linear RGB straight up, or everywhere
    _pad1: u32,
}
