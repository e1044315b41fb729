// Nobody wants linear colour.
fn take_linear(pixel: u32, place: u32) {}
