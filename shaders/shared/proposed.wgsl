// Light that is proposed to the newest vertices of paths, one per pixel of a band (shaders/paths/scatter_paths.wgsl).

//! use emitters

//! if light is paths
struct Proposed {
    start: vec3f,               // where the rays to the light begin
    is_open: u32,               // 1 if light is proposed
    emitted: vec3f,             // light that the vertex sends to the path anyway
    travelled: f32,             // path's length before the ray that found the vertex
    weight: vec3f,              // of that ray, at the vertex
    is_diffuse: u32,            // as in Path
    albedo: vec3f,              // multiplies light that the vertex reflects diffusely
    _pad: u32,
    rays: array<LightRay, 3>,   // to a light, an emitting surface and the sky
}
