// Offsets of jittered samples. All samples of a row are offset from their centres by the same amount (DESIGN, section
// 3). src/sampling/jitter.rs has the same arithmetic.

//! use frame, lane

//! if jitter is rows
// Returns the offset to the right of a row's samples from the centres of their cells, in cell widths. A pixel has
// SAMPLES_SIDE rows. The order of their hashes assigns one stratum to each row.
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
    return hashed(row ^ hashed(U(frame.band.jitter_seed)));
}

// Hashes one word by PCG (O'Neill 2014; Jarzynski & Olano 2020).
fn hashed(words: U) -> U {
    let state = words * 747796405u + 2891336453u;
    let word = ((state >> ((state >> U(28u)) + U(4u))) ^ state) * 277803737u;
    return (word >> U(22u)) ^ word;
}

// Returns the same for one row.
fn row_aside(row: u32) -> f32 {
    return of_ray(sample_aside(U(row)), 0u);
}

// Returns the largest offset of a sample from its cell's centre, in cell widths.
fn jitter_reach() -> f32 {
    return 0.5 - 0.5 / f32(SAMPLES_SIDE);
}

//! if jitter is none
fn row_aside(row: u32) -> f32 {
    return 0.0;
}

fn jitter_reach() -> f32 {
    return 0.0;
}
