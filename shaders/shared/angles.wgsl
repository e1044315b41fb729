// Sines and arctangents by polynomials. WGSL's built-in functions may be off by 1/2048 on some adapters, which is much
// more than a texel of a large table. The polynomials are from Abramowitz & Stegun, "Handbook of Mathematical
// Functions", 4.3.97, 4.3.99 and 4.4.49. Their error is below f32 rounding.

//! use lane

const QUARTER_TURN: f32 = 1.57079637;
// Difference between a quarter turn and QUARTER_TURN, radians.
const QUARTER_TURN_LOW: f32 = -4.37113883e-8;

// Both functions take radians, at most a few turns away from 0.
fn sine(x: F) -> F { return turned_sine(x, U(0u)); }
fn cosine(x: F) -> F { return turned_sine(x, U(1u)); }

// Returns the sine of x plus `further` quarter turns.
fn turned_sine(x: F, further: U) -> F {
    let turns = floor(x / QUARTER_TURN + 0.5);
    let y = (x - turns * QUARTER_TURN) - turns * QUARTER_TURN_LOW;
    // Eight quarter turns are added so that the number stays positive.
    let quarter = (U(turns + 8.0) + further) & U(3u);
    let z = y * y;
    let odd = y * (1.0 + z * (-0.1666666664 + z * (0.0083333315 + z * (-0.000198409 + z * 0.0000027526))));
    let even = 1.0 + z * (-0.4999999963 + z * (0.0416666418 + z * (-0.0013888397 + z * 0.0000247609)));
    let value = select(odd, even, (quarter & U(1u)) == U(1u));
    return select(value, -value, quarter >= U(2u));
}

// Returns the angle of (x, y), from -pi to pi; 0 if both are 0.
fn arctangent(y: F, x: F) -> F {
    let across = abs(x);
    let up = abs(y);
    let large = larger(across, up);
    let share = smaller(across, up) / select(large, F(1.0), large == F(0.0));
    let z = share * share;
    let high = 0.0964200441 + z * (-0.0559098861 + z * (0.0218612288 + z * -0.004054058));
    let low = 0.9999993329 + z * (-0.3332985605 + z * (0.1994653599 + z * (-0.1390853351 + z * high)));
    let first = share * low;
    let quarter = select(first, QUARTER_TURN - first, up > across);
    let half = select(quarter, 2.0 * QUARTER_TURN - quarter, x < F(0.0));
    return select(half, -half, y < F(0.0));
}
