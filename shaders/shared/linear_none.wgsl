// Nobody wants linear colour.
fn keep_linear(pixel: u32, color: vec3f) {}
