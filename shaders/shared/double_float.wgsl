// Numbers stored as sums of two f32, with twice the precision (Dekker 1971; Knuth, TAOCP 2, 4.2.2). They are used if an
// eye or a light is so close to a large triangle or sphere that f32 is too coarse.

//! use fetch

struct Two { hi: f32, lo: f32 }
struct Two3 { hi: vec3f, lo: vec3f }

// Returns the same value, hidden from the compiler. Otherwise a compiler simplifies (a + b) - a to b, and the rounding
// error is lost.
fn opaque3(v: vec3f) -> vec3f {
    return bitcast<vec3f>(bitcast<vec3u>(v) ^ vec3u(bvh.zero));
}

// Returns a - b exactly.
fn difference3(a: vec3f, b: vec3f) -> Two3 {
    let hi = opaque3(a - b);
    let taken = opaque3(hi - a);
    return Two3(hi, (a - (hi - taken)) - (b + taken));
}

fn upper_half3(a: vec3f) -> vec3f {
    let c = a * 4097.0;
    return c - opaque3(c - a);
}

// Returns the componentwise products exactly.
fn exact_product3(a: vec3f, b: vec3f) -> Two3 {
    return product_two3(Two3(a, vec3f(0.0)), Two3(b, vec3f(0.0)));
}

// Returns the componentwise products.
fn product_two3(a: Two3, b: Two3) -> Two3 {
    let hi = a.hi * b.hi;
    let a_high = upper_half3(a.hi);
    let b_high = upper_half3(b.hi);
    let a_low = a.hi - a_high;
    let b_low = b.hi - b_high;
    // Each sum is kept separate, since compilers factor out common terms.
    let first = opaque3(a_high * b_high - hi);
    let second = opaque3(first + a_high * b_low);
    let third = opaque3(second + a_low * b_high);
    let lo = opaque3(third + a_low * b_low);
    return Two3(hi, lo + (a.hi * b.lo + a.lo * b.hi));
}

fn sum_two3(a: Two3, b: Two3) -> Two3 {
    let hi = opaque3(a.hi + b.hi);
    let taken = opaque3(hi - a.hi);
    let lo = (a.hi - (hi - taken)) + (b.hi - taken) + (a.lo + b.lo);
    let sum = opaque3(hi + lo);
    return Two3(sum, lo - (sum - hi));
}

fn sum_two(a: Two, b: Two) -> Two {
    let s = sum_two3(Two3(vec3f(a.hi), vec3f(a.lo)), Two3(vec3f(b.hi), vec3f(b.lo)));
    return Two(s.hi.x, s.lo.x);
}

fn dot_two3(a: Two3, b: Two3) -> Two {
    let p = product_two3(a, b);
    return sum_two(sum_two(Two(p.hi.x, p.lo.x), Two(p.hi.y, p.lo.y)), Two(p.hi.z, p.lo.z));
}

fn product_two(a: Two, b: Two) -> Two {
    let p = product_two3(Two3(vec3f(a.hi), vec3f(a.lo)), Two3(vec3f(b.hi), vec3f(b.lo)));
    return Two(p.hi.x, p.lo.x);
}

fn cross_two3(a: Two3, b: Two3) -> Two3 {
    let forth = product_two3(Two3(a.hi.yzx, a.lo.yzx), Two3(b.hi.zxy, b.lo.zxy));
    let back = product_two3(Two3(a.hi.zxy, a.lo.zxy), Two3(b.hi.yzx, b.lo.yzx));
    return sum_two3(forth, Two3(-back.hi, -back.lo));
}

// Returns the t at which a ray hits a triangle's plane. Corners are in scene coordinates.
fn plane_t(origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> f32 {
    let normal = cross_two3(difference3(b, a), difference3(c, a));
    let distance = dot_two3(normal, difference3(a, origin));
    return distance.hi / dot_two3(normal, Two3(direction, vec3f(0.0))).hi;
}
