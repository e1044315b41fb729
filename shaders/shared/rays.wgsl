// A lane's rays, one or four: one text of traversal and shading serves both.

//! if rays is one
// A thread a pixel: for GPUs.

alias F = f32;    // a number for each of the lane's rays
alias U = u32;
alias B = bool;

const RAYS: u32 = 1u;
// Pixels of a lane's block in x and y, and each ray's place in it.
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

const RAY_BITS: u32 = 1u;
fn bits_of(b: B) -> u32 { return select(0u, 1u, b); }
fn with_bits(bits: u32) -> B { return (bits & 1u) != 0u; }

//! if rays is four
// Those of a block of 2x2 pixels or of four entries of a list, on one stack: for CPU adapters, where loads are dear and what is
// loaded serves all four (docs/TRAVERSAL.md).

alias F = vec4f;    // a number for each of the lane's rays
alias U = vec4u;
alias B = vec4<bool>;

const RAYS: u32 = 4u;
// Pixels of a lane's block in x and y, and each ray's place in it.
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

// A bit for each ray.
const RAY_BITS: u32 = 4u;
fn bits_of(b: B) -> u32 { let n = select(U(0u), U(1u, 2u, 4u, 8u), b); return (n.x | n.y) | (n.z | n.w); }
fn with_bits(bits: u32) -> B { return (U(bits) & U(1u, 2u, 4u, 8u)) != U(0u); }
