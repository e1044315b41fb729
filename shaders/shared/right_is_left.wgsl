// `Ideal`, the bound on what reuse can save, and every method's path where the interaxial is 0: right equals left.
fn right_picture(pixel: vec2u, left: u32) -> u32 {
    return left;
}
