// One ray a lane, a thread a pixel: for GPUs. Twin of rays_2x2.wgsl: same names, so that one text of traversal and shading
// serves both.

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
