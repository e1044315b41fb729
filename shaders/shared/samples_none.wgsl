// No method takes shadow bits over.
fn keep_sample(pixel: vec2u, samples: Samples, ray: u32) {}
