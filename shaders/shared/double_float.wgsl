// Numbers stored as sums of two f32, with twice the precision (Dekker 1971; Knuth, TAOCP 2, 4.2.2). They are used if an
// eye or a light is so close to a large triangle or sphere that f32 is too coarse.
//
// Components of vectors are computed one after the other. Compilers for GPUs interleave operations on whole vectors,
// which takes more registers in rare long computations (docs/TRAVERSAL.md).

//! use fetch

struct Two { hi: f32, lo: f32 }
struct Two3 { hi: vec3f, lo: vec3f }

// Returns the same value, hidden from the compiler. Otherwise a compiler simplifies (a + b) - a to b, and the rounding
// error is lost.
fn opaque(v: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(v) ^ bvh.zero);
}

// Returns a - b exactly.
fn difference(a: f32, b: f32) -> Two {
    let hi = opaque(a - b);
    let taken = opaque(hi - a);
    return Two(hi, (a - (hi - taken)) - (b + taken));
}

fn difference3(a: vec3f, b: vec3f) -> Two3 {
    let x = difference(a.x, b.x);
    let y = difference(a.y, b.y);
    let z = difference(a.z, b.z);
    return Two3(vec3f(x.hi, y.hi, z.hi), vec3f(x.lo, y.lo, z.lo));
}

fn upper_half(a: f32) -> f32 {
    let c = a * 4097.0;
    return c - opaque(c - a);
}

fn product_two(a: Two, b: Two) -> Two {
    let hi = a.hi * b.hi;
    let a_high = upper_half(a.hi);
    let b_high = upper_half(b.hi);
    let a_low = a.hi - a_high;
    let b_low = b.hi - b_high;
    // Each sum is kept separate, since compilers factor out common terms.
    let first = opaque(a_high * b_high - hi);
    let second = opaque(first + a_high * b_low);
    let third = opaque(second + a_low * b_high);
    let lo = opaque(third + a_low * b_low);
    return Two(hi, lo + (a.hi * b.lo + a.lo * b.hi));
}

// Returns the componentwise products exactly, as product_two does. Every ray tests edges by them, and all components
// together take fewer registers here.
fn exact_product3(a: vec3f, b: vec3f) -> Two3 {
    let hi = a * b;
    let a_high = upper_half3(a);
    let b_high = upper_half3(b);
    let a_low = a - a_high;
    let b_low = b - b_high;
    let first = opaque3(a_high * b_high - hi);
    let second = opaque3(first + a_high * b_low);
    let third = opaque3(second + a_low * b_high);
    return Two3(hi, opaque3(third + a_low * b_low));
}

fn upper_half3(a: vec3f) -> vec3f {
    let c = a * 4097.0;
    return c - opaque3(c - a);
}

fn opaque3(v: vec3f) -> vec3f {
    return bitcast<vec3f>(bitcast<vec3u>(v) ^ vec3u(bvh.zero));
}

fn sum_two(a: Two, b: Two) -> Two {
    let hi = opaque(a.hi + b.hi);
    let taken = opaque(hi - a.hi);
    let lo = (a.hi - (hi - taken)) + (b.hi - taken) + (a.lo + b.lo);
    let sum = opaque(hi + lo);
    return Two(sum, lo - (sum - hi));
}

fn dot_two3(a: Two3, b: Two3) -> Two {
    let x = product_two(Two(a.hi.x, a.lo.x), Two(b.hi.x, b.lo.x));
    let xy = sum_two(x, product_two(Two(a.hi.y, a.lo.y), Two(b.hi.y, b.lo.y)));
    return sum_two(xy, product_two(Two(a.hi.z, a.lo.z), Two(b.hi.z, b.lo.z)));
}

// Returns a component of a cross product: u v - w x.
fn minor(u: Two, v: Two, w: Two, x: Two) -> Two {
    let forth = product_two(u, v);
    let back = product_two(w, x);
    return sum_two(forth, Two(-back.hi, -back.lo));
}

// Returns the t at which a ray hits a triangle's plane. Corners are in scene coordinates.
fn plane_t(origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> f32 {
    let x = minor(difference(b.y, a.y), difference(c.z, a.z), difference(b.z, a.z), difference(c.y, a.y));
    var distance = product_two(x, difference(a.x, origin.x));
    var across = product_two(x, Two(direction.x, 0.0));
    let y = minor(difference(b.z, a.z), difference(c.x, a.x), difference(b.x, a.x), difference(c.z, a.z));
    distance = sum_two(distance, product_two(y, difference(a.y, origin.y)));
    across = sum_two(across, product_two(y, Two(direction.y, 0.0)));
    let z = minor(difference(b.x, a.x), difference(c.y, a.y), difference(b.y, a.y), difference(c.x, a.x));
    distance = sum_two(distance, product_two(z, difference(a.z, origin.z)));
    across = sum_two(across, product_two(z, Two(direction.z, 0.0)));
    return distance.hi / across.hi;
}
