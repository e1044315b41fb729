//! Rounds in which all compared variants take turns.

/// Median, minimum and maximum of repeated measurements.
#[derive(Clone, Copy)]
pub struct Spread {
    pub median: f64,
    pub min: f64,
    pub max: f64,
}

impl Spread {
    /// Summarises at least one value.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let middle = values.len() / 2;
        let median = if values.len() % 2 == 1 { values[middle] } else { values[middle - 1].midpoint(values[middle]) };
        Self { median, min: values[0], max: values[values.len() - 1] }
    }

    /// Divides all three values by a number.
    pub fn over(self, divisor: f64) -> Self {
        Self { median: self.median / divisor, min: self.min / divisor, max: self.max / divisor }
    }
}

/// Returns the order of turns in a round. The first turn rotates from round to round, and so does the step between
/// successive turns. Steps that are coprime to `count` visit every turn once.
pub fn order(round: usize, count: usize) -> impl Iterator<Item = usize> {
    let coprime =
        |&step: &usize| (2..=step).all(|factor| !step.is_multiple_of(factor) || !count.is_multiple_of(factor));
    let steps: Vec<usize> = (1..count).filter(coprime).collect();
    let step = steps[round % steps.len()];
    (0..count).map(move |turn| (round + turn * step) % count)
}
