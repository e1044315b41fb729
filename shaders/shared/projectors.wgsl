// Pictures that point lights project.

//! use fetch, lane, table, textures

//! if projectors is none
// Returns a light's intensity towards the points of a lane's rays. `straight` leads from the light to the points.
fn intensities_along(light: u32, intensity: vec3f, straight: F3) -> F3 { return all3(intensity); }

// Returns a light's intensity towards a point, from which `to_light` leads to the light.
fn intensity_along(light: u32, intensity: vec3f, to_light: vec3f) -> vec3f { return intensity; }

//! if projectors is some
fn intensities_along(light: u32, intensity: vec3f, straight: F3) -> F3 {
    var all = all3(intensity);
    var ray = 0u;
    loop {
        all = with_ray3(all, ray, intensity_along(light, intensity, -of_ray3(straight, ray)));
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return all;
}

// The last three texels of a light are a projector's: vectors to the right and up, and the unit direction. Along a ray
// whose part in the direction is 1, the picture's edges lie where the parts along the first two vectors are -1 and 1.
// The w of the first texel is the texture's number plus one, or 0.
fn intensity_along(light: u32, intensity: vec3f, to_light: vec3f) -> vec3f {
    let first = LIGHTS + LIGHT_TEXELS * light + 4u;
    let right = table_texel(first);
    if right.w == 0u { return intensity; }
    let ahead = -dot(shading_vector(first + 2u), to_light);
    let aside = -vec2f(dot(bitcast<vec3f>(right.xyz), to_light), dot(shading_vector(first + 1u), to_light));
    if !(ahead > 0.0) || any(abs(aside) > vec2f(ahead)) { return vec3f(0.0); }
    return intensity * picture_color(table_texel(TEXTURES).w + right.w - 1u, 0.5 + 0.5 * aside / ahead);
}

// Returns the colour of a texture's largest level, which does not repeat.
fn picture_color(head_at: u32, uv: vec2f) -> vec3f {
    let head = table_texel(head_at);
    let wrap = vec2u(WRAP_CLAMP);
    if (head.x & 15u) != CHECKERBOARD { return level_color(head.y, uv, wrap).rgb; }
    let share = checkered(Lookup(uv, 0.0, false), i32(head.z), wrap);
    return mix(shading_vector(head.y), shading_vector(head.y + 1u), share);
}
