// Lens distortion by OpenCV's models (DESIGN, section 2), and its inverse. src/view/camera/warp.rs has the same
// formulas in f64, and checks that the inverse reaches all pixels.

//! use angles, frame, lane

//! if lens is radial or fisheye
// Number of equal parts of the way from the principal point to a pixel. Each part takes one step of Newton's method.
const LENS_PARTS: u32 = 16u;
// Number of all of Newton's steps.
const LENS_STEPS: u32 = 24u;
// Least growth of areas that a footprint takes into account.
const LEAST_GROWTH: f32 = 1e-3;

// A point of the picture for each ray.
struct LensPoint {
    x: F,
    y: F,
}

// Share by which a lens moves points away from its axis, at a squared distance, and its derivative.
struct Excess {
    value: F,
    slope: F,
}

// Returns the place in the picture without distortion that shows the same as a place of the lens's picture. The lens's
// effect is added to the place, so that places don't change without distortion.
fn undistorted(column: F, row: F) -> LensPoint {
    let goal = LensPoint(
        (column - frame.eyes.principal_x) / frame.eyes.focal_x,
        (row - frame.eyes.principal_y) / frame.eyes.focal_y,
    );
    var found = LensPoint(F(0.0), F(0.0));
    var step = 1u;
    loop {
        let share = min(f32(step) / f32(LENS_PARTS), 1.0);
        found = newton_step(found, goal.x * share, goal.y * share);
        step += 1u;
        if step > LENS_STEPS { break; }
    }
    let aside = flat_offset(found, lens_offset(found));
    return LensPoint(column + frame.eyes.focal_x * aside.x, row + frame.eyes.focal_y * aside.y);
}

// Returns by how much distortion moves a point.
fn lens_offset(at: LensPoint) -> LensPoint {
    let square = at.x * at.x + at.y * at.y;
    let share = excess_at(square).value;
    let p1 = frame.eyes.tangential.x;
    let p2 = frame.eyes.tangential.y;
    return LensPoint(
        at.x * share + 2.0 * p1 * at.x * at.y + p2 * (square + 2.0 * at.x * at.x),
        at.y * share + p1 * (square + 2.0 * at.y * at.y) + 2.0 * p2 * at.x * at.y,
    );
}

// Takes a step of Newton's method towards the point that distortion moves to (x, y).
fn newton_step(start: LensPoint, x: F, y: F) -> LensPoint {
    let offset = lens_offset(start);
    let excess = excess_at(start.x * start.x + start.y * start.y);
    let p1 = frame.eyes.tangential.x;
    let p2 = frame.eyes.tangential.y;
    let across = 2.0 * (start.x * start.y * excess.slope + p1 * start.x + p2 * start.y);
    let xx = 1.0 + excess.value + 2.0 * start.x * start.x * excess.slope + 2.0 * p1 * start.y + 6.0 * p2 * start.x;
    let yy = 1.0 + excess.value + 2.0 * start.y * start.y * excess.slope + 6.0 * p1 * start.y + 2.0 * p2 * start.x;
    let miss = LensPoint(x - start.x - offset.x, y - start.y - offset.y);
    let area = xx * yy - across * across;
    return LensPoint(
        start.x + (yy * miss.x - across * miss.y) / area,
        start.y + (xx * miss.y - across * miss.x) / area,
    );
}

//! if lens is radial
fn excess_at(square: F) -> Excess {
    let up = frame.eyes.radial;
    let down = frame.eyes.divisor;
    let top = square * (up.x + square * (up.y + square * up.z));
    let bottom = 1.0 + square * (down.x + square * (down.y + square * down.z));
    let top_slope = up.x + square * (2.0 * up.y + square * (3.0 * up.z));
    let bottom_slope = down.x + square * (2.0 * down.y + square * (3.0 * down.z));
    return Excess(top / bottom, (top_slope * bottom - top * bottom_slope) / (bottom * bottom));
}

// Returns how far an undistorted point lies beside its distorted one, which is `offset` beside it.
fn flat_offset(at: LensPoint, offset: LensPoint) -> LensPoint { return LensPoint(-offset.x, -offset.y); }

// Returns the area in the picture of a unit area at distance 1, at a distance from the axis.
fn growth_at(length: f32) -> f32 {
    let square = length * length;
    let excess = excess_at(F(square));
    let share = of_ray(excess.value, 0u);
    return (1.0 + share) * (1.0 + share + 2.0 * square * of_ray(excess.slope, 0u));
}

//! if lens is fisheye
// Points are directions whose distance from 0 is their angle from the axis.
fn excess_at(square: F) -> Excess {
    let k = frame.eyes.radial;
    return Excess(
        square * (k.x + square * (k.y + square * (k.z + square * k.w))),
        k.x + square * (2.0 * k.y + square * (3.0 * k.z + square * (4.0 * k.w))),
    );
}

fn flat_offset(at: LensPoint, offset: LensPoint) -> LensPoint {
    let angle = sqrt(at.x * at.x + at.y * at.y);
    let tangent = sine(angle) / cosine(angle);
    let longer = select(tangent / angle - 1.0, F(0.0), angle == F(0.0));
    return LensPoint(at.x * longer - offset.x, at.y * longer - offset.y);
}

fn growth_at(length: f32) -> f32 {
    let angle = of_ray(arctangent(F(length), F(1.0)), 0u);
    let square = angle * angle;
    let excess = excess_at(F(square));
    let share = of_ray(excess.value, 0u);
    let flat = (1.0 + share) * (1.0 + share + 2.0 * square * of_ray(excess.slope, 0u));
    return flat * select(angle / length, 1.0, length == 0.0) / (1.0 + length * length);
}
