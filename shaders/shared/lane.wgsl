// Vectors and pixels of a lane's rays, whatever their number (rays_1.wgsl, rays_2x2.wgsl).

// A vector for each of the lane's rays.
struct F3 {
    x: F,
    y: F,
    z: F,
}

// A pixel for each of the lane's rays.
struct Pixels {
    x: U,
    y: U,
}

fn all3(v: vec3f) -> F3 { return F3(F(v.x), F(v.y), F(v.z)); }
fn add3(a: F3, b: F3) -> F3 { return F3(a.x + b.x, a.y + b.y, a.z + b.z); }
fn minus3(a: F3, b: F3) -> F3 { return F3(a.x - b.x, a.y - b.y, a.z - b.z); }
fn times3(a: F3, b: F) -> F3 { return F3(a.x * b, a.y * b, a.z * b); }
fn product3(a: F3, b: F3) -> F3 { return F3(a.x * b.x, a.y * b.y, a.z * b.z); }
fn dot3(a: F3, b: F3) -> F { return a.x * b.x + a.y * b.y + a.z * b.z; }
fn select3(a: F3, b: F3, choose_b: B) -> F3 {
    return F3(select(a.x, b.x, choose_b), select(a.y, b.y, choose_b), select(a.z, b.z, choose_b));
}
fn of_ray3(v: F3, ray: u32) -> vec3f { return vec3f(of_ray(v.x, ray), of_ray(v.y, ray), of_ray(v.z, ray)); }
fn with_ray3(v: F3, ray: u32, value: vec3f) -> F3 {
    return F3(with_ray(v.x, ray, value.x), with_ray(v.y, ray, value.y), with_ray(v.z, ray, value.z));
}

fn pixel_of_ray(pixels: Pixels, ray: u32) -> vec2u {
    return vec2u(of_ray_u(pixels.x, ray), of_ray_u(pixels.y, ray));
}

// The pixels of a thread of a launch over blocks.
fn block_pixels(id: vec3u) -> Pixels {
    let first = pixel_in_tile(vec2u(id.x, launched_row(id))) * BLOCK + vec2u(0u, frame.row_begin);
    return Pixels(RAY_X + U(first.x), RAY_Y + U(first.y));
}

// Which of them are of the picture and of this dispatch's rows.
fn inside_rows(pixels: Pixels) -> B {
    return (pixels.x < U(frame.image_size.x)) & (pixels.y < U(frame.row_end));
}

// Directions from an eye through the pixels' centres.
fn pixel_directions(corner: vec3f, pixels: Pixels) -> F3 {
    let x = F(pixels.x) + 0.5;
    let y = F(pixels.y + frame.first_row) + 0.5;
    return F3(
        corner.x + frame.step_x.x * x + frame.step_y.x * y,
        corner.y + frame.step_x.y * x + frame.step_y.y * y,
        corner.z + frame.step_x.z * x + frame.step_y.z * y,
    );
}
