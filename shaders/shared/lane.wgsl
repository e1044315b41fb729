// The rays of a lane: one or four. Traversal and shading are written once for both numbers.

//! if rays is one
// One thread traces one pixel. This variant is for GPUs.

alias F = f32;    // one number for each ray
alias U = u32;
alias B = bool;

const RAYS: u32 = 1u;
// Size of a lane's block in pixels, and the position of each ray in the block.
const BLOCK: vec2u = vec2u(1u, 1u);
const RAY_X: U = 0u;
const RAY_Y: U = 0u;
const RAY_INDEX: U = 0u;

fn any_ray(b: B) -> bool { return b; }
fn all_rays(b: B) -> bool { return b; }
fn count_rays(b: B) -> u32 { return select(0u, 1u, b); }
fn first_ray(b: B) -> u32 { return 0u; }
fn smallest(f: F) -> f32 { return f; }

fn of_ray(f: F, ray: u32) -> f32 { return f; }
fn of_ray_u(u: U, ray: u32) -> u32 { return u; }
fn of_ray_b(b: B, ray: u32) -> bool { return b; }
fn with_ray(f: F, ray: u32, value: f32) -> F { return value; }
fn with_ray_u(u: U, ray: u32, value: u32) -> U { return value; }
fn without_ray(b: B, ray: u32) -> B { return false; }

const RAY_BITS: u32 = 1u;
fn bits_of(b: B) -> u32 { return select(0u, 1u, b); }
fn with_bits(bits: u32) -> B { return (bits & 1u) != 0u; }

//! if rays is four
// A lane has four rays with one stack, from a block of 2x2 pixels or from four list entries. This variant is for CPU
// adapters. Loads are expensive there, and one load serves all four rays (docs/TRAVERSAL.md).

alias F = vec4f;    // one number for each ray
alias U = vec4u;
alias B = vec4<bool>;

const RAYS: u32 = 4u;
// Size of a lane's block in pixels, and the position of each ray in the block.
const BLOCK: vec2u = vec2u(2u, 2u);
const RAY_X: U = vec4u(0u, 1u, 0u, 1u);
const RAY_Y: U = vec4u(0u, 0u, 1u, 1u);
const RAY_INDEX: U = vec4u(0u, 1u, 2u, 3u);

fn any_ray(b: B) -> bool { return any(b); }
fn all_rays(b: B) -> bool { return all(b); }
fn count_rays(b: B) -> u32 { let n = select(vec4u(0u), vec4u(1u), b); return n.x + n.y + n.z + n.w; }
fn first_ray(b: B) -> u32 { return select(select(select(3u, 2u, b.z), 1u, b.y), 0u, b.x); }
fn smallest(f: F) -> f32 { return min(min(f.x, f.y), min(f.z, f.w)); }

fn of_ray(f: F, ray: u32) -> f32 { return f[ray]; }
fn of_ray_u(u: U, ray: u32) -> u32 { return u[ray]; }
fn of_ray_b(b: B, ray: u32) -> bool { return b[ray]; }
fn with_ray(f: F, ray: u32, value: f32) -> F { return select(f, F(value), RAY_INDEX == U(ray)); }
fn with_ray_u(u: U, ray: u32, value: u32) -> U { return select(u, U(value), RAY_INDEX == U(ray)); }
fn without_ray(b: B, ray: u32) -> B { return b & (RAY_INDEX != U(ray)); }

// Number of bits of a mask that has one bit for each ray.
const RAY_BITS: u32 = 4u;
fn bits_of(b: B) -> u32 { let n = select(U(0u), U(1u, 2u, 4u, 8u), b); return (n.x | n.y) | (n.z | n.w); }
fn with_bits(bits: u32) -> B { return (U(bits) & U(1u, 2u, 4u, 8u)) != U(0u); }

//! end
// Vectors and pixels of a lane's rays, for any number of rays.

// A vector for each ray.
struct F3 {
    x: F,
    y: F,
    z: F,
}

// A pixel for each ray.
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

// These functions replace min and max. The built-in functions also order NaN, which costs two more instructions each.
fn smaller(a: F, b: F) -> F { return select(b, a, a < b); }
fn larger(a: F, b: F) -> F { return select(b, a, a > b); }

fn largest_one(v: vec3f) -> vec3f {
    return v / max(max(abs(v.x), abs(v.y)), abs(v.z));
}
