// Where rays go through pixels that are jittered samples: beside the centre, by an offset that a row of samples shares
// (DESIGN, section 3). src/samples/jitter.rs has the same arithmetic.

//! if jitter is rows
// Directions from an eye through jittered samples.
fn pixel_directions(corner: vec3f, pixels: Pixels) -> F3 {
    let row = pixels.y + frame.first_row;
    let x = F(pixels.x) + 0.5 + sample_aside(row);
    let y = F(row) + 0.5;
    return F3(
        corner.x + frame.step_x.x * x + frame.step_y.x * y,
        corner.y + frame.step_x.y * x + frame.step_y.y * y,
        corner.z + frame.step_x.z * x + frame.step_y.z * y,
    );
}

// How far to the right of their cells' middles the samples of a row stand, of a cell's width. The rows of a pixel share
// its columns' SAMPLES_SIDE strata out by the order of their hashes.
fn sample_aside(row: U) -> F {
    let first = row / U(SAMPLES_SIDE) * U(SAMPLES_SIDE);
    let own = row_hash(row);
    var stratum: U;
    var other = 0u;
    loop {
        let another = first + U(other);
        let hash = row_hash(another);
        stratum += select(U(0u), U(1u), (hash < own) | ((hash == own) & (another < row)));
        other += 1u;
        if other >= SAMPLES_SIDE { break; }
    }
    return (F(stratum) + 0.5) / f32(SAMPLES_SIDE) - 0.5;
}

fn row_hash(row: U) -> U {
    return hashed(row ^ hashed(U(frame.jitter_seed)));
}

// PCG (O'Neill 2014) as a hash of one word (Jarzynski & Olano 2020).
fn hashed(words: U) -> U {
    let state = words * 747796405u + 2891336453u;
    let word = ((state >> ((state >> U(28u)) + U(4u))) ^ state) * 277803737u;
    return (word >> U(22u)) ^ word;
}

// How far samples stand beside their cells' middles at most, of a cell's width.
fn jitter_reach() -> f32 {
    return 0.5 - 0.5 / f32(SAMPLES_SIDE);
}

//! if jitter is none
fn jitter_reach() -> f32 {
    return 0.0;
}
